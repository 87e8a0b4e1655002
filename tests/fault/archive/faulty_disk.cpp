#include "tests/fault/archive/faulty_disk.hpp"

#include <algorithm>
#include <fcntl.h>
#include <functional>
#include <new>
#include <span>
#include <sqlite3.h>
#include <stdexcept>
#include <sys/stat.h>
#include <unistd.h>

namespace tonus::archive::testing {
namespace {

constexpr std::uint64_t kSector = 512;

}  // namespace

struct FaultyDisk::File {
  sqlite3_file base;
  FaultyDisk* disk;
  std::string* path;   ///< Null: a temporary file, which is left alone.
  sqlite3_file* real;  ///< Follows this structure in memory.

  static File& of(sqlite3_file* file) { return *reinterpret_cast<File*>(file); }
};

/// Where changes are undone and made again: an open file, or one of a dead process.
struct FaultyDisk::Target {
  std::function<void(std::uint64_t offset, std::span<const std::byte>)> write;
  std::function<void(std::uint64_t size)> resize;
};

/// SQLite's view of a file: what is not counted goes to the real one as it is.
struct FaultyDisk::Methods {
  static sqlite3_file* real(sqlite3_file* file) { return File::of(file).real; }

  static std::uint64_t size(sqlite3_file* file) {
    sqlite3_int64 bytes = 0;
    real(file)->pMethods->xFileSize(real(file), &bytes);
    return static_cast<std::uint64_t>(bytes);
  }

  static std::vector<std::byte> read_back(sqlite3_file* file, std::uint64_t offset, std::uint64_t length) {
    const std::uint64_t end = std::min(size(file), offset + length);
    std::vector<std::byte> bytes(end > offset ? end - offset : 0);
    if (!bytes.empty()) {
      real(file)->pMethods->xRead(real(file), bytes.data(), static_cast<int>(bytes.size()),
                                  static_cast<sqlite3_int64>(offset));
    }
    return bytes;
  }

  static int close(sqlite3_file* file) {
    File& self = File::of(file);
    const int code = self.real->pMethods == nullptr ? SQLITE_OK : self.real->pMethods->xClose(self.real);
    delete self.path;
    self.path = nullptr;
    return code;
  }

  static int read(sqlite3_file* file, void* bytes, int length, sqlite3_int64 offset) {
    return real(file)->pMethods->xRead(real(file), bytes, length, offset);
  }

  static int write(sqlite3_file* file, const void* bytes, int length, sqlite3_int64 offset) {
    File& self = File::of(file);
    if (self.path == nullptr) return self.real->pMethods->xWrite(self.real, bytes, length, offset);
    Failure failure{};
    const bool is_refused = self.disk->is_refused(&failure);
    if (is_refused && failure == Failure::kError && self.disk->is_heads()) length /= 2;
    const auto* first = static_cast<const std::byte*>(bytes);
    const auto at = static_cast<std::uint64_t>(offset);
    const auto count = static_cast<std::uint64_t>(length);
    const std::uint64_t size_before = size(file);
    Change change{at,
                  read_back(file, at, count),
                  {first, first + length},
                  size_before,
                  std::max(size_before, at + count)};
    const int code = self.real->pMethods->xWrite(self.real, bytes, length, offset);
    self.disk->unsynced_[*self.path].changes.push_back(std::move(change));
    return is_refused ? SQLITE_IOERR_WRITE : code;
  }

  static int truncate(sqlite3_file* file, sqlite3_int64 bytes) {
    File& self = File::of(file);
    if (self.path == nullptr) return self.real->pMethods->xTruncate(self.real, bytes);
    Failure failure{};
    if (self.disk->is_refused(&failure)) return SQLITE_IOERR_TRUNCATE;
    const auto wanted = static_cast<std::uint64_t>(bytes);
    const std::uint64_t size_before = size(file);
    const std::uint64_t tail = size_before > wanted ? size_before - wanted : 0;
    Change change{wanted, read_back(file, wanted, tail), {}, size_before, wanted};
    const int code = self.real->pMethods->xTruncate(self.real, bytes);
    self.disk->unsynced_[*self.path].changes.push_back(std::move(change));
    return code;
  }

