#include "tests/fault/simulator/disk.hpp"

#include <cerrno>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

namespace tonus::simulator {
namespace {

struct Writing {
  Life* life = nullptr;
  const Disk* disk = nullptr;
};

Writing& writing() {
  static Writing now;
  return now;
}

/// What a write would do to a file: none, or an error number, or a death in the middle.
bool grows(int file, size_t count, off_t offset) {
  struct stat status {};
  return ::fstat(file, &status) == 0 && offset + static_cast<off_t>(count) > status.st_size;
}

/// How many of `count` bytes are written; negative: errno is set. Throws Died after `put` has put the half.
template <typename Put>
ssize_t write_as_life(int file, size_t count, off_t offset, const Put& put) {
  const Writing now = writing();
  if (now.life == nullptr || file <= STDERR_FILENO) return put(count);
  if (now.life->is_dead) return errno = EIO, -1;
  if (now.life->dies_now()) {
    (void)put(count / 2);
    throw Died{};
  }
  if (now.disk->is_full && grows(file, count, offset)) return errno = ENOSPC, -1;
  return put(count);
}

}  // namespace

WritesOf::WritesOf(Life& life, const Disk& disk) { writing() = {&life, &disk}; }
WritesOf::~WritesOf() { writing() = {}; }

}  // namespace tonus::simulator

// In place of the C library's, for everything that this program links.
extern "C" {

ssize_t pwrite(int file, const void* data, size_t count, off_t offset) {
  return tonus::simulator::write_as_life(file, count, offset, [&](size_t part) {
    return static_cast<ssize_t>(::syscall(SYS_pwrite64, file, data, part, offset));
  });
}

ssize_t pwrite64(int file, const void* data, size_t count, off64_t offset) {
  return pwrite(file, data, count, offset);
}

ssize_t write(int file, const void* data, size_t count) {
  const off_t end = ::lseek(file, 0, SEEK_END);
  return tonus::simulator::write_as_life(file, count, end, [&](size_t part) {
    return static_cast<ssize_t>(::syscall(SYS_write, file, data, part));
  });
}

int fsync(int file) {
  return tonus::simulator::writing().life != nullptr ? 0 : static_cast<int>(::syscall(SYS_fsync, file));
}

int fdatasync(int file) {
  return tonus::simulator::writing().life != nullptr ? 0 : static_cast<int>(::syscall(SYS_fdatasync, file));
}

}  // extern "C"
