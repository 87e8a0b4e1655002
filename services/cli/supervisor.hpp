#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <sys/types.h>
#include <vector>

#include "services/core/clock.hpp"
#include "services/core/process.hpp"
#include "services/core/result.hpp"

namespace tonus::cli {

/// A program to keep running.
struct ServiceCommand {
  std::string name;  ///< For messages and the log file, "archive".
  std::filesystem::path program;
  std::vector<std::string> arguments;
  bool ends_last = false;  ///< Is stopped after the others: it records what they say.
};

/// Starts the services of one machine and starts again each one that dies, after a pause that doubles from
/// 0.2 s to 5 s while it keeps dying. Their standard error goes to <logs>/<name>.log. They get SIGTERM when
/// the supervisor ends, also when it is killed. One thread; poll() is to be called a few times a second.
class Supervisor {
 public:
  [[nodiscard]] static Result<Supervisor> start(std::vector<ServiceCommand> services,
                                                std::filesystem::path logs, const Clock& clock);
  Supervisor(Supervisor&&) = default;
  Supervisor& operator=(Supervisor&&) = delete;
  ~Supervisor() { stop(); }

  /// Restarts what has died; returns a line for a person about each death. A service that refuses its own
  /// command line (exit code 1 or 2 within a second of its first start) is an error: its last words.
  [[nodiscard]] Result<std::vector<std::string>> poll();

  /// SIGTERM to all, to those that end last once the others have ended, and SIGKILL to those that still run
  /// 5 s later.
  void stop();

  /// Process id of a service that runs, 0 for one that does not.
  [[nodiscard]] pid_t process_of(const std::string& name) const;

 private:
  struct Child {
    ServiceCommand command;
    std::optional<ChildProcess> process;
    Clock::TimePoint started;
    Clock::TimePoint restart_at;
    std::chrono::milliseconds pause{200};
    int restarts = 0;
  };

  Supervisor(std::filesystem::path logs, const Clock& clock) : logs_(std::move(logs)), clock_(&clock) {}
  [[nodiscard]] Result<void> launch(Child& child);
  void stop_those(const std::function<bool(const Child&)>& is_meant);
  [[nodiscard]] std::filesystem::path log_of(const Child& child) const {
    return logs_ / (child.command.name + ".log");
  }
  [[nodiscard]] std::string last_words(const Child& child) const;

  std::filesystem::path logs_;
  const Clock* clock_;
  std::vector<Child> children_;
};

}  // namespace tonus::cli
