#include "services/contract/review.hpp"

#include <gtest/gtest.h>

namespace tonus::contract {
namespace {

v1::TrialVerdict valid_verdict() {
  v1::TrialVerdict verdict;
  verdict.attempt(7);
  verdict.is_valid(true);
  verdict.detail("valid: at rest, on target");
  return verdict;
}

v1::TrialReview rejection() {
  v1::TrialReview review;
  review.attempt(7);
  review.is_rejected(true);
  review.reason("coughed");
  review.reviewed_by("Ada");
  return review;
}

TEST(StandingVerdict, IsThePublishedOneWhereNobodyObjected) {
  EXPECT_EQ(standing_verdict(valid_verdict(), nullptr), valid_verdict());
}

TEST(StandingVerdict, OfATrialThatWasRejectedByHandHasTheOperatorsWordsAndName) {
  const auto review = rejection();
  const auto standing = standing_verdict(valid_verdict(), &review);
  EXPECT_FALSE(standing.is_valid());
  EXPECT_EQ(standing.reasons(), std::vector{v1::REASON_REJECTED_BY_HAND});
  EXPECT_EQ(standing.detail(), "rejected by hand by Ada: coughed");
}

TEST(StandingVerdict, OfATrialThatWasNotValidKeepsWhatWasMeasured) {
  v1::TrialVerdict verdict = valid_verdict();
  verdict.is_valid(false);
  verdict.reasons({v1::REASON_OFF_TARGET});
  verdict.detail("off target: 12 mm");
  const auto review = rejection();
  const auto standing = standing_verdict(verdict, &review);
  EXPECT_EQ(standing.reasons(), (std::vector{v1::REASON_OFF_TARGET, v1::REASON_REJECTED_BY_HAND}));
  EXPECT_EQ(standing.detail(), "off target: 12 mm; rejected by hand by Ada: coughed");
}

TEST(StandingVerdict, IsThePublishedOneWhereAReviewDoesNotReject) {
  v1::TrialReview review = rejection();
  review.is_rejected(false);
  EXPECT_EQ(standing_verdict(valid_verdict(), &review), valid_verdict());
}

TEST(OperatorText, IsOneLineOfABoundedLength) {
  EXPECT_TRUE(check_operator_text("text", "moved, I think"));
  EXPECT_TRUE(check_operator_text("text", std::string(kOperatorTextMost, 'x')));
  EXPECT_EQ(check_operator_text("text", "  ").error().message,
            "text: an empty text is not allowed; expected 1 to 1000 bytes on one line");
  EXPECT_EQ(check_operator_text("text", std::string(50'000, 'x')).error().message,
            "text: a text of 50000 bytes is not allowed; expected 1 to 1000 bytes on one line");
  for (const char* hostile : {"a\nb", "\x1b[31m", "\xff\xfe", "\xe2\x80\xae"})
    EXPECT_FALSE(check_operator_text("text", hostile)) << hostile;
}

TEST(NoteKind, IsNoteOrMarker) {
  EXPECT_TRUE(check_note_kind("note"));
  EXPECT_TRUE(check_note_kind("marker"));
  EXPECT_EQ(check_note_kind("remark").error().message,
            "note_kind: 'remark' is not allowed; expected note or marker");
  EXPECT_FALSE(check_note_kind(""));
}

}  // namespace
}  // namespace tonus::contract
