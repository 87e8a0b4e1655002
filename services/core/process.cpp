#include "services/core/process.hpp"

#include <array>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <fcntl.h>
#include <spdlog/fmt/fmt.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>
#include <utility>

#include "services/core/file_descriptor.hpp"
#include "services/core/folder.hpp"

namespace tonus {
namespace {

constexpr std::chrono::milliseconds kLook{2};

ProcessEnd end_of(int status) {
  if (WIFSIGNALED(status)) return {true, WTERMSIG(status)};
  return {false, WEXITSTATUS(status)};
}

/// What the child needs between fork and exec, made before the fork: only calls that are safe there follow.
struct Prepared {
  std::vector<char*> arguments;
  std::vector<char*> environment;
  const char* folder = nullptr;
  int output = -1;
  int failure = -1;  ///< Closed by a successful exec; otherwise it gets errno.
  pid_t parent = 0;
};

[[noreturn]] void become(const Prepared& p) {
  prctl(PR_SET_PDEATHSIG, SIGTERM);
  if (getppid() != p.parent) _exit(127);  // the parent ended before the line above
  setpgid(0, 0);
  sigset_t none;
  sigemptyset(&none);
  sigprocmask(SIG_SETMASK, &none, nullptr);
  const int null = open("/dev/null", O_RDWR | O_CLOEXEC);
  const int output = p.output >= 0 ? p.output : null;
  const bool is_ready = null >= 0 && dup2(null, STDIN_FILENO) >= 0 && dup2(output, STDOUT_FILENO) >= 0 &&
                        dup2(output, STDERR_FILENO) >= 0 && (p.folder == nullptr || chdir(p.folder) == 0);
  if (is_ready) execve(p.arguments[0], p.arguments.data(), p.environment.data());
  const int error = errno;
  (void)!write(p.failure, &error, sizeof error);
  _exit(127);
}

/// The parent's environment with those of `own` in place of variables of the same name.
std::vector<char*> environment_with(std::vector<std::string>& own) {
  std::vector<char*> all;
  for (char** entry = environ; *entry != nullptr; ++entry) {
    const std::string_view inherited(*entry);
    const auto name = inherited.substr(0, inherited.find('=') + 1);
    bool is_replaced = false;
    for (const auto& variable : own) is_replaced |= std::string_view(variable).starts_with(name);
    if (!is_replaced) all.push_back(*entry);
  }
  for (auto& variable : own) all.push_back(variable.data());
  all.push_back(nullptr);
  return all;
}

Error start_failed(const std::string& program, int error) {
  return fail(error == ENOENT ? ErrorCode::kNotFound : ErrorCode::kUnavailable,
              fmt::format("start of {} failed: {}", program, std::strerror(error)));
}

}  // namespace

std::string ProcessEnd::text() const {
  return is_signal ? fmt::format("was ended by signal {}", number)
                   : fmt::format("ended with exit code {}", number);
}

std::optional<std::filesystem::path> find_program(std::string_view name) {
  const auto is_program = [](const std::filesystem::path& file) {
    std::error_code error;
    return std::filesystem::is_regular_file(file, error) && access(file.c_str(), X_OK) == 0;
  };
  if (name.find('/') != std::string_view::npos)
    return is_program(name) ? std::optional<std::filesystem::path>(name) : std::nullopt;
  const char* path = std::getenv("PATH");
  std::string_view folders = path != nullptr ? path : "/usr/bin:/bin";
  while (!name.empty() && !folders.empty()) {
    const auto end = std::min(folders.find(':'), folders.size());
    const auto file = std::filesystem::path(folders.substr(0, end)) / name;
    if (is_program(file)) return file;
    folders.remove_prefix(std::min(end + 1, folders.size()));
  }
  return std::nullopt;
}

Result<ChildProcess> ChildProcess::start(const std::vector<std::string>& words,
                                         const ProcessOptions& options) {
  if (words.empty()) return fail(ErrorCode::kInvalidArgument, "program: '' is not allowed; expected a name");
  auto own_words = words;
  auto own_environment = options.environment;
  const auto program = find_program(words[0]);
  if (!program) return start_failed(words[0], access(words[0].c_str(), F_OK) == 0 ? EACCES : ENOENT);
  TONUS_TRY_ASSIGN(const auto absolute, absolute_path(*program));
  own_words[0] = absolute.string();

  std::array<int, 2> ends{-1, -1};
  if (pipe2(ends.data(), O_CLOEXEC) != 0) return start_failed(words[0], errno);
  FileDescriptor reading(ends[0]);
  FileDescriptor writing(ends[1]);
  Prepared prepared;
  for (auto& word : own_words) prepared.arguments.push_back(word.data());
  prepared.arguments.push_back(nullptr);
  prepared.environment = environment_with(own_environment);
  prepared.folder = options.folder.empty() ? nullptr : options.folder.c_str();
  prepared.output = options.output;
  prepared.failure = writing.get();
  prepared.parent = getpid();

  const pid_t id = fork();
  if (id == 0) become(prepared);
  if (id < 0) return start_failed(words[0], errno);
  ChildProcess child(id);
  (void)writing.close();
  int error = 0;
  ssize_t got = 0;
  do got = read(reading.get(), &error, sizeof error);
  while (got < 0 && errno == EINTR);
  if (got > 0) return start_failed(words[0], error);
  return child;
}

ChildProcess::ChildProcess(ChildProcess&& other) noexcept
    : id_(std::exchange(other.id_, 0)), end_(other.end_) {}

ChildProcess& ChildProcess::operator=(ChildProcess&& other) noexcept {
  std::swap(id_, other.id_);
  std::swap(end_, other.end_);
  return *this;
}

ChildProcess::~ChildProcess() {
  if (id_ != 0 && !end_) kill_now();
}

void ChildProcess::signal(int number) const {
  if (id_ != 0 && !end_) kill(id_, number);
}

std::optional<ProcessEnd> ChildProcess::poll() {
  int status = 0;
  if (id_ != 0 && !end_ && waitpid(id_, &status, WNOHANG) == id_) end_ = end_of(status);
  return end_;
}

ProcessEnd ChildProcess::wait() {
  int status = 0;
  while (id_ != 0 && !end_) {
    if (waitpid(id_, &status, 0) == id_) end_ = end_of(status);
  }
  return end_.value_or(ProcessEnd{});
}

std::optional<ProcessEnd> ChildProcess::wait_for(std::chrono::milliseconds limit) {
  const auto deadline = std::chrono::steady_clock::now() + limit;
  while (!poll() && std::chrono::steady_clock::now() < deadline) std::this_thread::sleep_for(kLook);
  return end_;
}

ProcessEnd ChildProcess::stop(std::chrono::milliseconds patience) {
  signal(SIGTERM);
  if (!wait_for(patience)) kill_now();
  return wait();
}

void ChildProcess::kill_now() {
  kill(-id_, SIGKILL);
  kill(id_, SIGKILL);
  (void)wait();
}

Result<ProcessEnd> run_process(const std::vector<std::string>& words, const ProcessOptions& options) {
  TONUS_TRY_ASSIGN(auto child, ChildProcess::start(words, options));
  return child.wait();
}

}  // namespace tonus
