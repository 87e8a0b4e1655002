#include "analysis_service/service/service.hpp"

#include <algorithm>
#include <gmock/gmock.h>
#include <iterator>

#include "tests/unit/analysis_service/service/peers.hpp"

namespace tonus::identification {
namespace {

using ::testing::IsEmpty;
using ::testing::SizeIs;

class IdentificationServiceTest : public ::testing::Test {
 protected:
  std::unique_ptr<IdentificationService> start() {
    bus_ = open(fabric_, "identification");
    const auto notifier = std::make_shared<bus::Notifier>();
    ServiceSettings settings;
    settings.rig = testing::made_up_rig_id();
    settings.core.assembler = patience_;
    auto endpoints = ServiceEndpoints::create(*bus_, notifier);
    EXPECT_TRUE(endpoints);
    auto health = runtime::HealthReporter::create(*bus_, clock_, v1::ROLE_IDENTIFICATION, common());
    EXPECT_TRUE(health);
    auto roster = runtime::Roster::create(*bus_, clock_, notifier);
    EXPECT_TRUE(roster);
    return std::make_unique<IdentificationService>(settings, std::move(*endpoints), std::move(*health),
                                                   std::move(*roster), clock_);
  }

  /// Steps the service until `count` messages have come on a reader.
  template <typename T>
  std::vector<T> receive(IdentificationService& service, bus::TypedReader<T>& from, std::size_t count) {
    std::vector<T> values;
    EXPECT_TRUE(eventually([&] {
      service.step();
      for (auto& received : runtime::drain(from)) values.push_back(std::move(received.value));
      return values.size() >= count;
    }));
    return values;
  }

  bool becomes_ready(IdentificationService& service, Peers& peers) {
    return eventually([&] {
      service.step();
      const auto healths = runtime::drain(peers.healths);
      return std::any_of(healths.begin(), healths.end(), [](const auto& received) {
        return received.value.role() == v1::ROLE_IDENTIFICATION && received.value.is_ready();
      });
    });
  }

  /// Every trial, with all its rows, until the service has judged it.
  void measure_all(IdentificationService& service, Peers& peers) {
    for (const auto& trial : trials_) {
      peers.send_rows(trial, trial.report.range);
      peers.report(trial);
    }
    (void)receive(service, peers.verdicts, trials_.size());
  }

  /// Sends the rows that were asked for.
  void answer_resends(Peers& peers) {
    for (const auto& received : runtime::drain(peers.resends)) {
      const auto& request = received.value;
      for (const auto& trial : trials_) {
        if (trial.report.range.first <= request.last_sequence() &&
            trial.report.range.last() >= request.first_sequence()) {
          peers.send_rows(
              trial, SequenceRange::from_first_to_last(request.first_sequence(), request.last_sequence()));
        }
      }
    }
  }

