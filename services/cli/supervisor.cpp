#include "services/cli/supervisor.hpp"

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <fcntl.h>
#include <fstream>
#include <spdlog/fmt/fmt.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>

#include "services/core/lifetime.hpp"

namespace tonus::cli {
namespace {

constexpr std::chrono::milliseconds kLongestPause{5000};
constexpr std::chrono::seconds kStopPatience{5};

std::string how_it_ended(int status) {
  if (WIFSIGNALED(status)) return fmt::format("was ended by signal {}", WTERMSIG(status));
  return fmt::format("ended with exit code {}", WEXITSTATUS(status));
}

/// In the child, between fork and exec: only calls that are safe there.
[[noreturn]] void become(const std::vector<char*>& arguments, int log) {
  prctl(PR_SET_PDEATHSIG, SIGTERM);
  setpgid(0, 0);  // a Ctrl-C at the terminal is the supervisor's to pass on
  unblock_stop_signals();
  dup2(log, STDOUT_FILENO);
  dup2(log, STDERR_FILENO);
  const int null = open("/dev/null", O_RDONLY | O_CLOEXEC);
  if (null >= 0) dup2(null, STDIN_FILENO);
  execv(arguments[0], arguments.data());
  _exit(127);
}

}  // namespace

Result<Supervisor> Supervisor::start(std::vector<ServiceCommand> services, std::filesystem::path logs,
                                     const Clock& clock) {
  std::error_code error;
  std::filesystem::create_directories(logs, error);
  if (error) return fail(ErrorCode::kIo, fmt::format("{}: {}", logs.string(), error.message()));
  Supervisor supervisor(std::move(logs), clock);
  for (auto& service : services) {
    Child child;
    child.command = std::move(service);
    if (auto launched = supervisor.launch(child); !launched) return launched.error();
    supervisor.children_.push_back(std::move(child));
  }
  return supervisor;
}

Result<void> Supervisor::launch(Child& child) {
  std::vector<std::string> words{child.command.program.string()};
  words.insert(words.end(), child.command.arguments.begin(), child.command.arguments.end());
  std::vector<char*> arguments;
  for (auto& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  if (access(arguments[0], X_OK) != 0) {
    return fail(ErrorCode::kNotFound,
                fmt::format("{}: {}; a program is needed", words[0], std::strerror(errno)));
  }
  const int log = open(log_of(child).c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644);
  if (log < 0)
    return fail(ErrorCode::kIo, fmt::format("{}: {}", log_of(child).string(), std::strerror(errno)));

  const pid_t process = fork();
  if (process == 0) become(arguments, log);
  close(log);
  if (process < 0)
    return fail(ErrorCode::kUnavailable, fmt::format("cannot start {}: {}", words[0], std::strerror(errno)));
  child.process = process;
  child.started = clock_->now();
  return {};
}

Result<std::vector<std::string>> Supervisor::poll() {
  std::vector<std::string> news;
  for (auto& child : children_) {
    int status = 0;
    if (child.process != 0 && waitpid(child.process, &status, WNOHANG) == child.process) {
      child.process = 0;
      const auto lived = clock_->now() - child.started;
      const bool refused = WIFEXITED(status) && (WEXITSTATUS(status) == 1 || WEXITSTATUS(status) == 2);
      if (refused && child.restarts == 0 && lived < std::chrono::seconds(1)) {
        return fail(ErrorCode::kInvalidArgument, last_words(child));
      }
      if (lived > kLongestPause) child.pause = std::chrono::milliseconds(200);
      child.restart_at = clock_->now() + child.pause;
      news.push_back(fmt::format("{} {}; starting it again in {:.1f} s", child.command.name,
                                 how_it_ended(status), std::chrono::duration<double>(child.pause).count()));
      child.pause = std::min(2 * child.pause, kLongestPause);
    }
    if (child.process == 0 && clock_->now() >= child.restart_at) {
      ++child.restarts;
      if (auto launched = launch(child); !launched) return launched.error();
    }
  }
  return news;
}

void Supervisor::stop() {
  stop_those([](const Child& child) { return !child.command.ends_last; });
  stop_those([](const Child&) { return true; });
  children_.clear();
}

void Supervisor::stop_those(const std::function<bool(const Child&)>& is_meant) {
  for (const auto& child : children_) {
    if (child.process != 0 && is_meant(child)) kill(child.process, SIGTERM);
  }
  const auto deadline = std::chrono::steady_clock::now() + kStopPatience;
  for (auto& child : children_) {
    if (!is_meant(child)) continue;
    while (child.process != 0 && waitpid(child.process, nullptr, WNOHANG) == 0) {
      if (std::chrono::steady_clock::now() > deadline) {
        kill(child.process, SIGKILL);
        waitpid(child.process, nullptr, 0);
        break;
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    child.process = 0;
  }
}

pid_t Supervisor::process_of(const std::string& name) const {
  for (const auto& child : children_) {
    if (child.command.name == name) return child.process;
  }
  return 0;
}

std::string Supervisor::last_words(const Child& child) const {
  std::ifstream log(log_of(child));
  std::string line;
  std::string last = child.command.name + " ended at once and said nothing";
  while (std::getline(log, line)) {
    if (!line.empty()) last = line;
  }
  return last;
}

}  // namespace tonus::cli
