#include "tests/support/process.hpp"

#include <cstdlib>
#include <fcntl.h>
#include <fstream>
#include <functional>
#include <sstream>
#include <stdexcept>
#include <sys/file.h>
#include <thread>
#include <unistd.h>

#include "services/core/file_descriptor.hpp"

namespace tonus::testing {
namespace {

constexpr std::chrono::milliseconds kLook{5};

bool wait_until(const std::function<bool()>& done, std::chrono::milliseconds limit) {
  const auto deadline = std::chrono::steady_clock::now() + limit;
  while (!done()) {
    if (std::chrono::steady_clock::now() > deadline) return false;
    std::this_thread::sleep_for(kLook);
  }
  return true;
}

}  // namespace

Process::Process(const std::filesystem::path& program, const std::vector<std::string>& arguments,
                 std::filesystem::path output)
    : output_(std::move(output)) {
  std::vector<std::string> words{program.string()};
  words.insert(words.end(), arguments.begin(), arguments.end());
  const FileDescriptor file(open(output_.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_APPEND | O_CLOEXEC, 0644));
  auto started = ChildProcess::start(words, {file.get(), {}, {}});
  if (!started) throw std::runtime_error(started.error().message);
  process_ = *std::move(started);
}

int Process::wait(std::chrono::milliseconds limit) {
  const auto end = process_->wait_for(limit);
  if (!end) return kStillRunning;
  return end->is_signal ? -end->number : end->number;
}

std::string Process::output() const {
  std::ifstream file(output_);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

bool Process::wait_for_output(const std::string& text, std::chrono::milliseconds limit) {
  wait_until(
      [&] {
        return output().find(text) != std::string::npos ||
               wait(std::chrono::milliseconds(0)) != kStillRunning;
      },
      limit);
  return output().find(text) != std::string::npos;
}

pid_t child_named(pid_t parent, const std::string& program) {
  const std::string file =
      "/proc/" + std::to_string(parent) + "/task/" + std::to_string(parent) + "/children";
  std::ifstream children(file);
  pid_t child = 0;
  while (children >> child) {
    std::error_code error;
    const auto path = std::filesystem::read_symlink("/proc/" + std::to_string(child) + "/exe", error);
    if (!error && path.filename() == program) return child;
  }
  return 0;
}

std::filesystem::path program(const std::string& name) {
  const char* elsewhere = std::getenv("TONUS_PROGRAMS");
  return std::filesystem::path(elsewhere != nullptr ? elsewhere : TONUS_PROGRAMS) / name;
}

std::filesystem::path source_file(const std::string& path) {
  return std::filesystem::path(TONUS_SOURCE) / path;
}

int own_domain() {
  static const int domain = [] {
    const int start = static_cast<int>(getpid() % 120);
    for (int i = 0; i < 120; ++i) {
      const int candidate = 100 + (start + i) % 120;
      const std::string path = "/tmp/tonus-test-domain-" + std::to_string(candidate) + ".lock";
      const int file = open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
      if (file >= 0 && flock(file, LOCK_EX | LOCK_NB) == 0)
        return candidate;  // kept open until the process ends
      if (file >= 0) close(file);
    }
    throw std::runtime_error("no DDS domain from 100 to 219 is free");
  }();
  return domain;
}

}  // namespace tonus::testing
