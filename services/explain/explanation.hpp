#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "services/core/result.hpp"

namespace tonus::explain {

/// Who gives the reason.
enum class Kind : unsigned char {
  kVerdict,   ///< Why a trial does not count.
  kEstimate,  ///< Why an estimate is not ok, or a trial was left out of it.
  kFault,     ///< Why the rig stopped.
  kHold,      ///< Why the rig is held.
  kTrialEnd,  ///< How a trial ended on the rig.
};

inline constexpr Kind kKinds[] = {Kind::kVerdict, Kind::kEstimate, Kind::kFault, Kind::kHold,
                                  Kind::kTrialEnd};

/// "verdict", "estimate", "fault", "hold", "trial end".
[[nodiscard]] const char* kind_name(Kind kind);

/// What a person needs to know of one reason. Plain sentences, without markup.
struct Explanation {
  std::string_view name;     ///< As programs, files and pages have it: "off target", "halves_differ".
  std::string_view meaning;  ///< What was found, and what follows.
  std::string_view causes;   ///< Likely ones, the most frequent first.
  std::string_view remedy;   ///< What to do.
  std::string_view line{};   ///< Of a hold: what the rig's line contains for it.
};

/// The only home of these texts: of `tonus explain` and of the manual's page. ReasonTexts (tests) compares
/// them with what the code can say, in both directions.
[[nodiscard]] std::span<const Explanation> explanations(Kind kind);

struct Found {
  Kind kind;
  const Explanation* text;
};

/// The explanations of a name in any spelling ("off target", "Off_Target", "off-target"); of a line that the
/// rig gives for its hold, those of the parts it names. kNotFound: the message says what was probably meant.
[[nodiscard]] Result<std::vector<Found>> find(std::string_view words);

/// The manual's page of all reasons, in Markdown.
[[nodiscard]] std::string reasons_page();

/// For a terminal: name, kind and three paragraphs, broken at 80 columns.
[[nodiscard]] std::string as_text(const Found& found);

}  // namespace tonus::explain