  std::shared_ptr<bus::MemoryFabric> fabric_ = std::make_shared<bus::MemoryFabric>();
  SystemClock clock_;
  std::unique_ptr<bus::Bus> bus_;
  AssemblerLimits patience_;
  std::vector<MeasuredTrial> trials_ = testing::made_up_condition();
};

TEST_F(IdentificationServiceTest, IsNotReadyBeforeItKnowsItsRig) {
  const auto service = start();
  Peers peers(fabric_);
  std::string state;
  ASSERT_TRUE(eventually([&] {
    service->step();
    for (const auto& received : runtime::drain(peers.healths)) {
      if (received.value.role() == v1::ROLE_IDENTIFICATION) {
        EXPECT_FALSE(received.value.is_ready());
        state = received.value.state();
      }
    }
    return state == "the rig's description is not there";
  })) << state;
  peers.introduce();
  EXPECT_TRUE(becomes_ready(*service, peers));
}

TEST_F(IdentificationServiceTest, AnswersEachTrialByAVerdictAndTheConditionsEstimate) {
  const auto service = start();
  Peers peers(fabric_);
  peers.introduce();
  ASSERT_TRUE(becomes_ready(*service, peers));
  v1::Estimate newest;
  for (const auto& trial : trials_) {
    peers.command(trial);
    peers.send_rows(trial, trial.report.range);
    peers.report(trial);
    const auto verdicts = receive(*service, peers.verdicts, 1);
    ASSERT_THAT(verdicts, SizeIs(1));
    EXPECT_EQ(verdicts[0].trial_id(), trial.report.plan.trial);
    EXPECT_TRUE(verdicts[0].is_valid()) << verdicts[0].detail();
    newest = receive(*service, peers.estimates, 1).back();
    EXPECT_EQ(newest.trials_used(), trial.report.plan.attempt);
  }
  EXPECT_EQ(newest.status(), v1::ESTIMATE_OK);
  EXPECT_NEAR(newest.stiffness_N_per_m().value()[0], testing::TrueArm().K(0, 0), 3.2);  // 1 %
  EXPECT_THAT(runtime::drain(peers.live), ::testing::Not(IsEmpty()));
}

TEST_F(IdentificationServiceTest, PublishesTheEstimateBehindTheLastVerdictBeforeItEnds) {
  const auto service = start();
  Peers peers(fabric_);
  peers.introduce();
  ASSERT_TRUE(becomes_ready(*service, peers));
  const auto& trial = trials_.front();
  peers.command(trial);
  peers.send_rows(trial, trial.report.range);
  peers.report(trial);
  ASSERT_THAT(receive(*service, peers.verdicts, 1), SizeIs(1));
  ASSERT_THAT(runtime::drain(peers.estimates), IsEmpty());  // a verdict waits for no estimate

  service->finish();

  EXPECT_THAT(runtime::drain(peers.estimates), SizeIs(1));
}

TEST_F(IdentificationServiceTest, LeavesOutWhatAnOperatorRejectedAlsoAfterARestart) {
  auto service = start();
  Peers peers(fabric_);
  peers.introduce();
  ASSERT_TRUE(becomes_ready(*service, peers));
  measure_all(*service, peers);
  v1::Estimate revised;
  const auto has_revised = [&] {
    for (auto& received : runtime::drain(peers.estimates)) revised = received.value;
    return revised.trials_used() == trials_.size() - 1 && revised.trials_rejected() == 1;
  };
  peers.reject(trials_[4]);
  ASSERT_TRUE(eventually([&] {
    service->step();
    return has_revised();
  }));
  EXPECT_THAT(runtime::drain(peers.verdicts), IsEmpty());
  const v1::Estimate before = revised;

  fabric_->kill("identification");
  service = start();  // the review, too, comes again by itself
  revised = {};
  ASSERT_TRUE(eventually([&] {
    service->step();
    answer_resends(peers);
    return has_revised();
  }));
  EXPECT_EQ(revised.stiffness_N_per_m().value(), before.stiffness_N_per_m().value());
  EXPECT_EQ(revised.mass_kg().low95(), before.mass_kg().low95());
}

TEST_F(IdentificationServiceTest, ComesToTheSameEstimateAfterARestart) {
  auto service = start();
  Peers peers(fabric_);
  peers.introduce();
  ASSERT_TRUE(becomes_ready(*service, peers));
  measure_all(*service, peers);
  v1::Estimate before;
  ASSERT_TRUE(eventually([&] {
    service->step();
    for (auto& received : runtime::drain(peers.estimates)) before = received.value;
    return before.trials_used() == trials_.size();
  }));
  fabric_->kill("identification");
  service = start();  // outcomes, plan and description come again by themselves; rows are asked for

  v1::Estimate after;
  ASSERT_TRUE(eventually([&] {
    service->step();
    answer_resends(peers);
    for (auto& received : runtime::drain(peers.estimates)) after = received.value;
    return after.trials_used() == trials_.size();
  }));
  EXPECT_EQ(after.estimate_id(), before.estimate_id());
  EXPECT_EQ(after.stiffness_N_per_m().value(), before.stiffness_N_per_m().value());
  EXPECT_EQ(after.mass_kg().high95(), before.mass_kg().high95());
}

TEST_F(IdentificationServiceTest, AsksForLostRowsAndJudgesWhenTheyCome) {
  const auto service = start();
  Peers peers(fabric_);
  peers.introduce();
  ASSERT_TRUE(becomes_ready(*service, peers));
  const auto& trial = trials_[0];
  peers.send_rows(trial, {trial.report.range.first, trial.report.range.first + 100});
  peers.report(trial);
  const auto requests = receive(*service, peers.resends, 1);
  EXPECT_EQ(requests[0].first_sequence(), trial.report.range.first + 100);
  EXPECT_EQ(requests[0].last_sequence(), trial.report.range.last());
  EXPECT_EQ(requests[0].requested_by(), "identification");
  EXPECT_THAT(runtime::drain(peers.verdicts), IsEmpty());
  peers.send_rows(
      trial, SequenceRange::from_first_to_last(requests[0].first_sequence(), requests[0].last_sequence()));
  EXPECT_TRUE(receive(*service, peers.verdicts, 1)[0].is_valid());
}

TEST_F(IdentificationServiceTest, JudgesATrialFromPartOfItsRowsOnlyWhileTheSchedulerAwaitsIt) {
  patience_.first_wait = patience_.first_retry = patience_.longest_retry = std::chrono::milliseconds(5);
  const auto service = start();
  Peers peers(fabric_);
  peers.introduce();
  ASSERT_TRUE(becomes_ready(*service, peers));
  const auto& decided = trials_[0];  // by the verdict of a service that is gone
  const auto& awaited = trials_[1];
  peers.go_on_with(awaited);
  for (const auto* trial : {&decided, &awaited}) {
    peers.send_rows(*trial, {trial->report.range.first, trial->report.range.first + 100});
    peers.report(*trial);
  }
  const auto verdict = receive(*service, peers.verdicts, 1)[0];  // nobody sends the rows that are asked for
  EXPECT_EQ(verdict.attempt(), awaited.report.plan.attempt);
  EXPECT_FALSE(verdict.is_valid());
}

TEST_F(IdentificationServiceTest, LetsOtherRigsPass) {
  const auto service = start();
  Peers peers(fabric_);
  peers.introduce();
  ASSERT_TRUE(becomes_ready(*service, peers));
  MeasuredTrial foreign = trials_[0];
  foreign.report.plan.rig = id_of("rig/other");
  peers.send_rows(foreign, foreign.report.range);
  peers.report(foreign);
  peers.send_rows(trials_[1], trials_[1].report.range);
  peers.report(trials_[1]);
  const auto verdicts = receive(*service, peers.verdicts, 1);
  ASSERT_THAT(verdicts, SizeIs(1));
  EXPECT_EQ(verdicts[0].attempt(), 2U);
}

}  // namespace
}  // namespace tonus::identification
