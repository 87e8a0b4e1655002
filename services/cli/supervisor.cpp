#include "services/cli/supervisor.hpp"

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <fcntl.h>
#include <fstream>
#include <spdlog/fmt/fmt.h>

#include "services/core/file_descriptor.hpp"

namespace tonus::cli {
namespace {

constexpr std::chrono::milliseconds kLongestPause{5000};
constexpr std::chrono::seconds kStopPatience{5};

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
  const FileDescriptor log(open(log_of(child).c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644));
  if (!log.is_open())
    return fail(ErrorCode::kIo, fmt::format("{}: {}", log_of(child).string(), std::strerror(errno)));
  TONUS_TRY_ASSIGN(child.process, ChildProcess::start(words, {log.get(), {}, {}}));
  child.started = clock_->now();
  return {};
}

Result<std::vector<std::string>> Supervisor::poll() {
  std::vector<std::string> news;
  for (auto& child : children_) {
    if (const auto end = child.process ? child.process->poll() : std::nullopt) {
      child.process.reset();
      const auto lived = clock_->now() - child.started;
      const bool refused = !end->is_signal && (end->number == 1 || end->number == 2);
      if (refused && child.restarts == 0 && lived < std::chrono::seconds(1)) {
        return fail(ErrorCode::kInvalidArgument, last_words(child));
      }
      if (lived > kLongestPause) child.pause = std::chrono::milliseconds(200);
      child.restart_at = clock_->now() + child.pause;
      news.push_back(fmt::format("{} {}; starting it again in {:.1f} s", child.command.name, end->text(),
                                 std::chrono::duration<double>(child.pause).count()));
      child.pause = std::min(2 * child.pause, kLongestPause);
    }
    if (!child.process && clock_->now() >= child.restart_at) {
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
    if (child.process && is_meant(child)) child.process->signal(SIGTERM);
  }
  const auto deadline = std::chrono::steady_clock::now() + kStopPatience;
  for (auto& child : children_) {
    if (!child.process || !is_meant(child)) continue;
    const auto left = deadline - std::chrono::steady_clock::now();
    (void)child.process->wait_for(std::chrono::duration_cast<std::chrono::milliseconds>(left));
    child.process.reset();  // kills it if it still runs
  }
}

pid_t Supervisor::process_of(const std::string& name) const {
  for (const auto& child : children_) {
    if (child.command.name == name) return child.process ? child.process->id() : 0;
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
