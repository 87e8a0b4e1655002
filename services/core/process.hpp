#pragma once

#include <chrono>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <sys/types.h>
#include <vector>

#include "services/core/result.hpp"

namespace tonus {

/// How a process ended.
struct ProcessEnd {
  bool is_signal = false;  ///< Ended by a signal; otherwise it exited.
  int number = 0;          ///< The signal, or the exit code.

  [[nodiscard]] bool is_success() const { return !is_signal && number == 0; }
  /// "ended with exit code 3" or "was ended by signal 9".
  [[nodiscard]] std::string text() const;
};

/// What a child gets besides its arguments.
struct ProcessOptions {
  int output = -1;               ///< Descriptor for standard output and error; -1: both are discarded.
  std::filesystem::path folder;  ///< Working folder; empty: the parent's.
  std::vector<std::string> environment;  ///< "NAME=value", each in place of the parent's.
};

/// The program `name` as the shell would find it: by PATH unless it has a slash. Nothing where there is none.
[[nodiscard]] std::optional<std::filesystem::path> find_program(std::string_view name);

/// A child process, run without a shell. It has a process group of its own (a Ctrl-C at the terminal is the
/// parent's to pass on), no blocked signals, nothing on its standard input, and gets SIGTERM when the thread
/// that started it ends, however that happens. One thread at a time. Boost.Process 1.74 offers neither the
/// parent's death signal without a hook of our own after the fork, nor a wait with a limit that it calls
/// reliable.
class ChildProcess {
 public:
  /// `words` are the program (find_program) and its arguments. An error where it cannot be executed.
  [[nodiscard]] static Result<ChildProcess> start(const std::vector<std::string>& words,
                                                  const ProcessOptions& options);
  ChildProcess(ChildProcess&& other) noexcept;
  ChildProcess& operator=(ChildProcess&& other) noexcept;
  /// Kills it, if nobody has seen its end.
  ~ChildProcess();

  [[nodiscard]] pid_t id() const { return id_; }
  /// Nothing happens once its end has been seen: the id may belong to another process then.
  void signal(int number) const;
  /// Its end, as soon as it is known; does not wait.
  [[nodiscard]] std::optional<ProcessEnd> poll();
  [[nodiscard]] ProcessEnd wait();
  /// Nothing if it still runs after `limit`.
  [[nodiscard]] std::optional<ProcessEnd> wait_for(std::chrono::milliseconds limit);
  /// SIGTERM, and SIGKILL to its whole group if it still runs after `patience`.
  ProcessEnd stop(std::chrono::milliseconds patience);

 private:
  explicit ChildProcess(pid_t id) : id_(id) {}
  void kill_now();

  pid_t id_ = 0;  ///< 0: moved from.
  std::optional<ProcessEnd> end_;
};

/// Starts it and waits for its end.
[[nodiscard]] Result<ProcessEnd> run_process(const std::vector<std::string>& words,
                                             const ProcessOptions& options);

}  // namespace tonus
