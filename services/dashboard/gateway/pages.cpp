#include "services/dashboard/gateway/pages.hpp"

#include <algorithm>
#include <boost/algorithm/string.hpp>
#include <optional>
#include <spdlog/fmt/fmt.h>
#include <vector>

#include "services/core/folder.hpp"
#include "services/core/text_file.hpp"

namespace tonus::dashboard {
namespace {

constexpr std::size_t kMaximumBytes = std::size_t{32} << 20;

std::vector<std::string> parts_of(const std::string& text, char separator) {
  std::vector<std::string> parts;
  boost::algorithm::split(parts, text, [separator](char c) { return c == separator; });
  for (std::string& part : parts)
    boost::algorithm::trim_if(part, [](char c) { return c == ' ' || c == '\t'; });
  return parts;
}

/// "q=0", "q=0.", "q=0.000": the only weight that refuses.
bool is_zero_weight(const std::string& parameter) {
  return boost::algorithm::istarts_with(parameter, "q=0") &&
         parameter.find_first_not_of(".0", 2) == std::string::npos;
}

/// Whether the header allows the coding: by its name, else by "*".
bool is_accepted(std::string_view header, std::string_view coding) {
  std::optional<bool> by_name;
  std::optional<bool> by_star;
  for (const std::string& one : parts_of(std::string(header), ',')) {
    const auto parts = parts_of(one, ';');
    const bool is_allowed = std::none_of(parts.begin() + 1, parts.end(), is_zero_weight);
    if (boost::algorithm::iequals(parts.front(), coding)) by_name = is_allowed;
    if (parts.front() == "*") by_star = is_allowed;
  }
  return by_name.value_or(by_star.value_or(false));
}

/// Gives each page its compressed forms, which are no pages then.
void take_compressed(std::map<std::string, Page, std::less<>>& pages) {
  for (auto& [path, page] : pages) {
    const auto take = [&pages, &path = path](const char* ending, std::string& form) {
      const auto found = pages.find(path + ending);
      if (found != pages.end()) form = std::move(found->second.content);
    };
    take(".br", page.brotli);
    take(".gz", page.gzip);
  }
  std::erase_if(pages, [&pages](const auto& entry) {
    const std::string& path = entry.first;
    return (path.ends_with(".br") || path.ends_with(".gz")) &&
           pages.contains(path.substr(0, path.size() - 3));
  });
}

}  // namespace

Representation representation(const Page& page, std::string_view accept_encoding) {
  const std::string* body = &page.content;
  std::string_view chosen;
  const auto consider = [&](const std::string& form, std::string_view coding) {
    if (form.empty() || form.size() >= body->size() || !is_accepted(accept_encoding, coding)) return;
    body = &form;
    chosen = coding;
  };
  consider(page.gzip, "gzip");
  consider(page.brotli, "br");
  return {*body, chosen};
}

std::string content_type(const std::filesystem::path& file) {
  static const std::map<std::string, std::string, std::less<>> kTypes{
      {".html", "text/html; charset=utf-8"},
      {".js", "text/javascript; charset=utf-8"},
      {".css", "text/css; charset=utf-8"},
      {".svg", "image/svg+xml"},
      {".png", "image/png"},
      {".json", "application/json"},
      {".txt", "text/plain; charset=utf-8"},
      {".md", "text/plain; charset=utf-8"},
      {".tsv", "text/plain; charset=utf-8"},
      {".csv", "text/csv; charset=utf-8"},
      {".pdf", "application/pdf"},
      {".webmanifest", "application/manifest+json"}};
  const auto found = kTypes.find(file.extension().string());
  return found == kTypes.end() ? "application/octet-stream" : found->second;
}

Result<Pages> Pages::load(const std::filesystem::path& folder) {
  Pages made;
  TONUS_TRY(made.add(folder, ""));
  return made;
}

Result<void> Pages::add(const std::filesystem::path& folder, const std::string& prefix) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(folder / "index.html", error)) {
    return fail(ErrorCode::kNotFound,
                fmt::format("{}: no index.html; expected the folder of the built pages", folder.string()));
  }
  std::size_t bytes = bytes_;
  std::map<std::string, Page, std::less<>> added;
  const FilesBelow below = files_below(folder);
  if (!below.unreachable.empty()) return below.unreachable.front();
  for (const FileBelow& file : below.files) {
    auto content = read_text_file(file.path);
    if (!content) return content.error();
    bytes += content->size();
    if (bytes > kMaximumBytes) {
      return fail(ErrorCode::kInvalidArgument,
                  fmt::format("{}: over {} bytes of pages", folder.string(), kMaximumBytes));
    }
    const auto path = prefix + "/" + file.relative;
    added[path] = {.content = std::move(*content),
                   .brotli = {},
                   .gzip = {},
                   .type = content_type(file.path),
                   .is_named_by_content = path.starts_with("/assets/")};
  }
  take_compressed(added);
  bytes_ = bytes;
  pages_.merge(added);
  return {};
}

const Page* Pages::find(std::string_view path) const {
  const auto look = [this](const std::string& name) -> const Page* {
    const auto found = pages_.find(name);
    return found == pages_.end() ? nullptr : &found->second;
  };
  const std::string name(path);
  if (name.ends_with('/')) return look(name + "index.html");
  if (const Page* page = look(name)) return page;
  return look(name + ".html");
}

}  // namespace tonus::dashboard
