#include "rig_agent/control/trial_machine.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <map>
#include <numbers>
#include <vector>

namespace tonus::control {
namespace {

constexpr double kPeriod = 0.001;
constexpr std::uint64_t kDivider = 5;

// Drives a machine with a handle of the test's making, as the loop would.
class MachineUnderTest {
 public:
  explicit MachineUnderTest(bool actuates = true) : machine_(ServoGains{}, kPeriod, actuates) {}

  static TrialProgram program() {
    TrialProgram p;
    p.number = 42;
    p.posture = {0.0, 0.38};
    p.shoulder.origin = {0.3, -0.03};  // The target is at (0.3, 0.35) in R.
    p.centring_time = 0.2;
    p.centring_timeout = 1.0;
    p.rest_time = 0.1;
    p.wait = 0.4;
    p.hold = 0.3;
    p.return_time = 0.2;
    return p;
  }

  void start(const TrialProgram& p) {
    while (cycle_ % kDivider != 0) step();
    machine_.start(p, input());
  }
  Reference step() {
    const CycleInput in = input();
    const Reference reference = machine_.advance(in);
    if (in.takes_sample) machine_.sampled(sequence_++, in.acquisition_ns);
    ++cycle_;
    ++cycles_in_[machine_.phase()];
    return reference;
  }
  bool step_until(Phase phase, int limit = 20'000) {
    for (int i = 0; i < limit && machine_.phase() != phase; ++i) last_ = step();
    return machine_.phase() == phase;
  }
  [[nodiscard]] CycleInput input() const {
    CycleInput in;
    in.handle = handle;
    in.takes_sample = cycle_ % kDivider == 0;
    in.sequence = sequence_;
    in.acquisition_ns = static_cast<std::int64_t>(cycle_) * 1'000'000;
    in.mark = mark;
    return in;
  }
  TrialResult result() {
    TrialResult r;
    EXPECT_TRUE(machine_.take_result(r));
    return r;
  }

  TrialMachine& machine() { return machine_; }
  [[nodiscard]] const Reference& last() const { return last_; }
  [[nodiscard]] std::uint64_t cycles_in(Phase phase) { return cycles_in_[phase]; }
  [[nodiscard]] std::uint64_t sequence() const { return sequence_; }

  HandleEstimate handle{{0.3, 0.35}, {0.0, 0.0}, {0.3, 0.35}, {0.0, 0.0}};
  drivers::RowMark mark = drivers::RowMark::kNone;