  static int sync(sqlite3_file* file, int flags) {
    File& self = File::of(file);
    if (self.path == nullptr) return self.real->pMethods->xSync(self.real, flags);
    Failure failure{};
    Unsynced& unsynced = self.disk->unsynced_[*self.path];
    if (!self.disk->is_refused(&failure)) {
      unsynced = {};  // durable from here on; the real disk need not be waited for
      return SQLITE_OK;
    }
    if (failure == Failure::kError) {
      const Target target{[&self](std::uint64_t offset, std::span<const std::byte> bytes) {
                            self.real->pMethods->xWrite(self.real, bytes.data(),
                                                        static_cast<int>(bytes.size()),
                                                        static_cast<sqlite3_int64>(offset));
                          },
                          [&self](std::uint64_t to) {
                            self.real->pMethods->xTruncate(self.real, static_cast<sqlite3_int64>(to));
                          }};
      self.disk->undo(unsynced, target);
      self.disk->redo_some(unsynced, target);
      unsynced.changes.clear();
    }
    return SQLITE_IOERR_FSYNC;
  }

  static int file_size(sqlite3_file* file, sqlite3_int64* bytes) {
    return real(file)->pMethods->xFileSize(real(file), bytes);
  }
  static int lock(sqlite3_file* file, int level) { return real(file)->pMethods->xLock(real(file), level); }
  static int unlock(sqlite3_file* file, int level) {
    return real(file)->pMethods->xUnlock(real(file), level);
  }
  static int check_reserved_lock(sqlite3_file* file, int* is_taken) {
    return real(file)->pMethods->xCheckReservedLock(real(file), is_taken);
  }
  static int file_control(sqlite3_file* file, int what, void* argument) {
    return real(file)->pMethods->xFileControl(real(file), what, argument);
  }
  static int sector_size(sqlite3_file* file) { return real(file)->pMethods->xSectorSize(real(file)); }
  static int characteristics(sqlite3_file* file) {
    return real(file)->pMethods->xDeviceCharacteristics(real(file));
  }
  static int shm_map(sqlite3_file* file, int page, int bytes, int extend, void volatile** memory) {
    return real(file)->pMethods->xShmMap(real(file), page, bytes, extend, memory);
  }
  static int shm_lock(sqlite3_file* file, int first, int count, int flags) {
    return real(file)->pMethods->xShmLock(real(file), first, count, flags);
  }
  static void shm_barrier(sqlite3_file* file) { real(file)->pMethods->xShmBarrier(real(file)); }
  static int shm_unmap(sqlite3_file* file, int is_to_delete) {
    return real(file)->pMethods->xShmUnmap(real(file), is_to_delete);
  }

  // Version 2: without memory mapping, which would write past us.
  static const sqlite3_io_methods* table() {
    static const sqlite3_io_methods methods = {2,
                                               close,
                                               read,
                                               write,
                                               truncate,
                                               sync,
                                               file_size,
                                               lock,
                                               unlock,
                                               check_reserved_lock,
                                               file_control,
                                               sector_size,
                                               characteristics,
                                               shm_map,
                                               shm_lock,
                                               shm_barrier,
                                               shm_unmap,
                                               nullptr,
                                               nullptr};
    return &methods;
  }

  static int open(sqlite3_vfs* vfs, const char* name, sqlite3_file* file, int flags, int* out_flags) {
    auto* disk = static_cast<FaultyDisk*>(vfs->pAppData);
    File& self = File::of(file);
    self.base.pMethods = nullptr;
    self.disk = disk;
    self.path = nullptr;
    self.real = reinterpret_cast<sqlite3_file*>(reinterpret_cast<std::byte*>(file) + sizeof(File));
    const bool is_new = name != nullptr && ::access(name, F_OK) != 0;
    if (disk->is_off_) return SQLITE_CANTOPEN;
    const int code = disk->real_->xOpen(disk->real_, name, self.real, flags, out_flags);
    if (code != SQLITE_OK) return code;
    if (name != nullptr) {
      self.path = new std::string(name);
      disk->opened_.insert(*self.path);
      if (is_new) disk->unsynced_[*self.path].is_new = true;
    }
    self.base.pMethods = table();
    return SQLITE_OK;
  }

