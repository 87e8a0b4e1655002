#include "services/cli/standard_input.hpp"

#include <array>
#include <cstdio>
#include <sys/mman.h>
#include <unistd.h>

namespace tonus::cli {
namespace {

constexpr const char* kName = "-";
constexpr std::size_t kMost = 1U << 20;  // far more than such a file may have

}  // namespace

Result<StandardInput> StandardInput::take(std::string& file, const std::string& what) {
  if (file != kName) return StandardInput(FileDescriptor());
  FileDescriptor kept(memfd_create("input", MFD_CLOEXEC));
  if (!kept.is_open()) return fail(ErrorCode::kIo, "standard input: there is no memory for it");
  std::array<char, 4096> part{};
  std::size_t size = 0;
  for (std::size_t n = 0; (n = std::fread(part.data(), 1, part.size(), stdin)) > 0; size += n) {
    if (size + n > kMost || write(kept.get(), part.data(), n) != static_cast<ssize_t>(n))
      return fail(ErrorCode::kInvalidArgument, "standard input: is too long for " + what);
  }
  if (size == 0) return fail(ErrorCode::kInvalidArgument, "standard input: is empty; expected " + what);
  StandardInput taken(std::move(kept));
  file = taken.path();
  return taken;
}

Error StandardInput::told(Error error) const {
  if (!file_.is_open()) return error;
  for (auto at = error.message.find(path()); at != std::string::npos; at = error.message.find(path()))
    error.message.replace(at, path().size(), "standard input");
  return error;
}

}  // namespace tonus::cli
