#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "services/bus/bus.hpp"
#include "services/bus/typed.hpp"
#include "services/store/session_reader.hpp"
#include "tests/support/process.hpp"
#include "tests/support/temporary_folder.hpp"

#include <idl/rig.h>
#include <idl/session.h>

namespace tonus::testing {

/// `tonus up` in real time with a domain and a data folder of its own, a short session on it, and an ear on
/// the bus for what the rig says of itself.
class LiveSystem {
 public:
  /// With kYes the rig goes on by itself after a hold or a restart; with kNo it waits for its operator.
  enum class Unattended { kYes, kNo };

  /// Starts the services and waits until they are ready; throws std::runtime_error with what they printed.
  /// `more_options` go to `tonus up`.
  explicit LiveSystem(Unattended unattended = Unattended::kYes, const std::string& dds = "fastdds",
                      double command_timeout_s = 3.0, std::vector<std::string> more_options = {});

  /// Ends all services in order and starts them anew.
  void restart();

  /// Starts `tonus run` with one posture and this many directions, one perturbation each (about 4 s).
  void start_session(int directions);
  /// Waits for its end: the exit code of `tonus run`.
  [[nodiscard]] int finish_session(std::chrono::seconds limit);

  /// Hears the rig until `is_true`, which may look at state() and timing(); false after `limit`.
  [[nodiscard]] bool listen_until(const std::function<bool()>& is_true, std::chrono::seconds limit);
  [[nodiscard]] const std::optional<v1::RigState>& state() const { return state_; }
  [[nodiscard]] const std::optional<v1::RigTiming>& timing() const { return timing_; }

  /// True after the rig has been heard to be in one and the same trial for `samples` samples.
  [[nodiscard]] bool wait_for_mid_trial(std::uint64_t samples, std::chrono::seconds limit);

  /// Runs an operator's command, "clear-fault": its exit code.
  int operate(const std::string& command);
  /// Runs `tonus verify` on the last session of the archive: empty where all is well, else what it prints.
  [[nodiscard]] std::string verify_session();
  /// Phase and what is waited for, as the scheduler last said.
  [[nodiscard]] const std::optional<v1::SessionState>& session() const { return session_; }

  [[nodiscard]] pid_t service(const std::string& program) const;
  /// Stops or continues everything but the rig: the services and the operator's program.
  void signal_others(int signal) const;

  /// The session as the archive holds it.
  [[nodiscard]] store::Session archived() const;
  [[nodiscard]] std::filesystem::path store_file() const { return folder_ / "data" / "archive.sqlite"; }
  [[nodiscard]] std::uint64_t spooled_bytes() const;
  [[nodiscard]] std::string everything_printed() const;

 private:
  void hear();
  void start_services();

  const Unattended unattended_;
  const std::string dds_;
  const std::vector<std::string> more_options_;
  int commands_ = 0;
  TemporaryFolder folder_;
  std::unique_ptr<Process> up_;
  std::unique_ptr<Process> run_;
  std::shared_ptr<bus::Notifier> notifier_;
  std::unique_ptr<bus::Bus> bus_;
  std::optional<bus::TypedReader<v1::RigState>> states_;
  std::optional<bus::TypedReader<v1::RigTiming>> timings_;
  std::optional<bus::TypedReader<v1::SessionState>> sessions_;
  std::optional<v1::SessionState> session_;
  std::optional<v1::RigState> state_;
  std::optional<v1::RigTiming> timing_;
};

/// Empty where the archive holds every sample of every stream from the first to the last, in its coverage and
/// in its blocks; else what is missing.
[[nodiscard]] std::string missing_samples(const std::filesystem::path& store_file);

}  // namespace tonus::testing
