#include "services/protocol/protocol_file.hpp"

#include <fstream>
#include <spdlog/fmt/fmt.h>
#include <string_view>

#include "services/core/folder.hpp"
#include "services/core/text_file.hpp"

namespace tonus::protocol {
namespace {

Result<void> check_part(const Protocol& study, std::size_t subject, const std::string& key,
                        const std::string& file, ProtocolKind kind) {
  if (file.empty()) return {};
  const auto part = load_protocol(std::filesystem::path(study.source).parent_path() / file);
  const std::string name = fmt::format("subject[{}].{}", subject + 1, key);
  if (!part)
    return refuse_value(study, name, fmt::format("\"{}\"", file),
                        "a readable protocol: " + part.error().message);
  if (part->kind != kind) {
    return refuse_value(
        study, name, fmt::format("\"{}\"", file),
        fmt::format("a protocol of kind {} (this is of kind {})", kind_name(kind), kind_name(part->kind)));
  }
  return {};
}

/// What is easily taken for a protocol's file.
Result<void> check_kind_of(const std::filesystem::path& file) {
  std::error_code error;
  if (std::filesystem::is_directory(file, error)) {
    return fail(
        ErrorCode::kInvalidArgument,
        fmt::format("{}: is a folder; expected a protocol's TOML file (--dataset plays a dataset's folder)",
                    file.string()));
  }
  if (!std::filesystem::is_regular_file(file, error)) return {};  // reading says why
  constexpr std::string_view kSqlite = "SQLite format 3";
  std::string begin(kSqlite.size(), '\0');
  std::ifstream(file, std::ios::binary).read(begin.data(), static_cast<std::streamsize>(begin.size()));
  if (begin != kSqlite) return {};
  return fail(
      ErrorCode::kInvalidArgument,
      fmt::format("{}: is an archive; expected a protocol's TOML file (tonus identify reads archives)",
                  file.string()));
}

}  // namespace

Result<Protocol> load_protocol(const std::filesystem::path& file) {
  TONUS_TRY_ASSIGN(const bool is_there, is_present(file));
  if (!is_there) return fail(ErrorCode::kNotFound, fmt::format("{}: no such protocol file", file.string()));
  TONUS_TRY(check_kind_of(file));
  TONUS_TRY_ASSIGN(const auto text, read_text_file(file));

  auto protocol = parse_protocol(text, file.string());
  if (!protocol) return protocol;
  for (std::size_t i = 0; i < protocol->subjects.size(); ++i) {
    const StudySubject& subject = protocol->subjects[i];
    for (const auto& [key, name, kind] :
         {std::tuple{"unloaded", subject.unloaded, ProtocolKind::kUnloaded},
          std::tuple{"loaded", subject.loaded, ProtocolKind::kLoaded},
          std::tuple{"instruction", subject.instruction, ProtocolKind::kInstruction}}) {
      if (auto good = check_part(*protocol, i, key, name, kind); !good) return good.error();
    }
  }
  return protocol;
}

}  // namespace tonus::protocol
