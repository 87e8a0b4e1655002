#include "services/contract/review.hpp"

#include <algorithm>
#include <spdlog/fmt/fmt.h>

#include "services/contract/names.hpp"
#include "services/core/text.hpp"

namespace tonus::contract {

Result<void> check_operator_text(std::string_view what, std::string_view text) {
  const auto refuse = [&](const std::string& value) {
    return fail(ErrorCode::kInvalidArgument,
                fmt::format("{}: {} is not allowed; expected 1 to {} bytes on one line", what, value,
                            kOperatorTextMost));
  };
  if (text.size() > kOperatorTextMost) return refuse(fmt::format("a text of {} bytes", text.size()));
  const bool is_blank = std::ranges::all_of(text, [](char c) { return c == ' '; });
  if (is_blank) return refuse("an empty text");
  if (shown(text) != text) return refuse(fmt::format("'{}'", shown(text.substr(0, 40))));
  return {};
}

Result<void> check_note_kind(std::string_view kind) {
  if (kind == "note" || kind == "marker") return {};
  return fail(
      ErrorCode::kInvalidArgument,
      fmt::format("note_kind: '{}' is not allowed; expected note or marker", shown(kind.substr(0, 40))));
}

v1::TrialVerdict standing_verdict(const v1::TrialVerdict& verdict, const v1::TrialReview* review) {
  v1::TrialVerdict standing = verdict;
  if (review == nullptr || !review->is_rejected()) return standing;
  standing.is_valid(false);
  auto& reasons = standing.reasons();
  if (std::ranges::find(reasons, v1::REASON_REJECTED_BY_HAND) == reasons.end())
    reasons.push_back(v1::REASON_REJECTED_BY_HAND);
  const std::string by_hand = review_text(*review);
  standing.detail(verdict.is_valid() || verdict.detail().empty() ? by_hand
                                                                 : verdict.detail() + "; " + by_hand);
  return standing;
}

std::string_view review_verb(std::string_view reviewed_by) {
  return reviewed_by == kTheScheduler ? "left out" : v1::reason_name(v1::REASON_REJECTED_BY_HAND);
}

std::string review_text(const v1::TrialReview& review) {
  return fmt::format("{}{}: {}", review_verb(review.reviewed_by()),
                     review.reviewed_by().empty() ? "" : " by " + review.reviewed_by(), review.reason());
}

}  // namespace tonus::contract
