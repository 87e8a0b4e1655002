#include "analysis_service/service/service.hpp"

#include <algorithm>
#include <gmock/gmock.h>
#include <iterator>
#include <thread>

#include "idl/bounds.hpp"
#include "idl/topics.hpp"
#include "services/bus/memory/memory_fabric.hpp"
#include "services/runtime/drain.hpp"
#include "tests/support/made_up_trial/made_up_trial.hpp"

namespace tonus::identification {
namespace {

using std::chrono::milliseconds;
using ::testing::IsEmpty;
using ::testing::SizeIs;

/// Waits for a condition with a deadline: the in-memory bus hands over in threads of its own.
template <typename Condition>
bool eventually(Condition is_so) {
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  while (!is_so()) {
    if (std::chrono::steady_clock::now() > deadline) return false;
    std::this_thread::yield();
  }
  return true;
}

template <typename T>
bus::TypedWriter<T> writer(bus::Bus& bus, const topics::Topic<T>& topic) {
  auto made = bus::TypedWriter<T>::create(bus, topic);
  EXPECT_TRUE(made);
  return std::move(*made);
}

template <typename T>
bus::TypedReader<T> reader(bus::Bus& bus, const topics::Topic<T>& topic) {
  auto made = bus::TypedReader<T>::create(bus, topic, nullptr);
  EXPECT_TRUE(made);
  return std::move(*made);
}

std::unique_ptr<bus::Bus> open(const std::shared_ptr<bus::MemoryFabric>& fabric, const std::string& name) {
  bus::BusOptions options;
  options.vendor = bus::Vendor::kMemory;
  options.participant_name = name;
  options.fabric = fabric;
  auto bus = bus::create_bus(options);
  EXPECT_TRUE(bus);
  return std::move(*bus);
}

runtime::CommonOptions common() {
  runtime::CommonOptions options;
  options.dds = "memory";
  return options;
}

v1::TrialProgram program_of(const TrialPlan& plan) {
  v1::TrialProgram wire;
  wire.session_id(plan.session);
  wire.rig_id(plan.rig);
  wire.attempt(plan.attempt);
  wire.posture(plan.posture);
  wire.posture_m({plan.position[0], plan.position[1]});
  wire.shoulder_origin_m({plan.shoulder.origin[0], plan.shoulder.origin[1]});
  wire.shoulder_angle_rad(plan.shoulder.angle);
  wire.set_number(plan.set);
  return wire;
}

/// The rest of the session, scripted: a rig that has measured made-up trials, and a scheduler that listens.
class Peers {
 public:
  explicit Peers(const std::shared_ptr<bus::MemoryFabric>& fabric)
      : bus_(open(fabric, "peers")),
        description_(writer(*bus_, topics::kRigDescription)),
        samples_(writer(*bus_, topics::kRigSamples)),
        commands_(writer(*bus_, topics::kTrialCommand)),
        outcomes_(writer(*bus_, topics::kTrialOutcome)),
        plans_(writer(*bus_, topics::kSessionPlan)),
        states_(writer(*bus_, topics::kSessionState)),
        reviews_(writer(*bus_, topics::kTrialReview)),
        health_(runtime::HealthReporter::create(*bus_, clock_, v1::ROLE_RIG, common()).value()),
        resends(reader(*bus_, topics::kArchiveResend)),
        verdicts(reader(*bus_, topics::kTrialVerdict)),
        estimates(reader(*bus_, topics::kEstimateCondition)),
        live(reader(*bus_, topics::kEstimateLive)),
        healths(reader(*bus_, topics::kServiceHealth)) {
    health_.set_state(true, "ready");
    health_.publish_if_due();
  }

