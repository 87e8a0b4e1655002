#include "services/core/text_file.hpp"

#include <cerrno>
#include <cstring>
#include <fstream>
#include <spdlog/fmt/fmt.h>
#include <sstream>
#include <unistd.h>

namespace tonus {

Result<std::string> read_text_file(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) {
    const auto code = errno == ENOENT ? ErrorCode::kNotFound : ErrorCode::kIo;
    return fail(code, fmt::format("{}: {}", path.string(), std::strerror(errno)));
  }
  std::ostringstream text;
  text << file.rdbuf();
  if (file.bad()) return fail(ErrorCode::kIo, fmt::format("{}: cannot be read", path.string()));
  return text.str();
}

Result<void> write_text_file(const std::filesystem::path& path, std::string_view text) {
  auto fresh = path;
  fresh += fmt::format(".{}.new", getpid());
  std::ofstream file(fresh, std::ios::binary | std::ios::trunc);
  file.write(text.data(), static_cast<std::streamsize>(text.size()));
  file.close();
  std::error_code error;
  if (!file) {
    const std::string why = std::strerror(errno);
    std::filesystem::remove(fresh, error);
    return fail(ErrorCode::kIo, fmt::format("{}: cannot be written: {}", path.string(), why));
  }
  std::filesystem::rename(fresh, path, error);
  if (error) return fail(ErrorCode::kIo, fmt::format("{}: {}", path.string(), error.message()));
  return {};
}

}  // namespace tonus
