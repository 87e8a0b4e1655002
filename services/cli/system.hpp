#pragma once

#include <optional>
#include <string>
#include <vector>

#include "services/cli/supervisor.hpp"
#include "services/core/machine_lock.hpp"
#include "services/runtime/options.hpp"

namespace CLI {
class App;
}  // namespace CLI

namespace tonus::cli {

/// What `tonus up` and `tonus demo` are told of the services that they start. Each text is handed on to the
/// service whose option it is; empty: not said.
struct SystemOptions {
  runtime::CommonOptions common;
  std::string rig_dds;  ///< DDS of the rig agent where it differs from the others'.
  std::string speed = "real";
  std::string driver = "simulated";
  std::string driver_file;
  std::string driver_options;
  std::string profile;
  std::string dataset;
  std::string force_sign;
  std::string seed;
  std::string loop_cpu;
  std::string loop_priority;
  bool resumes_unattended = false;
  std::string natural_frequency;
  std::string damping_ratio;
  std::string window;
  std::string method;
  std::string store;
  bool has_dashboard = false;
  std::string dashboard_listen;
  std::string dashboard_tokens;
  std::string dashboard_certificate;
  std::string dashboard_key;
  std::vector<std::string> dashboard_origins;
};

void add_system_options(CLI::App& app, SystemOptions& options);

/// All services of one machine under supervision, in a domain of their own.
class System {
 public:
  [[nodiscard]] static Result<System> start(const SystemOptions& options, const Clock& clock);

  /// Starts again what has died, and says so on standard error, a line each after the program's name.
  [[nodiscard]] Result<void> supervise(const char* program);

  [[nodiscard]] Supervisor& supervisor() { return supervisor_; }
  [[nodiscard]] const std::filesystem::path& data() const { return data_; }

 private:
  System(MachineLock lock, std::filesystem::path data, Supervisor supervisor)
      : lock_(std::move(lock)), data_(std::move(data)), supervisor_(std::move(supervisor)) {}

  MachineLock lock_;  // of the domain: two systems of one machine do not share one
  std::filesystem::path data_;
  Supervisor supervisor_;
};

}  // namespace tonus::cli
