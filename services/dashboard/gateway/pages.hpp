#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <string_view>

#include "services/core/result.hpp"

namespace tonus::dashboard {

struct Page {
  std::string content;
  std::string brotli;                ///< The same, compressed; empty: not there.
  std::string gzip;                  ///< Likewise.
  std::string type;                  ///< "text/html; charset=utf-8"
  bool is_named_by_content = false;  ///< Its name changes with its content: it may be kept for good.
};

/// What of a page goes to one client.
struct Representation {
  const std::string& body;
  std::string_view coding;  ///< "br" or "gzip"; empty: as it is.
};

/// The smallest form of the page that a client takes who sent this Accept-Encoding (RFC 9110, 12.5.3). A form
/// is refused by the weight 0 alone. Without the header the page goes as it is; what of a header cannot be
/// read counts for nothing.
[[nodiscard]] Representation representation(const Page& page, std::string_view accept_encoding);

/// The files of a folder, read once: nothing outside it can be asked for, and no request waits for a disk. A
/// file NAME.br or NAME.gz beside a file NAME is that one compressed, and no page of its own.
class Pages {
 public:
  /// kNotFound: no folder, or no index.html in it. kInvalidArgument: over 32 MB of files.
  [[nodiscard]] static Result<Pages> load(const std::filesystem::path& folder);

  /// Adds the files of another folder below `prefix`, "/manual". Errors as load()'s; nothing is added then.
  [[nodiscard]] Result<void> add(const std::filesystem::path& folder, const std::string& prefix);

  /// Null where there is no such page. "/" is index.html, "/operator" is operator.html,
  /// "/manual/" is manual/index.html.
  [[nodiscard]] const Page* find(std::string_view path) const;

  [[nodiscard]] std::size_t size() const { return pages_.size(); }

 private:
  std::size_t bytes_ = 0;
  std::map<std::string, Page, std::less<>> pages_;  ///< By path, "/assets/a.js".
};

/// By the file name's ending; application/octet-stream for any other.
[[nodiscard]] std::string content_type(const std::filesystem::path& file);

}  // namespace tonus::dashboard
