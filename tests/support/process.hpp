#pragma once

#include <chrono>
#include <filesystem>
#include <optional>
#include <string>
#include <sys/types.h>
#include <vector>

#include "services/core/process.hpp"

namespace tonus::testing {

/// A child process of a test, with its output in a file. The destructor ends it, and its descendants with it.
class Process {
 public:
  /// Starts `program` in a process group of its own; standard output and error go to `output`.
  Process(const std::filesystem::path& program, const std::vector<std::string>& arguments,
          std::filesystem::path output);
  ~Process() { process_->stop(std::chrono::seconds(10)); }
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;

  void signal(int number) const { process_->signal(number); }

  /// Exit code, or -signal; kStillRunning after `limit`.
  [[nodiscard]] int wait(std::chrono::milliseconds limit);
  static constexpr int kStillRunning = -1000;

  /// Everything that it has printed so far.
  [[nodiscard]] std::string output() const;

  /// True as soon as `text` has been printed; false after `limit` or when the process has ended without it.
  [[nodiscard]] bool wait_for_output(const std::string& text, std::chrono::milliseconds limit);

  [[nodiscard]] pid_t id() const { return process_->id(); }

 private:
  std::filesystem::path output_;
  std::optional<ChildProcess> process_;
};

/// The only child of `parent` whose program has this name, 0 if there is none now.
[[nodiscard]] pid_t child_named(pid_t parent, const std::string& program);

/// Where the build put the programs of the system (or the folder that the environment's TONUS_PROGRAMS
/// names), and the protocols and profiles of the source tree.
[[nodiscard]] std::filesystem::path program(const std::string& name);
[[nodiscard]] std::filesystem::path source_file(const std::string& path);

/// A DDS domain that no other test process of this machine uses now, 100 to 219; kept until the process ends.
[[nodiscard]] int own_domain();

}  // namespace tonus::testing
