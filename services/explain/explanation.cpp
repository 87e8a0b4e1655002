#include "services/explain/explanation.hpp"

#include <algorithm>
#include <cctype>
#include <spdlog/fmt/fmt.h>

#include "services/core/nearest_word.hpp"
#include "services/explain/reason_texts.hpp"

namespace tonus::explain {
namespace {

constexpr std::size_t kColumns = 80;

/// Small letters and digits, what is between them a single space.
std::string plain(std::string_view words) {
  std::string text;
  for (const char c : words) {
    const auto byte = static_cast<unsigned char>(c);
    if (std::isalnum(byte) != 0 || byte >= 0x80) {
      text += static_cast<char>(std::tolower(byte));
    } else if (!text.empty() && text.back() != ' ') {
      text += ' ';
    }
  }
  while (text.ends_with(' ')) text.pop_back();
  return text;
}

void add_named(std::vector<Found>& found, std::string_view name) {
  const std::string wanted = plain(name);
  for (const Kind kind : kKinds) {
    for (const Explanation& text : explanations(kind)) {
      if (plain(text.name) == wanted) found.push_back({kind, &text});
    }
  }
}

/// "fault: workspace, speed" and "a; b": the parts between the marks.
std::vector<std::string_view> parts_of(std::string_view line) {
  std::vector<std::string_view> parts;
  for (std::size_t begin = 0; begin <= line.size();) {
    const auto end = std::min(line.find_first_of(",;:", begin), line.size());
    parts.push_back(line.substr(begin, end - begin));
    begin = end + 1;
  }
  return parts;
}

std::string broken(std::string_view title, std::string_view text) {
  std::string out = fmt::format("  {:<12}", title);
  std::size_t column = out.size();
  const std::string indent(14, ' ');
  for (std::size_t begin = 0; begin < text.size();) {
    const auto end = std::min(text.find(' ', begin), text.size());
    const std::string_view word = text.substr(begin, end - begin);
    if (column + word.size() + 1 > kColumns && column > indent.size()) {
      out += "\n" + indent;
      column = indent.size();
    } else if (column > indent.size()) {
      out += ' ';
      ++column;
    }
    out += word;
    column += word.size();
    begin = end + 1;
  }
  return out + "\n";
}

const char* heading(Kind kind) {
  switch (kind) {
    case Kind::kVerdict:
      return "Why a trial does not count";
    case Kind::kEstimate:
      return "Why an estimate is not ok";
    case Kind::kFault:
      return "Why the rig stopped";
    case Kind::kHold:
      return "Why the rig is held";
    case Kind::kTrialEnd:
      return "How a trial ended on the rig";
  }
  return "";
}

}  // namespace

const char* kind_name(Kind kind) {
  switch (kind) {
    case Kind::kVerdict:
      return "verdict";
    case Kind::kEstimate:
      return "estimate";
    case Kind::kFault:
      return "fault";
    case Kind::kHold:
      return "hold";
    case Kind::kTrialEnd:
      return "trial end";
  }
  return "unknown";
}

std::span<const Explanation> explanations(Kind kind) {
  switch (kind) {
    case Kind::kVerdict:
      return verdict_reasons();
    case Kind::kEstimate:
      return estimate_reasons();
    case Kind::kFault:
      return fault_reasons();
    case Kind::kHold:
      return hold_reasons();
    case Kind::kTrialEnd:
      return trial_ends();
  }
  return {};
}

Result<std::vector<Found>> find(std::string_view words) {
  std::vector<Found> found;
  add_named(found, words);
  if (found.empty()) {
    for (const Explanation& hold : hold_reasons()) {
      if (words.find(hold.line) != std::string_view::npos) found.push_back({Kind::kHold, &hold});
    }
    for (const auto part : parts_of(words)) {
      if (plain(part) != "fault") add_named(found, part);
    }
  }
  if (!found.empty()) return found;
  Words known;
  for (const Kind kind : kKinds) {
    for (const Explanation& text : explanations(kind)) known.emplace(text.name);
  }
  std::string meant = instead_of(words, known);
  if (!meant.starts_with("did you mean")) meant = "`tonus explain` alone lists them";
  return fail(ErrorCode::kNotFound, fmt::format("'{}' is not a reason; {}", words, meant));
}

std::string reasons_page() {
  std::string page =
      "# Reasons\n\n"
      "Everything that tonus gives as a reason, what it means, where it mostly comes from and what to do. "
      "The same\n"
      "text is printed by `tonus explain REASON`; `tonus explain` alone lists all reasons.\n";
  for (const Kind kind : kKinds) {
    page += fmt::format("\n## {}\n", heading(kind));
    for (const Explanation& text : explanations(kind)) {
      page += fmt::format(
          "\n### {0} {{#{1}-{2}}}\n\n{3}\n\n*Likely causes.* {4}\n\n*What to do.* {5}\n", text.name,
          kind == Kind::kTrialEnd ? "end" : kind_name(kind),
          [&] {
            std::string anchor = plain(text.name);
            std::replace(anchor.begin(), anchor.end(), ' ', '-');
            return anchor;
          }(),
          text.meaning, text.causes, text.remedy);
    }
  }
  return page;
}

std::string as_text(const Found& found) {
  return fmt::format("{} ({})\n", found.text->name, kind_name(found.kind)) +
         broken("meaning", found.text->meaning) + broken("causes", found.text->causes) +
         broken("what to do", found.text->remedy);
}

}  // namespace tonus::explain
