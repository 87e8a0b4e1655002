#include "services/cli/domain_lock.hpp"

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <fcntl.h>
#include <filesystem>
#include <spdlog/fmt/fmt.h>
#include <string>
#include <sys/file.h>
#include <unistd.h>

namespace tonus::cli {

Result<DomainLock> DomainLock::take(int domain) {
  const char* runtime = std::getenv("XDG_RUNTIME_DIR");
  const std::filesystem::path folder = runtime != nullptr && *runtime != '\0' ? runtime : "/tmp";
  const auto path = folder / fmt::format("tonus-domain-{}.lock", domain);
  DomainLock lock(FileDescriptor(open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644)));
  if (!lock.file_.is_open())
    return fail(ErrorCode::kIo, fmt::format("{}: {}", path.string(), std::strerror(errno)));
  if (flock(lock.file_.get(), LOCK_EX | LOCK_NB) != 0) {
    char holder[32] = {};
    if (read(lock.file_.get(), holder, sizeof holder - 1) <= 0) holder[0] = '?';
    return fail(ErrorCode::kAlreadyExists,
                fmt::format("--domain {} is in use by process {}; any other from 0 to 232 is allowed", domain,
                            holder));
  }
  const std::string self = std::to_string(getpid());
  if (ftruncate(lock.file_.get(), 0) != 0 || write(lock.file_.get(), self.data(), self.size()) < 0) {
    return fail(ErrorCode::kIo, fmt::format("{}: {}", path.string(), std::strerror(errno)));
  }
  return lock;
}

}  // namespace tonus::cli