 private:
  TrialMachine machine_;
  Reference last_;
  std::uint64_t cycle_ = 0;
  std::uint64_t sequence_ = 0;
  std::map<Phase, std::uint64_t> cycles_in_;
};

TEST(TrialMachine, RunsThePhasesForExactlyTheirTime) {
  MachineUnderTest test;
  test.start(MachineUnderTest::program());
  ASSERT_TRUE(test.step_until(Phase::kIdle));
  EXPECT_EQ(test.cycles_in(Phase::kCentring), 200U);
  EXPECT_EQ(test.cycles_in(Phase::kWaiting), 400U);
  EXPECT_EQ(test.cycles_in(Phase::kBiasRamp), 0U);
  EXPECT_EQ(test.cycles_in(Phase::kPerturbing), 300U);
  EXPECT_EQ(test.cycles_in(Phase::kReturning), 200U);
  EXPECT_EQ(test.result().outcome, TrialOutcome::kCompleted);
}

TEST(TrialMachine, NamesTheSampleOfTheOnsetExactly) {
  MachineUnderTest test;
  test.step();  // The trial waits for the next sample: cycle 5, sequence 1.
  test.start(MachineUnderTest::program());
  ASSERT_TRUE(test.step_until(Phase::kPerturbing));
  EXPECT_TRUE(test.machine().is_onset());
  test.step();
  EXPECT_FALSE(test.machine().is_onset());
  ASSERT_TRUE(test.step_until(Phase::kIdle));
  const TrialResult result = test.result();
  // 0.2 s + 0.4 s from cycle 5 is cycle 605, sample 121; 0.3 s + 0.2 s later the first sample after the
  // trial.
  EXPECT_EQ(result.first_sequence, 1U);
  EXPECT_EQ(result.first_ns, 5'000'000);
  EXPECT_TRUE(result.has_onset);
  EXPECT_EQ(result.onset_sequence, 121U);
  EXPECT_EQ(result.onset_ns, 605'000'000);
  EXPECT_EQ(result.last_sequence, 220U);
  EXPECT_EQ(result.last_ns, 1'100'000'000);
  EXPECT_EQ(result.samples, 220U);
}

TEST(TrialMachine, CommandsTheStepInTheShoulderFrameAndLeadsInTheRobotsFrame) {
  MachineUnderTest test;
  TrialProgram program = MachineUnderTest::program();
  program.shoulder.angle = std::numbers::pi / 2;
  program.shoulder.origin = {0.3 + 0.38, 0.35};  // Rot(90 deg) (0, 0.38) = (-0.38, 0).
  program.direction = std::numbers::pi / 4;
  test.start(program);
  ASSERT_TRUE(test.step_until(Phase::kPerturbing));
  const double part = 0.005 / std::numbers::sqrt2;
  EXPECT_NEAR(test.machine().commanded()[0], part, 1e-12);
  EXPECT_NEAR(test.machine().commanded()[1], part, 1e-12);
  EXPECT_EQ(test.last().mode, ServoMode::kRing);
  EXPECT_NEAR(test.last().position.x(), 0.3 - part, 1e-12);
  EXPECT_NEAR(test.last().position.y(), 0.35 + part, 1e-12);
  EXPECT_NEAR(test.last().frequency, ServoGains{}.perturbation_phase / 0.2, 1e-12);
}

TEST(TrialMachine, PerturbsFromWhereTheHandIsNotFromTheTarget) {
  MachineUnderTest test;
  test.start(MachineUnderTest::program());
  ASSERT_TRUE(test.step_until(Phase::kWaiting));
  test.handle.position = {0.303, 0.349};
  ASSERT_TRUE(test.step_until(Phase::kPerturbing));
  EXPECT_NEAR(test.last().position.x(), 0.308, 1e-12);
  EXPECT_NEAR(test.last().position.y(), 0.349, 1e-12);
}

TEST(TrialMachine, ExertsNoForceWhileWaitingAndLeadsSmoothlyWhileCentring) {
  MachineUnderTest test;
  test.handle.position = {0.28, 0.35};
  test.start(MachineUnderTest::program());
  Eigen::Vector2d before(0.28, 0.35);
  double largest_step = 0.0;
  while (test.machine().phase() == Phase::kCentring) {
    const Reference reference = test.step();
    if (reference.mode != ServoMode::kLead) break;
    largest_step = std::max(largest_step, (reference.position - before).norm());
    before = reference.position;
  }
  EXPECT_NEAR((before - Eigen::Vector2d(0.3, 0.35)).norm(), 0.0, 1e-6);
  // A minimum-jerk way of 20 mm in 0.2 s is at most 15/8 of the mean speed fast: 0.1875 mm a cycle.
  EXPECT_NEAR(largest_step, 0.02 / 200 * 15 / 8, 2e-6);
  const Reference waiting = test.step();
  EXPECT_EQ(waiting.mode, ServoMode::kFloat);
  EXPECT_TRUE(waiting.force.isZero(0.0));
  EXPECT_TRUE(waiting.corrects_force);
}

TEST(TrialMachine, GivesUpWhenTheHandDoesNotSettleOnTheTarget) {
  MachineUnderTest test;
  test.handle.measured = {0.3, 0.356};  // 6 mm from it; allowed are 5 mm.
  test.start(MachineUnderTest::program());
  ASSERT_TRUE(test.step_until(Phase::kIdle));
  EXPECT_EQ(test.cycles_in(Phase::kCentring), 1000U);
  const TrialResult result = test.result();
  EXPECT_EQ(result.outcome, TrialOutcome::kNotCentred);
  EXPECT_EQ(result.ended_in, Phase::kCentring);
  EXPECT_FALSE(result.has_onset);
}

TEST(TrialMachine, WaitsForTheHandToComeToRest) {
  MachineUnderTest test;
  test.start(MachineUnderTest::program());
  test.handle.velocity = {0.02, 0.0};
  for (int i = 0; i < 500; ++i) test.step();
  EXPECT_EQ(test.machine().phase(), Phase::kCentring);
  test.handle.velocity.setZero();
  ASSERT_TRUE(test.step_until(Phase::kWaiting));
  EXPECT_EQ(test.cycles_in(Phase::kCentring), 600U);  // 0.1 s at rest after the 500 cycles.
}

TEST(TrialMachine, RampsAndHoldsTheBiasBeforeTheOnset) {
  MachineUnderTest test;
  TrialProgram program = MachineUnderTest::program();
  program.bias = {0.6, -0.6};
  program.bias_ramp = 0.5;
  program.bias_hold = 0.2;
  test.start(program);
  ASSERT_TRUE(test.step_until(Phase::kBiasRamp));
  for (int i = 0; i < 249; ++i) test.step();
  EXPECT_NEAR(test.step().force.x(), 0.3, 1e-9);  // Half-way of a minimum-jerk rise is half.
  test.handle.force = {0.6, -0.6};
  ASSERT_TRUE(test.step_until(Phase::kPerturbing));
  EXPECT_EQ(test.cycles_in(Phase::kBiasRamp), 500U);
  EXPECT_GE(test.cycles_in(Phase::kBiasHold), 200U);
  EXPECT_NEAR(test.machine().bias()[1], -0.6, 1e-12);
  EXPECT_NEAR(test.last().force.x(), 0.6, 1e-12);
  ASSERT_TRUE(test.step_until(Phase::kReturning));
  ASSERT_TRUE(test.step_until(Phase::kIdle));
  EXPECT_EQ(test.machine().bias()[0], 0.0);
}

TEST(TrialMachine, EndsWithoutAnOnsetWhenTheBiasIsNotReached) {
  MachineUnderTest test;
  TrialProgram program = MachineUnderTest::program();
  program.bias = {0.8, 0.0};
  program.bias_timeout = 1.5;
  test.handle.force = {0.5, 0.0};
  test.start(program);
  ASSERT_TRUE(test.step_until(Phase::kIdle));
  const TrialResult result = test.result();
  EXPECT_EQ(result.outcome, TrialOutcome::kBiasNotReached);
  EXPECT_EQ(result.ended_in, Phase::kBiasHold);
  EXPECT_FALSE(result.has_onset);
  EXPECT_EQ(test.cycles_in(Phase::kBiasHold), 1500U);
}

TEST(TrialMachine, CountsTheBiasHoldAnewAfterABreak) {
  MachineUnderTest test;
  TrialProgram program = MachineUnderTest::program();
  program.bias = {0.8, 0.0};
  program.bias_hold = 0.5;
  test.handle.force = {0.8, 0.0};
  test.start(program);
  ASSERT_TRUE(test.step_until(Phase::kBiasHold));
  for (int i = 0; i < 400; ++i) test.step();
  test.handle.force = {2.0, 0.0};
  for (int i = 0; i < 50; ++i) test.step();
  test.handle.force = {0.8, 0.0};
  for (int i = 0; i < 400; ++i) test.step();
  EXPECT_EQ(test.machine().phase(), Phase::kBiasHold);
  EXPECT_TRUE(test.step_until(Phase::kPerturbing));
}

TEST(TrialMachine, AbortsAtOnceInEveryPhase) {
  for (const Phase phase : {Phase::kCentring, Phase::kWaiting, Phase::kPerturbing, Phase::kReturning}) {
    MachineUnderTest test;
    test.start(MachineUnderTest::program());
    ASSERT_TRUE(test.step_until(phase));
    test.machine().abort();
    EXPECT_EQ(test.machine().phase(), Phase::kIdle);
    const TrialResult result = test.result();
    EXPECT_EQ(result.outcome, TrialOutcome::kAborted);
    EXPECT_EQ(result.ended_in, phase);
    EXPECT_EQ(result.has_onset, phase == Phase::kPerturbing || phase == Phase::kReturning);
  }
}

TEST(TrialMachine, ReportsAFaultOnceAndStaysSafeUntilRecovered) {
  MachineUnderTest test;
  test.start(MachineUnderTest::program());
  ASSERT_TRUE(test.step_until(Phase::kPerturbing));
  EXPECT_EQ(test.machine().fail(bit(Fault::kForce)).mode, ServoMode::kSafe);
  const TrialResult result = test.result();
  EXPECT_EQ(result.outcome, TrialOutcome::kFault);
  EXPECT_EQ(result.faults, bit(Fault::kForce));
  EXPECT_EQ(result.number, 42U);
  test.machine().fail(bit(Fault::kForce));
  TrialResult second;
  EXPECT_FALSE(test.machine().take_result(second));
  EXPECT_EQ(test.machine().phase(), Phase::kSafe);
  EXPECT_EQ(test.machine().trial(), 0U);
  test.machine().recover();
  EXPECT_EQ(test.machine().phase(), Phase::kIdle);
}

TEST(TrialMachine, FollowsTheMarksOfARecording) {
  TrialMachine machine(ServoGains{}, kPeriod, false);
  CycleInput input;
  input.takes_sample = true;
  input.sequence = 7;
  machine.start(MachineUnderTest::program(), input);
  std::vector<Phase> phases;
  for (int row = 0; row < 10; ++row) {
    input.sequence = 7 + static_cast<std::uint64_t>(row);
    input.acquisition_ns = 1000 * row;
    input.mark = row == 3   ? drivers::RowMark::kOnset
                 : row == 9 ? drivers::RowMark::kLast
                            : drivers::RowMark::kNone;
    machine.advance(input);
    phases.push_back(machine.phase());
    machine.sampled(input.sequence, input.acquisition_ns);
  }
  for (std::size_t row = 0; row < 10; ++row) {
    EXPECT_EQ(phases[row], row < 3 ? Phase::kWaiting : Phase::kPerturbing) << "row " << row;
  }
  TrialResult result;
  ASSERT_TRUE(machine.take_result(result));
  EXPECT_EQ(result.outcome, TrialOutcome::kCompleted);
  EXPECT_EQ(result.first_sequence, 7U);
  EXPECT_EQ(result.onset_sequence, 10U);
  EXPECT_EQ(result.last_sequence, 16U);
}

}  // namespace
}  // namespace tonus::control
