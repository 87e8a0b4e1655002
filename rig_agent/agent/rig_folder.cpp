#include "rig_agent/agent/rig_folder.hpp"

#include <cerrno>
#include <fcntl.h>
#include <spdlog/fmt/fmt.h>
#include <sys/file.h>
#include <system_error>
#include <utility>

#include "services/core/folder.hpp"
#include "services/core/name.hpp"

namespace tonus::rig {
namespace {

namespace fs = std::filesystem;

/// An earlier version kept in the data folder what now is the rig's own.
Result<void> refuse_left_behind(const fs::path& before, const fs::path& now) {
  for (const char* name : {"calibration.toml", "hold"}) {
    TONUS_TRY_ASSIGN(const bool was_there, is_present(before / name));
    TONUS_TRY_ASSIGN(const bool is_there, is_present(now / name));
    if (!was_there || is_there) continue;
    return fail(ErrorCode::kUnavailable,
                fmt::format("{}: belongs to the rig, not to a data folder; move it to {}",
                            (before / name).string(), (now / name).string()));
  }
  return {};
}

}  // namespace

Result<void> RigFolder::lock(const fs::path& folder, const std::string& name) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error)
    return fail(ErrorCode::kIo, fmt::format("{}: cannot be made: {}", folder.string(), error.message()));
  const auto file = folder / "lock";
  FileDescriptor descriptor(::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0640));
  if (!descriptor.is_open()) {
    return fail(ErrorCode::kIo, fmt::format("{}: cannot be opened: {}", file.string(),
                                            std::generic_category().message(errno)));
  }
  if (::flock(descriptor.get(), LOCK_EX | LOCK_NB) != 0) {
    return fail(ErrorCode::kUnavailable,
                fmt::format("rig '{}' is in use: another program has {}, and one may at a time", name,
                            folder.string()));
  }
  locks_.push_back(std::move(descriptor));
  return {};
}

Result<RigFolder> RigFolder::take(const fs::path& data, const std::string& name, const fs::path& own) {
  if (const std::string fault = fault_of_name(name); !fault.empty())
    return fail(ErrorCode::kInvalidArgument, "rig: " + fault);
  RigFolder folder;
  folder.path_ = data / "rig" / name;
  folder.own_ = own.empty() ? folder.path_ : own;
  TONUS_TRY(folder.lock(folder.path_, name));
  if (own.empty()) return folder;
  TONUS_TRY(folder.lock(own, name));
  TONUS_TRY(refuse_left_behind(folder.path_, own));
  return folder;
}

}  // namespace tonus::rig
