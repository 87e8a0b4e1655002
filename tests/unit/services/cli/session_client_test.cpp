#include "services/cli/session_client.hpp"

#include <gtest/gtest.h>

#include "idl/topics.hpp"
#include "services/bus/memory/memory_fabric.hpp"

namespace tonus::cli {
namespace {

const Id kSession = random_id();

class SessionClientTest : public ::testing::Test {
 protected:
  SessionClientTest() {
    bus::BusOptions options;
    options.vendor = bus::Vendor::kMemory;
    options.fabric = std::make_shared<bus::MemoryFabric>();
    bus_ = *bus::create_bus(options);
    client_.emplace(*SessionClient::create(*bus_, clock_, std::make_shared<bus::Notifier>()));
    states_.emplace(*bus::TypedWriter<v1::SessionState>::create(*bus_, topics::kSessionState));
    reviews_.emplace(*bus::TypedWriter<v1::TrialReview>::create(*bus_, topics::kTrialReview));
    verdicts_.emplace(*bus::TypedWriter<v1::TrialVerdict>::create(*bus_, topics::kTrialVerdict));
    estimates_.emplace(*bus::TypedWriter<v1::Estimate>::create(*bus_, topics::kEstimateCondition));
  }

  void complete(std::uint32_t counted) {
    v1::SessionState state;
    state.session_id(kSession);
    state.phase(v1::SESSION_COMPLETED);
    state.counted(counted);
    ASSERT_TRUE(states_->write(state));
  }

  void judge(std::uint32_t attempt, bool is_valid) {
    v1::TrialVerdict verdict;
    verdict.trial_id(trial_id(kSession, attempt));
    verdict.session_id(kSession);
    verdict.attempt(attempt);
    verdict.is_valid(is_valid);
    ASSERT_TRUE(verdicts_->write(verdict));
  }

  void estimate(const std::vector<std::uint32_t>& attempts) {
    v1::Estimate estimate;
    estimate.estimate_id(estimate_id_);
    estimate.session_id(kSession);
    for (const auto attempt : attempts) {
      v1::TrialRange range;
      range.attempt(attempt);
      estimate.trials().push_back(range);
    }
    ASSERT_TRUE(estimates_->write(estimate));
  }

  void reject(std::uint32_t attempt) {
    v1::TrialReview review;
    review.trial_id(trial_id(kSession, attempt));
    review.session_id(kSession);
    review.attempt(attempt);
    review.is_rejected(true);
    review.reason("coughed");
    review.reviewed_by("Ada");
    ASSERT_TRUE(reviews_->write(review));
  }

  bool has_everything() {
    client_->update();
    return client_->has_estimated_every_valid_trial(kSession);
  }

  SystemClock clock_;
  std::unique_ptr<bus::Bus> bus_;
  std::optional<SessionClient> client_;
  std::optional<bus::TypedWriter<v1::SessionState>> states_;
  std::optional<bus::TypedWriter<v1::TrialVerdict>> verdicts_;
  std::optional<bus::TypedWriter<v1::TrialReview>> reviews_;
  std::optional<bus::TypedWriter<v1::Estimate>> estimates_;
  const Id estimate_id_ = random_id();
};

TEST_F(SessionClientTest, WaitsForTheEstimateBehindTheLastVerdict) {
  judge(1, true);
  judge(2, false);
  judge(3, true);
  complete(2);
  estimate({1});
  EXPECT_FALSE(has_everything());
  estimate({1, 3});
  EXPECT_TRUE(has_everything());
}

TEST_F(SessionClientTest, WaitsForTheEstimateWithoutATrialThatWasRejectedByHand) {
  judge(1, true);
  judge(2, true);
  judge(3, true);
  reject(2);
  complete(2);
  estimate({1, 2, 3});
  EXPECT_FALSE(has_everything());
  estimate({1, 3});
  EXPECT_TRUE(has_everything());
  const auto rejections = client_->rejections(kSession);
  ASSERT_EQ(rejections.size(), 1U);
  EXPECT_EQ(rejections[0].attempt(), 2U);
  EXPECT_EQ(rejections[0].detail(), "rejected by hand by Ada: coughed");
}

TEST_F(SessionClientTest, WaitsForAVerdictThatIsBehindTheEndOfTheSession) {
  judge(1, true);
  estimate({1});
  complete(2);
  EXPECT_FALSE(has_everything());
  judge(2, true);
  EXPECT_FALSE(has_everything());
  estimate({1, 2});
  EXPECT_TRUE(has_everything());
}

TEST_F(SessionClientTest, KnowsOfNothingThatASessionWithoutTrialsLacks) {
  complete(0);
  EXPECT_TRUE(has_everything());
}

}  // namespace
}  // namespace tonus::cli
