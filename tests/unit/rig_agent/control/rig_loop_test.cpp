#include "rig_agent/control/rig_loop.hpp"

#include <cmath>
#include <gmock/gmock.h>
#include <numbers>

#include "rig_agent/drivers/replay.hpp"
#include "tests/support/simulated_rig.hpp"

namespace tonus::control {
namespace {

TEST(RigLoop, TakesSamplesAtAWholeFractionOfItsRateWithoutGaps) {
  SimulatedRig rig;
  const TrialResult result = rig.run(rig.program());
  ASSERT_EQ(result.outcome, TrialOutcome::kCompleted);
  const auto& samples = rig.samples();
  for (std::size_t i = 0; i < samples.size(); ++i) {
    ASSERT_EQ(samples[i].sequence, i);
    ASSERT_EQ(samples[i].raw.acquisition_ns, static_cast<std::int64_t>(i) * 5'000'000);
  }
  EXPECT_EQ(rig.loop().state().next_sequence, samples.size());
  EXPECT_EQ(rig.loop().state().samples_dropped, 0U);
}

TEST(RigLoop, SamplesUpToItsOwnRate) {
  simulation::Profile profile;
  profile.loop_rate = 4000.0;
  profile.sample_divider = 1;
  SimulatedRig rig(profile);
  const TrialResult result = rig.run(rig.program());
  ASSERT_EQ(result.outcome, TrialOutcome::kCompleted);
  EXPECT_EQ(rig.samples()[1].raw.acquisition_ns, 250'000);
  EXPECT_EQ(result.onset_ns % 250'000, 0);
}

TEST(RigLoop, MarksTheSamplesOfATrialAndItsOnset) {
  SimulatedRig rig;
  TrialProgram program = rig.program({0.0, 0.52}, std::numbers::pi / 2);
  program.number = 77;
  const TrialResult result = rig.run(program);
  ASSERT_EQ(result.outcome, TrialOutcome::kCompleted);
  EXPECT_EQ(result.samples, result.last_sequence - result.first_sequence + 1);
  for (const SampleRecord& s : rig.samples()) {
    const bool is_inside = s.sequence >= result.first_sequence && s.sequence <= result.last_sequence;
    EXPECT_EQ(s.trial, is_inside ? 77U : 0U) << s.sequence;
    EXPECT_EQ((s.flags & static_cast<unsigned>(SampleFlag::kOnset)) != 0,
              s.sequence == result.onset_sequence);
    EXPECT_EQ(s.phase == Phase::kPerturbing, s.commanded[1] != 0.0);
    if (s.sequence == result.onset_sequence) {
      EXPECT_EQ(s.raw.acquisition_ns, result.onset_ns);
      EXPECT_EQ(s.phase, Phase::kPerturbing);
      EXPECT_NEAR(s.commanded[1], 0.005, 1e-12);
    }
  }
}

TEST(RigLoop, HoldsThePerturbationForItsCommandedTime) {
  SimulatedRig rig;
  TrialProgram program = rig.program();
  program.hold = 1.9;
  const TrialResult result = rig.run(program);
  std::size_t perturbed = 0;
  for (const SampleRecord& s : rig.samples()) perturbed += s.phase == Phase::kPerturbing ? 1 : 0;
  EXPECT_EQ(perturbed, 380U);  // 1.9 s at 200 Hz.
  EXPECT_EQ(result.outcome, TrialOutcome::kCompleted);
}

TEST(RigLoop, ReachesAndHoldsABiasForceBeforeTheOnset) {
  SimulatedRig rig;
  TrialProgram program = rig.program();
  program.bias = {0.6, -0.6};
  const TrialResult result = rig.run(program);
  ASSERT_EQ(result.outcome, TrialOutcome::kCompleted);
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (std::uint64_t i = result.onset_sequence - 100; i < result.onset_sequence; ++i) {
    mean += convert(rig.driver().geometry(), program.shoulder, rig.samples()[i].raw).f_S / 100.0;
  }
  EXPECT_NEAR(mean.x(), 0.6, 0.1);
  EXPECT_NEAR(mean.y(), -0.6, 0.1);
}

TEST(RigLoop, SaysThatABiasWasNotReached) {
  simulation::Profile profile;
  profile.subject.drift.is_on = true;  // A subject who pushes about by 2 N rms cannot be held within 0.1 N.
  profile.subject.drift.force = 2.0;
  profile.subject.drift.time_constant = 0.2;
  SimulatedRig rig(profile);
  TrialProgram program = rig.program();
  program.rest_speed = 0.1;
  program.centring_tolerance = 0.05;
  program.bias = {0.8, 0.0};
  const TrialResult result = rig.run(program);
  EXPECT_EQ(result.outcome, TrialOutcome::kBiasNotReached);
  EXPECT_EQ(result.ended_in, Phase::kBiasHold);
  EXPECT_FALSE(result.has_onset);
}

TEST(RigLoop, RefusesASecondTrialAndAnAbortWithoutOne) {
  SimulatedRig rig;
  EXPECT_EQ(rig.ask(CommandKind::kAbort).result, CommandResult::kNothingRunning);
  EXPECT_EQ(rig.ask(CommandKind::kClearFaults).result, CommandResult::kNothingRunning);
  rig.start(rig.program());
  ASSERT_TRUE(rig.step_until_phase(Phase::kWaiting));
  CommandReply reply;
  while (rig.loop().next_reply(reply)) EXPECT_EQ(reply.result, CommandResult::kDone);
  EXPECT_EQ(rig.ask(CommandKind::kStartTrial).result, CommandResult::kBusy);
}

TEST(RigLoop, AbortsATrialByCommand) {
  SimulatedRig rig;
  rig.start(rig.program());
  ASSERT_TRUE(rig.step_until_phase(Phase::kPerturbing));
  CommandReply reply;
  while (rig.loop().next_reply(reply)) continue;
  EXPECT_EQ(rig.ask(CommandKind::kAbort).result, CommandResult::kDone);
  TrialResult result;
  ASSERT_TRUE(rig.loop().next_result(result));
  EXPECT_EQ(result.outcome, TrialOutcome::kAborted);
  EXPECT_EQ(rig.loop().state().phase, Phase::kIdle);
}

TEST(RigLoop, StopsWithinOneControlPeriodOfReceivingAnAbortInEveryPhase) {
  for (const Phase phase : {Phase::kCentring, Phase::kWaiting, Phase::kBiasRamp, Phase::kBiasHold,
                            Phase::kPerturbing, Phase::kReturning}) {
    SimulatedRig rig;
    TrialProgram program = rig.program();
    program.bias = {0.6, -0.6};
    rig.start(program);
    ASSERT_TRUE(rig.step_until_phase(phase)) << phase_name(phase);
    for (int i = 0; i < 30; ++i) rig.step();
    ASSERT_EQ(rig.loop().state().phase, phase);
    Command abort;
    abort.request = 77;
    abort.kind = CommandKind::kAbort;
    ASSERT_TRUE(rig.loop().post(abort));
    rig.step();
    EXPECT_EQ(rig.loop().state().phase, Phase::kIdle) << phase_name(phase);
    TrialResult result;
    ASSERT_TRUE(rig.loop().next_result(result)) << phase_name(phase);
    EXPECT_EQ(result.outcome, TrialOutcome::kAborted);
    EXPECT_EQ(result.ended_in, phase);
  }
}

TEST(RigLoop, CountsWhatTheConsumerDidNotTake) {
  simulation::Profile profile;
  drivers::Simulated driver(profile);
  LoopConfig config = simulation::loop_config(profile);
  config.sample_capacity = 16;
  ASSERT_TRUE(driver.configure(0.001));
  ASSERT_TRUE(driver.activate());
  auto loop = RigLoop::create(driver, config);
  ASSERT_TRUE(loop);
  for (int i = 0; i < 100; ++i) (*loop)->step(i * 1'000'000);
  EXPECT_EQ((*loop)->samples_waiting(), 16U);
  EXPECT_EQ((*loop)->state().samples_dropped, 4U);  // 20 samples in 100 cycles.
  SampleRecord sample;
  ASSERT_TRUE((*loop)->next_sample(sample));
  EXPECT_EQ(sample.sequence, 0U);
}

TEST(RigLoop, GivesTheSameSamplesForTheSameSeed) {
  SimulatedRig first;
  SimulatedRig second;
  first.run(first.program());
  second.run(second.program());
  ASSERT_EQ(first.samples().size(), second.samples().size());
  for (std::size_t i = 0; i < first.samples().size(); ++i) {
    ASSERT_EQ(first.samples()[i].raw.encoder_count, second.samples()[i].raw.encoder_count);
    ASSERT_EQ(first.samples()[i].raw.force_V, second.samples()[i].raw.force_V);
  }
}

drivers::Recording one_axis_recording(std::size_t rows) {
  drivers::Recording recording;
  recording.geometry.kind = RigKind::kOneAxis;
  recording.geometry.counts_per_unit = {1.0, 1.0};
  recording.rate = 1000.0;
  for (std::size_t i = 0; i < rows; ++i) {
    drivers::RecordedRow row;
    row.raw.acquisition_ns = static_cast<std::int64_t>(i) * 1'000'000;
    row.raw.encoder_count = {0.001 * static_cast<double>(i), 0.0};
    row.command = {0.5, 0.0};
    recording.rows.push_back(row);
  }
  recording.segments = {{0, 10, rows - 1}};
  return recording;
}

TEST(RigLoop, PlaysASegmentOfARecordingAsATrial) {
  drivers::Replay driver(one_axis_recording(100));
  ASSERT_TRUE(driver.configure(0.001));
  ASSERT_TRUE(driver.activate());
  LoopConfig config;
  config.sample_divider = 1;
  auto loop = RigLoop::create(driver, config);
  ASSERT_TRUE(loop) << loop.error().message;
  EXPECT_FALSE((*loop)->step(0));  // Nothing to do before a trial.

  Command command;
  command.kind = CommandKind::kStartTrial;
  command.program.number = 5;
  ASSERT_TRUE((*loop)->post(command));
  TrialResult result;
  int cycles = 0;
  while (!(*loop)->next_result(result) && cycles < 1000) (*loop)->step(++cycles * 1'000'000);
  EXPECT_EQ(result.outcome, TrialOutcome::kCompleted);
  EXPECT_EQ(result.samples, 100U);
  EXPECT_EQ(result.onset_sequence - result.first_sequence, 10U);
  SampleRecord sample;
  for (std::uint64_t i = 0; i < 100; ++i) {
    ASSERT_TRUE((*loop)->next_sample(sample));
    EXPECT_EQ(sample.sequence, i);
    EXPECT_EQ(sample.trial, 5U);
    EXPECT_NEAR(sample.raw.encoder_count[0], 0.001 * static_cast<double>(i), 1e-15);
    EXPECT_EQ(sample.commanded[0], 0.5);
    EXPECT_EQ(sample.phase, i < 10 ? Phase::kWaiting : Phase::kPerturbing);
  }
  EXPECT_FALSE((*loop)->next_sample(sample));
  EXPECT_EQ((*loop)->state().trial, 0U);
}

TEST(RigLoop, SaysThatARecordingHasNoSuchSegment) {
  drivers::Replay driver(one_axis_recording(20));
  ASSERT_TRUE(driver.configure(0.001));
  ASSERT_TRUE(driver.activate());
  LoopConfig config;
  config.sample_divider = 1;
  auto loop = RigLoop::create(driver, config);
  ASSERT_TRUE(loop);
  Command command;
  command.kind = CommandKind::kStartTrial;
  command.program.number = 5;
  command.program.segment = 1;
  ASSERT_TRUE((*loop)->post(command));
  TrialResult result;
  for (int i = 0; i < 3; ++i) (*loop)->step(i);
  ASSERT_TRUE((*loop)->next_result(result));
  EXPECT_EQ(result.outcome, TrialOutcome::kNoRecording);
  EXPECT_EQ(result.samples, 0U);
}

TEST(RigLoop, HearsAnEmergencyStopBetweenTheSegmentsOfARecording) {
  drivers::Replay driver(one_axis_recording(20));
  ASSERT_TRUE(driver.configure(0.001));
  ASSERT_TRUE(driver.activate());
  LoopConfig config;
  config.sample_divider = 1;
  auto loop = RigLoop::create(driver, config);
  ASSERT_TRUE(loop);
  (*loop)->emergency_stop();
  (*loop)->step(0);
  EXPECT_EQ((*loop)->state().phase, Phase::kSafe);
  Command command;
  command.kind = CommandKind::kStartTrial;
  command.program.number = 1;
  ASSERT_TRUE((*loop)->post(command));
  command.kind = CommandKind::kClearFaults;
  ASSERT_TRUE((*loop)->post(command));
  (*loop)->step(1);
  CommandReply reply;
  ASSERT_TRUE((*loop)->next_reply(reply));
  EXPECT_EQ(reply.result, CommandResult::kFaultLatched);
  ASSERT_TRUE((*loop)->next_reply(reply));
  EXPECT_EQ(reply.result, CommandResult::kDone);
  EXPECT_EQ((*loop)->state().phase, Phase::kIdle);
}

TEST(RigLoop, RefusesAConfigWithOneLine) {
  drivers::Replay driver(one_axis_recording(20));
  ASSERT_TRUE(driver.configure(0.001));
  const auto loop = RigLoop::create(driver, LoopConfig{});
  ASSERT_FALSE(loop);
  EXPECT_EQ(loop.error().message,
            "loop: sample_divider: 5 is not allowed; expected 1 for a recording: every row is a sample");
}

}  // namespace
}  // namespace tonus::control
