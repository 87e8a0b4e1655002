#include "services/recording/line_reader.hpp"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <unistd.h>
#include <utility>

namespace tonus::recording {
namespace {

constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
constexpr std::size_t kLongestLine = std::size_t{4} << 20U;

}  // namespace

LineReader::LineReader(std::filesystem::path path, RegularFile file)
    : path_(std::move(path)), file_(std::move(file)) {
  constexpr std::size_t kBuffer = 256 * 1024;  // stays in a processor's cache
  buffer_.resize(std::min(kBuffer, file_.size + 1));
}

Result<LineReader> LineReader::open(const std::filesystem::path& path) {
  auto file = open_for_reading(path);
  if (!file) return file.error();
  return LineReader(path, *std::move(file));
}

Result<std::string_view> LineReader::next() {
  std::memmove(buffer_.data(), buffer_.data() + given_, filled_ - given_);
  filled_ -= given_;
  given_ = 0;
  while (true) {
    if (filled_ == buffer_.size()) {  // a line longer than the buffer
      if (filled_ >= kLongestLine) {
        return fail(ErrorCode::kInvalidArgument,
                    path_.string() + ": a line of more than " + std::to_string(kLongestLine) +
                        " bytes is not allowed; expected text with an end at each row");
      }
      buffer_.resize(2 * buffer_.size());
    }
    const ssize_t count = ::read(file_.descriptor.get(), buffer_.data() + filled_, buffer_.size() - filled_);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return file_error(path_, "cannot be read");
    const bool is_end = count == 0;
    filled_ += static_cast<std::size_t>(count);
    const std::string_view text(buffer_.data(), filled_);
    given_ = is_end ? filled_ : text.rfind('\n') + 1;  // npos + 1 is 0
    if (given_ == 0 && !is_end) continue;
    const bool is_marked = std::exchange(is_first_, false) && text.starts_with(kByteOrderMark);
    return text.substr(0, given_).substr(is_marked ? kByteOrderMark.size() : 0);
  }
}

Result<std::string> read_unmarked(const std::filesystem::path& path) {
  auto text = read_text_file(path);
  if (text && text->starts_with(kByteOrderMark)) text->erase(0, kByteOrderMark.size());
  return text;
}

}  // namespace tonus::recording
