#include "services/formats/xdf_file.hpp"

#include <bit>
#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <unistd.h>

#include "services/core/text.hpp"
#include "services/core/text_file.hpp"

namespace tonus::formats {
namespace {

enum Tag : std::uint16_t {
  kFileHeader = 1,
  kStreamHeader = 2,
  kSamples = 3,
  kClockOffset = 4,
  kStreamFooter = 6
};

constexpr char kLengthOfFour = 4;  // a length follows as uint32
constexpr char kStampOfEight = 8;  // a sample's time follows as double

template <typename Number>
void append(std::string& bytes, Number number) {
  static_assert(std::endian::native == std::endian::little);
  bytes.append(reinterpret_cast<const char*>(&number), sizeof number);
}

void append_length(std::string& bytes, std::size_t length) {
  bytes.push_back(kLengthOfFour);
  append(bytes, static_cast<std::uint32_t>(length));
}

std::string of_stream(std::uint32_t stream) {
  std::string bytes;
  append(bytes, stream);
  return bytes;
}

}  // namespace

Result<XdfFile> XdfFile::create(const std::filesystem::path& path) {
  FileDescriptor file(::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0644));
  if (!file.is_open()) return file_error(path, "cannot be made");
  XdfFile made(path, std::move(file));
  TONUS_TRY(made.put("XDF:"));
  TONUS_TRY(made.put_chunk(kFileHeader, R"(<?xml version="1.0"?><info><version>1.0</version></info>)"));
  return made;
}

Result<void> XdfFile::begin_stream(std::uint32_t stream, std::string_view header) {
  return put_chunk(kStreamHeader, of_stream(stream).append(header));
}

Result<void> XdfFile::write(std::uint32_t stream, std::span<const double> times,
                            std::span<const double> values) {
  if (times.empty()) return {};
  const std::size_t columns = values.size() / times.size();
  std::string content = of_stream(stream);
  append_length(content, times.size());
  for (std::size_t row = 0; row < times.size(); ++row) {
    content.push_back(kStampOfEight);
    append(content, times[row]);
    for (std::size_t column = 0; column < columns; ++column) append(content, values[row * columns + column]);
  }
  return put_chunk(kSamples, content);
}

Result<void> XdfFile::write(std::uint32_t stream, double time, std::string_view text) {
  std::string content = of_stream(stream);
  append_length(content, 1);
  content.push_back(kStampOfEight);
  append(content, time);
  append_length(content, text.size());
  content.append(text);
  return put_chunk(kSamples, content);
}

Result<void> XdfFile::write_clock_offset(std::uint32_t stream, double time, double offset) {
  std::string content = of_stream(stream);
  append(content, time);
  append(content, offset);
  return put_chunk(kClockOffset, content);
}

Result<void> XdfFile::end_stream(std::uint32_t stream, std::string_view footer) {
  return put_chunk(kStreamFooter, of_stream(stream).append(footer));
}

Result<void> XdfFile::finish() {
  if (::fsync(file_.get()) != 0 || !file_.close()) return file_error(path_, "cannot be written");
  return {};
}

Result<void> XdfFile::put_chunk(std::uint16_t tag, std::string_view content) {
  std::string chunk;
  chunk.reserve(content.size() + 8);
  append_length(chunk, content.size() + sizeof tag);
  append(chunk, tag);
  return put(chunk.append(content));
}

Result<void> XdfFile::put(std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(file_.get(), bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return file_error(path_, "cannot be written");
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
  return {};
}

std::string xml_text(std::string_view text) {
  std::string written;
  for (const char c : shown(text)) {
    switch (c) {
      case '&':
        written += "&amp;";
        break;
      case '<':
        written += "&lt;";
        break;
      case '>':
        written += "&gt;";
        break;
      case '"':
        written += "&quot;";
        break;
      default:
        written.push_back(c);
    }
  }
  return written;
}

}  // namespace tonus::formats
