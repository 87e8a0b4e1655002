#include "services/store/store_lock.hpp"

#include <cerrno>
#include <chrono>
#include <cstring>
#include <fcntl.h>
#include <spdlog/fmt/fmt.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <thread>
#include <unistd.h>

namespace tonus::store {
namespace {

/// True where the open file is still the one of that name: its last owner may have removed it before we had
/// the lock.
bool is_still_there(const std::string& path, int descriptor) {
  struct stat named {};
  struct stat opened {};
  return ::stat(path.c_str(), &named) == 0 && ::fstat(descriptor, &opened) == 0 &&
         named.st_ino == opened.st_ino && named.st_dev == opened.st_dev;
}

/// A reader that looks whether the lock is taken holds it for a moment.
bool lock_patiently(int descriptor) {
  constexpr int kTries = 5;
  for (int i = 0; i < kTries; ++i) {
    if (::flock(descriptor, LOCK_EX | LOCK_NB) == 0) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return false;
}

}  // namespace

Result<StoreLock> StoreLock::take(const std::string& store_path) {
  const std::string path = store_path + "-lock";
  while (true) {
    StoreLock lock(path, FileDescriptor(::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644)));
    if (!lock.file_.is_open()) {
      return fail(ErrorCode::kIo, fmt::format("store '{}': cannot be opened for writing: {}", store_path,
                                              std::strerror(errno)));
    }
    if (!lock_patiently(lock.file_.get())) {
      (void)lock.file_.close();  // not ours to remove
      return fail(
          ErrorCode::kUnavailable,
          fmt::format("store '{}': is in use: another archive writes it, and one may at a time", store_path));
    }
    if (is_still_there(path, lock.file_.get())) return lock;
    (void)lock.file_.close();
  }
}

bool StoreLock::is_taken(const std::string& store_path) {
  const FileDescriptor file(::open((store_path + "-lock").c_str(), O_RDONLY | O_CLOEXEC));
  if (!file.is_open()) return errno == EACCES;  // it is there, and cannot be asked
  return ::flock(file.get(), LOCK_SH | LOCK_NB) != 0;
}

StoreLock::~StoreLock() {
  if (file_.is_open()) ::unlink(path_.c_str());
}

}  // namespace tonus::store
