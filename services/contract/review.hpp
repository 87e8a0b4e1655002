#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "services/core/result.hpp"

#include <idl/session.h>
#include <idl/trial.h>

/// What operators say of trials and sessions: rejections by hand, and notes.
namespace tonus::contract {

/// Bytes of a note or of a rejection's reason.
inline constexpr std::size_t kOperatorTextMost = 1000;

/// A text by an operator: not empty, kOperatorTextMost bytes at most, one line. `what` names it in the
/// message (kInvalidArgument).
[[nodiscard]] Result<void> check_operator_text(std::string_view what, std::string_view text);

/// The kind of a note: note or marker.
[[nodiscard]] Result<void> check_note_kind(std::string_view kind);

/// The verdict that holds of a trial, from the published one and what an operator said after it: a trial that
/// was rejected by hand is not valid, for the reason "rejected by hand" with the operator's words and name in
/// `detail`. Whatever counts or lists verdicts asks here. `review` may be null: there is none.
[[nodiscard]] v1::TrialVerdict standing_verdict(const v1::TrialVerdict& verdict,
                                                const v1::TrialReview* review);

/// Who reviews a trial that identification found valid and the archive could not keep.
inline constexpr std::string_view kTheScheduler = "the scheduler";

/// What the review did to the trial: "rejected by hand", or "left out" where the scheduler did it.
[[nodiscard]] std::string_view review_verb(std::string_view reviewed_by);

/// "rejected by hand by NAME: TEXT", or "left out by the scheduler: TEXT"
[[nodiscard]] std::string review_text(const v1::TrialReview& review);

}  // namespace tonus::contract