  void introduce() {
    const RigGeometry rig = testing::made_up_rig();
    v1::RigDescription wire;
    wire.rig_id(testing::made_up_rig_id());
    wire.name("rig");
    wire.kind(v1::RIG_TWO_LINK);
    wire.link_lengths_m({rig.links.l1, rig.links.l2});
    wire.encoder_counts_per_unit(rig.counts_per_unit);
    wire.encoder_zero_count(rig.encoder_zero);
    wire.encoder_sign(rig.encoder_sign);
    const auto& c = rig.force_calibration;
    wire.force_calibration_N_per_V({c(0, 0), c(0, 1), c(1, 0), c(1, 1)});
    wire.force_offset_V({rig.force_offset_V[0], rig.force_offset_V[1]});
    wire.force_sensor_angle_rad(rig.force_sensor_angle);
    wire.force_saturation_V(rig.force_saturation_V);
    wire.sample_rate_Hz(testing::kRate);
    wire.displacement_unit("m");
    wire.force_unit("N");
    ASSERT_TRUE(description_.write(wire));
    v1::SessionPlan plan;
    plan.session_id(testing::made_up_session());
    plan.rig_id(testing::made_up_rig_id());
    plan.started_at("2026-01-01T00:00:00Z");
    ASSERT_TRUE(plans_.write(plan));
  }

  /// Says as a scheduler that the trials before this one are decided.
  void go_on_with(const MeasuredTrial& trial) {
    v1::SessionState state;
    state.session_id(trial.report.plan.session);
    state.phase(v1::SESSION_RUNNING);
    state.trial_id(trial.report.plan.trial);
    state.attempts(trial.report.plan.attempt);
    ASSERT_TRUE(states_.write(state));
  }

  void reject(const MeasuredTrial& trial) {
    v1::TrialReview review;
    review.trial_id(trial.report.plan.trial);
    review.session_id(trial.report.plan.session);
    review.attempt(trial.report.plan.attempt);
    review.is_rejected(true);
    review.reason("coughed");
    ASSERT_TRUE(reviews_.write(review));
  }

  void command(const MeasuredTrial& trial) {
    v1::TrialCommand wire;
    wire.trial_id(trial.report.plan.trial);
    wire.program(program_of(trial.report.plan));
    ASSERT_TRUE(commands_.write(wire));
  }

  void send_rows(const MeasuredTrial& trial, const SequenceRange& range) {
    for (const auto& block : testing::blocks_of(trial, 100)) {
      const std::uint64_t last = block.first_sequence + block.rows.size() - 1;
      if (last < range.first || block.first_sequence >= range.end) continue;
      v1::SampleBlock wire;
      wire.rig_id(block.rig);
      wire.session_id(trial.report.plan.session);
      wire.trial_id(block.trial);
      wire.epoch(block.epoch);
      wire.first_sequence(block.first_sequence);
      for (const Row& row : block.rows) {
        v1::RigSample sample;
        sample.acquisition_ns(row.raw.acquisition_ns);
        sample.encoder_count(row.raw.encoder_count);
        sample.force_V(row.raw.force_V);
        sample.commanded_m(row.commanded);
        sample.phase(static_cast<std::uint8_t>(row.phase));  // the same order: wire_test
        wire.samples().push_back(sample);
      }
      ASSERT_TRUE(samples_.write(wire));
    }
  }

  void report(const MeasuredTrial& trial) {
    v1::TrialOutcome wire;
    wire.trial_id(trial.report.plan.trial);
    wire.program(program_of(trial.report.plan));
    wire.epoch(trial.report.epoch);
    wire.first_sequence(trial.report.range.first);
    wire.onset_sequence(trial.report.onset);
    wire.last_sequence(trial.report.range.last());
    wire.sample_rate_Hz(trial.report.sample_rate);
    ASSERT_TRUE(outcomes_.write(wire));
  }

 private:
  SystemClock clock_;
  std::unique_ptr<bus::Bus> bus_;
  bus::TypedWriter<v1::RigDescription> description_;
  bus::TypedWriter<v1::SampleBlock> samples_;
  bus::TypedWriter<v1::TrialCommand> commands_;
  bus::TypedWriter<v1::TrialOutcome> outcomes_;
  bus::TypedWriter<v1::SessionPlan> plans_;
  bus::TypedWriter<v1::SessionState> states_;
  bus::TypedWriter<v1::TrialReview> reviews_;
  runtime::HealthReporter health_;

 public:
  bus::TypedReader<v1::ArchiveResend> resends;
  bus::TypedReader<v1::TrialVerdict> verdicts;
  bus::TypedReader<v1::Estimate> estimates;
  bus::TypedReader<v1::Estimate> live;
  bus::TypedReader<v1::ServiceHealth> healths;
};

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
