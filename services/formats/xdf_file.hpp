#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "services/core/file_descriptor.hpp"
#include "services/core/result.hpp"

namespace tonus::formats {

/// A new XDF file (Extensible Data Format 1.0): chunks, each with its length and kind, numbers little endian.
/// Times are seconds of a stream's own clock. Source: the specification in the wiki of github.com/sccn/xdf.
/// Errors (kIo) name the file and what the system says.
class XdfFile {
 public:
  /// Makes the file, which must not exist, with its header.
  [[nodiscard]] static Result<XdfFile> create(const std::filesystem::path& path);

  /// Begins a stream; `header` is its XML, "<info>...".
  [[nodiscard]] Result<void> begin_stream(std::uint32_t stream, std::string_view header);

  /// Samples of double64, row-major, `times.size()` rows.
  [[nodiscard]] Result<void> write(std::uint32_t stream, std::span<const double> times,
                                   std::span<const double> values);

  /// One marker.
  [[nodiscard]] Result<void> write(std::uint32_t stream, double time, std::string_view text);

  /// What is to be added, at `time` of the stream's clock, to get to the clock that all streams are compared
  /// by; s.
  [[nodiscard]] Result<void> write_clock_offset(std::uint32_t stream, double time, double offset);

  /// Ends a stream; `footer` is its XML.
  [[nodiscard]] Result<void> end_stream(std::uint32_t stream, std::string_view footer);

  /// Everything is on the disk. Nothing may be written afterwards.
  [[nodiscard]] Result<void> finish();

 private:
  XdfFile(std::filesystem::path path, FileDescriptor file) : path_(std::move(path)), file_(std::move(file)) {}
  [[nodiscard]] Result<void> put(std::string_view bytes);
  [[nodiscard]] Result<void> put_chunk(std::uint16_t tag, std::string_view content);

  std::filesystem::path path_;
  FileDescriptor file_;
};

/// The text with what means something in XML written out.
[[nodiscard]] std::string xml_text(std::string_view text);

}  // namespace tonus::formats