  static int remove(sqlite3_vfs* vfs, const char* name, int is_dir_synced) {
    auto* disk = static_cast<FaultyDisk*>(vfs->pAppData);
    if (disk->is_off_) return SQLITE_IOERR_DELETE;
    const int code = disk->real_->xDelete(disk->real_, name, is_dir_synced);
    if (code == SQLITE_OK) disk->unsynced_.erase(name);
    return code;
  }
};

FaultyDisk::FaultyDisk(std::uint64_t seed) : generator_(seed) {
  real_ = sqlite3_vfs_find(nullptr);
  vfs_ = std::make_unique<sqlite3_vfs>(*real_);
  vfs_->pNext = nullptr;
  vfs_->zName = "faulty disk";
  vfs_->pAppData = this;
  vfs_->szOsFile = static_cast<int>(sizeof(File)) + real_->szOsFile;
  vfs_->xOpen = Methods::open;
  vfs_->xDelete = Methods::remove;
  if (sqlite3_vfs_register(vfs_.get(), 1) != SQLITE_OK) throw std::runtime_error("SQLite refuses the disk");
}

FaultyDisk::~FaultyDisk() {
  sqlite3_vfs_unregister(vfs_.get());
  sqlite3_vfs_register(real_, 1);
}

bool FaultyDisk::is_refused(Failure* failure) {
  *failure = Failure::kPowerLoss;
  if (is_off_) return true;
  const auto found = failures_.find(++operations_);
  if (found == failures_.end()) return false;
  *failure = found->second;
  has_failed_ = true;
  is_off_ = *failure == Failure::kPowerLoss;
  errors_ += is_off_ ? 0 : 1;
  return true;
}

void FaultyDisk::undo(const Unsynced& unsynced, const Target& target) {
  for (auto change = unsynced.changes.rbegin(); change != unsynced.changes.rend(); ++change) {
    if (!change->before.empty()) target.write(change->offset, change->before);
    target.resize(change->size_before);
  }
}

void FaultyDisk::redo(const Change& change, const Target& target) {
  if (change.size_after < change.size_before) return target.resize(change.size_after);
  if (is_heads()) return target.write(change.offset, change.after);
  const std::span<const std::byte> all(change.after);
  for (std::uint64_t at = 0; at < all.size(); at += kSector) {
    if (is_heads()) target.write(change.offset + at, all.subspan(at, std::min(kSector, all.size() - at)));
  }
}

void FaultyDisk::redo_some(const Unsynced& unsynced, const Target& target) {
  switch (generator_() % 4) {
    case 0:
      return;  // nothing reached the disk
    case 1:
      for (const Change& change : unsynced.changes) {  // everything did, up to some moment
        if (generator_() % 64 == 0) return redo(change, target);
        if (change.size_after < change.size_before) {
          target.resize(change.size_after);
        } else {
          target.write(change.offset, change.after);
        }
      }
      return;
    default:
      for (const Change& change : unsynced.changes) {
        if (is_heads()) redo(change, target);
      }
  }
}

void FaultyDisk::lose_power() {
  for (const auto& [path, unsynced] : unsynced_) {
    const int file = ::open(path.c_str(), O_RDWR | O_CLOEXEC);
    if (file < 0) continue;
    const Target target{[file](std::uint64_t offset, std::span<const std::byte> bytes) {
                          if (::pwrite(file, bytes.data(), bytes.size(), static_cast<off_t>(offset)) < 0)
                            throw std::runtime_error("the real disk refuses a write");
                        },
                        [file](std::uint64_t size) {
                          if (::ftruncate(file, static_cast<off_t>(size)) != 0)
                            throw std::runtime_error("the real disk refuses a truncation");
                        }};
    undo(unsynced, target);
    if (unsynced.is_new && is_heads()) {
      ::unlink(path.c_str());
    } else {
      redo_some(unsynced, target);
    }
    ::close(file);
  }
  // Shared memory does not outlive the machine's.
  for (const std::string& path : opened_) ::unlink((path + "-shm").c_str());
  unsynced_.clear();
  opened_.clear();
  failures_.clear();
  operations_ = 0;
  has_failed_ = false;
  is_off_ = false;
}

}  // namespace tonus::archive::testing
