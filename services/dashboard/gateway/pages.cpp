#include "services/dashboard/gateway/pages.hpp"

#include <spdlog/fmt/fmt.h>

#include "services/core/folder.hpp"
#include "services/core/text_file.hpp"

namespace tonus::dashboard {
namespace {

constexpr std::size_t kMaximumBytes = std::size_t{32} << 20;

}  // namespace

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
    added[path] = {std::move(*content), content_type(file.path), path.starts_with("/assets/")};
  }
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
