#pragma once

#include <gtest/gtest.h>
#include <memory>
#include <string>
#include <thread>

#include "analysis_service/service/service.hpp"
#include "idl/bounds.hpp"
#include "idl/topics.hpp"
#include "services/bus/memory/memory_fabric.hpp"
#include "services/runtime/drain.hpp"
#include "tests/support/made_up_trial/made_up_messages.hpp"

namespace tonus::identification {

/// Waits for a condition with a deadline: the in-memory bus hands over in threads of its own.
template <typename Condition>
[[nodiscard]] bool eventually(Condition is_so) {
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

inline std::unique_ptr<bus::Bus> open(const std::shared_ptr<bus::MemoryFabric>& fabric,
                                      const std::string& name) {
  bus::BusOptions options;
  options.vendor = bus::Vendor::kMemory;
  options.participant_name = name;
  options.fabric = fabric;
  auto bus = bus::create_bus(options);
  EXPECT_TRUE(bus);
  return std::move(*bus);
}

inline runtime::CommonOptions common(const std::string& rig = "rig") {
  runtime::CommonOptions options;
  options.dds = "memory";
  options.rig = rig;
  return options;
}

/// The rest of the session, scripted: a rig that has measured made-up trials, and a scheduler that listens.
class Peers {
 public:
  explicit Peers(const std::shared_ptr<bus::MemoryFabric>& fabric, const std::string& rig = "rig",
                 const Id& session = testing::made_up_session())
      : rig_(rig),
        session_(session),
        bus_(open(fabric, "peers of " + rig)),
        description_(writer(*bus_, topics::kRigDescription)),
        samples_(writer(*bus_, topics::kRigSamples)),
        commands_(writer(*bus_, topics::kTrialCommand)),
        outcomes_(writer(*bus_, topics::kTrialOutcome)),
        plans_(writer(*bus_, topics::kSessionPlan)),
        states_(writer(*bus_, topics::kSessionState)),
        reviews_(writer(*bus_, topics::kTrialReview)),
        health_(runtime::HealthReporter::create(*bus_, clock_, v1::ROLE_RIG, common(rig)).value()),
        resends(reader(*bus_, topics::kArchiveResend)),
        verdicts(reader(*bus_, topics::kTrialVerdict)),
        estimates(reader(*bus_, topics::kEstimateCondition)),
        live(reader(*bus_, topics::kEstimateLive)),
        healths(reader(*bus_, topics::kServiceHealth)) {
    health_.set_state(true, "ready");
    health_.publish_if_due();
  }

  void introduce() {
    ASSERT_TRUE(description_.write(testing::description_of(rig_)));
    ASSERT_TRUE(plans_.write(testing::plan_of(rig_, session_, "2026-01-01T00:00:00Z")));
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

  void command(const MeasuredTrial& trial) { ASSERT_TRUE(commands_.write(testing::command_of(trial))); }

  void send_rows(const MeasuredTrial& trial, const SequenceRange& range) {
    for (const auto& block : testing::messages_of(trial, 100)) {
      const std::uint64_t last = block.first_sequence() + block.samples().size() - 1;
      if (last < range.first || block.first_sequence() >= range.end) continue;
      ASSERT_TRUE(samples_.write(block));
    }
  }

  void report(const MeasuredTrial& trial) { ASSERT_TRUE(outcomes_.write(testing::outcome_of(trial))); }

 private:
  std::string rig_;
  Id session_;
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

}  // namespace tonus::identification
