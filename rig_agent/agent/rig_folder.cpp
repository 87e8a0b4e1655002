#include "rig_agent/agent/rig_folder.hpp"

#include <cerrno>
#include <fcntl.h>
#include <spdlog/fmt/fmt.h>
#include <sys/file.h>
#include <system_error>
#include <unistd.h>
#include <utility>

#include "services/core/name.hpp"

namespace tonus::rig {

Result<RigFolder> RigFolder::take(const std::filesystem::path& data, const std::string& name) {
  if (const std::string fault = fault_of_name(name); !fault.empty())
    return fail(ErrorCode::kInvalidArgument, "rig: " + fault);
  const auto path = data / "rig" / name;
  std::error_code error;
  std::filesystem::create_directories(path, error);
  if (error)
    return fail(ErrorCode::kIo, fmt::format("{}: cannot be made: {}", path.string(), error.message()));
  const auto lock = path / "lock";
  const int descriptor = ::open(lock.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
  if (descriptor < 0) {
    return fail(ErrorCode::kIo, fmt::format("{}: cannot be opened: {}", lock.string(),
                                            std::generic_category().message(errno)));
  }
  RigFolder folder(path, descriptor);
  if (::flock(descriptor, LOCK_EX | LOCK_NB) != 0) {
    return fail(ErrorCode::kUnavailable,
                fmt::format("rig '{}' is in use: another program has {}, and one may at a time", name,
                            path.string()));
  }
  return folder;
}

RigFolder::RigFolder(RigFolder&& other) noexcept
    : path_(std::move(other.path_)), descriptor_(std::exchange(other.descriptor_, -1)) {}

RigFolder::~RigFolder() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

}  // namespace tonus::rig
