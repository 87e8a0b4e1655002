#pragma once

#include <string>
#include <sys/types.h>
#include <vector>

namespace tonus::test {

/// A program that a test runs beside itself. It is killed when this object goes.
class ChildProcess {
 public:
  /// Starts it with its standard output in a pipe. The first argument is the program's path.
  explicit ChildProcess(const std::vector<std::string>& arguments);
  ~ChildProcess();
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  [[nodiscard]] bool is_running() const { return pid_ > 0; }
  void send_signal(int signal) const;
  void kill();  ///< SIGKILL, and waits until it is gone.

  /// The complete lines that it has written since the last call; does not wait.
  [[nodiscard]] std::vector<std::string> take_lines();

 private:
  pid_t pid_ = -1;
  int output_ = -1;
  std::string partial_;
};

}  // namespace tonus::test
