#include "services/verification/verification.hpp"

#include <cmath>
#include <gtest/gtest.h>

#include "services/store/memory_store.hpp"
#include "tests/support/made_up_session/made_up_session.hpp"
#include "tests/support/made_up_trial/made_up_trial.hpp"

namespace tonus::verification {
namespace {

using Outcome = EstimateCheck::Outcome;

class VerificationTest : public ::testing::Test {
 protected:
  Verification verify(made_up::SessionRecipe recipe) {
    const auto record = made_up::put_session(store_, std::move(recipe));
    auto verification = verify_session(store_, record);
    EXPECT_TRUE(verification) << verification.error().message;
    return verification ? *verification : Verification{};
  }

  store::MemoryStore store_;
};

TEST_F(VerificationTest, FindsNothingAmissInASessionAsItWasPublished) {
  const auto v = verify(made_up::unloaded_session());
  EXPECT_TRUE(v.is_well()) << v.problems.front();
  EXPECT_EQ(v.damaged_blocks, 0U);
  EXPECT_EQ(v.trials.size(), 16U);
  EXPECT_EQ(v.verdicts.size(), 16U);
  EXPECT_EQ(v.certificate.expected, 16U * 650U);  // 0.2 + 1 + 1.75 + 0.3 s at 200 Hz
  EXPECT_EQ(v.certificate.received, v.certificate.expected);
  ASSERT_EQ(v.estimates.size(), 1U);
  EXPECT_EQ(v.estimates[0].outcome, Outcome::kEqual);
  EXPECT_EQ(v.estimates[0].estimate.trials_used(), 16U);
}

TEST_F(VerificationTest, SaysWhereAnEstimateDiffersByTheLastBit) {
  auto recipe = made_up::unloaded_session();
  recipe.spoil_estimate = [](v1::Estimate& e) {
    e.stiffness_N_per_m().value()[1] = std::nextafter(e.stiffness_N_per_m().value()[1], 1e9);
  };
  const auto v = verify(std::move(recipe));
  EXPECT_FALSE(v.is_well());
  ASSERT_EQ(v.estimates.size(), 1U);
  EXPECT_EQ(v.estimates[0].outcome, Outcome::kDiffers);
  EXPECT_EQ(v.estimates[0].difference.where, "K(1,2)");
  EXPECT_GT(v.estimates[0].difference.largest, 0.0);
  EXPECT_LT(v.estimates[0].difference.largest, 1e-15);
}

TEST_F(VerificationTest, TakesAnEstimateForRightThatNamesFewerTrialsAndSaysSo) {
  // What was published before the last three trials had been judged.
  auto fewer = made_up::unloaded_session();
  fewer.trials.resize(13);
  store::MemoryStore other;
  const auto record = made_up::put_session(other, fewer);
  const auto session = store::read_session(other, record.session);
  ASSERT_TRUE(session);
  const v1::Estimate early = session->estimates.at(0).value;
  auto recipe = made_up::unloaded_session();
  recipe.spoil_estimate = [&early](v1::Estimate& e) { e = early; };
  const auto v = verify(std::move(recipe));
  ASSERT_EQ(v.estimates.size(), 1U);
  EXPECT_EQ(v.estimates[0].outcome, Outcome::kEqualAsNamed);
  EXPECT_NE(v.estimates[0].remark.find("of 13 trials"), std::string::npos) << v.estimates[0].remark;
  EXPECT_NE(v.estimates[0].remark.find("16"), std::string::npos) << v.estimates[0].remark;
  EXPECT_TRUE(v.is_well());
}

TEST_F(VerificationTest, OfASessionWithATrialRejectedByHandIdentifiesWithoutIt) {
  auto recipe = made_up::unloaded_session();
  recipe.reviewed_attempt = 5;
  const auto v = verify(recipe);
  EXPECT_TRUE(v.is_well()) << v.problems.front();
  ASSERT_EQ(v.estimates.size(), 1U);
  EXPECT_EQ(v.estimates[0].outcome, Outcome::kEqual);
  EXPECT_EQ(v.estimates[0].estimate.trials_used(), 15U);
  EXPECT_EQ(v.estimates[0].estimate.trials_rejected(), 1U);
  EXPECT_EQ(v.verdicts.at(4).published, "rejected by hand by Ada: coughed");
  EXPECT_TRUE(v.verdicts.at(4).is_equal);

  // The same numbers as of a session that never had the trial.
  store::MemoryStore other;
  recipe.reviewed_attempt = 0;
  std::erase_if(recipe.trials, [](const auto& trial) { return trial.report.plan.attempt == 5; });
  const auto record = made_up::put_session(other, recipe);
  const auto without = store::newest_estimates(*store::read_session(other, record.session));
  ASSERT_EQ(without.size(), 1U);
  EXPECT_EQ(v.estimates[0].estimate.stiffness_N_per_m().value(), without[0].stiffness_N_per_m().value());
  EXPECT_EQ(v.estimates[0].estimate.mass_kg().high95(), without[0].mass_kg().high95());
  EXPECT_EQ(v.estimates[0].estimate.natural_frequency_Hz(), without[0].natural_frequency_Hz());
}

TEST_F(VerificationTest, FindsAnEstimateThatStillHasATrialRejectedByHand) {
  auto recipe = made_up::unloaded_session();
  store::MemoryStore other;
  const auto record = made_up::put_session(other, recipe);
  const v1::Estimate with_it = store::newest_estimates(*store::read_session(other, record.session)).at(0);
  recipe.reviewed_attempt = 5;
  recipe.spoil_estimate = [&](v1::Estimate& e) { e = with_it; };
  const auto v = verify(std::move(recipe));
  ASSERT_EQ(v.estimates.size(), 1U);
  EXPECT_NE(v.estimates[0].outcome, Outcome::kEqual);
  EXPECT_FALSE(v.is_well());
}

TEST_F(VerificationTest, CountsTheSamplesThatAreMissingInATrial) {
  auto recipe = made_up::unloaded_session();
  recipe.is_block_lost = [](std::uint64_t first) { return first == 1000 + 4 * 650 + 100; };  // of attempt 5
  const auto v = verify(std::move(recipe));
  EXPECT_FALSE(v.is_well());
  ASSERT_EQ(v.trials.size(), 16U);
  EXPECT_EQ(v.trials[4].absent, 50U);
  EXPECT_EQ(v.trials[4].found, 600U);
  EXPECT_EQ(v.certificate.missing, 50U);
  EXPECT_EQ(v.problems[0], "trial 5: 50 of 650 samples are missing");
  // What was published came from all of them; from what is left it cannot be had again.
  EXPECT_FALSE(v.verdicts[4].is_equal);
  EXPECT_NE(v.verdicts[4].found.find("gap"), std::string::npos) << v.verdicts[4].found;
}

TEST_F(VerificationTest, DoesNotBlameARejectionThatWasMadeBeforeTheRowsCame) {
  auto recipe = made_up::unloaded_session();
  recipe.spoil_verdict = [](v1::TrialVerdict& verdict) {
    if (verdict.attempt() != 5) return;
    verdict.is_valid(false);
    verdict.reasons({v1::REASON_GAP});
    verdict.missing_samples(50);
  };
  const auto v = verify(std::move(recipe));
  EXPECT_TRUE(v.is_well()) << v.problems.front();
  EXPECT_FALSE(v.verdicts[4].is_equal);
  EXPECT_EQ(v.remarks.size(), 1U);
  EXPECT_NE(v.remarks.at(0).find("trial 5: rejected as"), std::string::npos) << v.remarks.at(0);
}

TEST_F(VerificationTest, BlamesAnAcceptanceThatTheRawDataDoNotBear) {
  auto recipe = made_up::unloaded_session();
  recipe.rejected_attempt = 3;
  recipe.spoil_verdict = [](v1::TrialVerdict& verdict) {
    if (verdict.attempt() != 3) return;
    verdict.is_valid(true);
    verdict.reasons({});
    verdict.missing_samples(50);
  };
  EXPECT_FALSE(verify(std::move(recipe)).is_well());
}

TEST_F(VerificationTest, AgreesThatATrialThatTheRigBrokeOffDoesNotCount) {
  auto recipe = made_up::unloaded_session();
  recipe.rejected_attempt = 3;
  const auto v = verify(std::move(recipe));
  EXPECT_TRUE(v.is_well()) << v.problems.front();
  EXPECT_NE(v.verdicts[2].published, "valid");
  EXPECT_EQ(v.verdicts[2].published, v.verdicts[2].found);
  EXPECT_EQ(v.estimates.at(0).estimate.trials_used(), 15U);
}

TEST_F(VerificationTest, DoesNotBlameASessionThatGoesOnForWhatIsStillToCome) {
  auto recipe = made_up::unloaded_session();
  recipe.is_over = false;
  const auto record = made_up::put_session(store_, recipe);
  const auto v = verify_session(store_, record);
  ASSERT_TRUE(v) << v.error().message;
  EXPECT_FALSE(v->is_over);
  EXPECT_TRUE(v->is_well()) << v->problems.front();
}

TEST_F(VerificationTest, NamesABlockWhoseChecksumDiffers) {
  const auto record = made_up::put_session(store_, made_up::unloaded_session());
  // A second copy of the first block, with one bit turned.
  store::Batch batch;
  const store::StreamKey stream{record.rig, 7};
  const auto visited = store_.visit_blocks({stream, {1000, 1001}}, [&](const store::Block& block) {
    store::Block damaged = block;
    auto bytes = *block.payload;
    bytes.back() ^= std::byte{1};
    damaged.payload = std::make_shared<const std::vector<std::byte>>(bytes);
    batch.blocks.push_back(damaged);
    return Result<void>();
  });
  ASSERT_TRUE(visited);
  ASSERT_TRUE(store_.commit(batch));
  const auto v = verify_session(store_, record);
  ASSERT_TRUE(v) << v.error().message;
  EXPECT_FALSE(v->is_well());
  EXPECT_EQ(v->damaged_blocks, 1U);
  EXPECT_NE(v->problems[0].find("samples 1000 to 1049"), std::string::npos) << v->problems[0];
}

TEST_F(VerificationTest, NamesAMessageWhoseChecksumDiffers) {
  const auto record = made_up::put_session(store_, made_up::unloaded_session());
  store::Batch batch;
  const auto visited = store_.visit_messages({"trial/verdict", {}, {}}, [&](const store::Message& message) {
    if (!batch.messages.empty()) return Result<void>();
    store::Message damaged = message;
    damaged.checksum ^= 1U;
    batch.messages.push_back(damaged);
    return Result<void>();
  });
  ASSERT_TRUE(visited);
  ASSERT_TRUE(store_.commit(batch));
  const auto v = verify_session(store_, record);
  ASSERT_TRUE(v) << v.error().message;
  EXPECT_EQ(v->damaged_messages, 1U);
  EXPECT_NE(v->problems[0].find("trial/verdict"), std::string::npos) << v->problems[0];
}

}  // namespace
}  // namespace tonus::verification
