// Every safety limit, violated by a scripted or simulated driver: cycles from the violation to the safe
// torque.
#include <cmath>
#include <functional>
#include <gtest/gtest.h>
#include <limits>
#include <memory>
#include <vector>

#include "rig_agent/control/rig_loop.hpp"
#include "tests/support/simulated_rig.hpp"

namespace tonus::control {
namespace {

// A rig that shows what the test wants and keeps what was written.
class ScriptedDriver final : public drivers::Driver {
 public:
  Result<void> configure(double) override { return {}; }
  Result<void> activate() override { return {}; }
  void deactivate() noexcept override {}
  [[nodiscard]] drivers::Capabilities capabilities() const noexcept override { return {}; }
  [[nodiscard]] const RigGeometry& geometry() const noexcept override { return geometry_; }
  drivers::DriverStatus read(drivers::Reading& reading) noexcept override {
    if (status == drivers::DriverStatus::kOk) {
      reading.raw.acquisition_ns = ++cycle_ * 1'000'000;
      const Eigen::Vector2d q = geometry_.links.angles_at(handle);
      for (std::size_t i = 0; i < 2; ++i) {
        reading.raw.encoder_count[i] =
            q[static_cast<Eigen::Index>(i)] * geometry_.counts_per_unit[i] + offset[i];
        reading.raw.force_V[i] = volts[i];
      }
      reading.is_emergency_stop_pressed = is_button_pressed;
    }
    return status;
  }
  drivers::DriverStatus write(const Eigen::Vector2d& torque) noexcept override {
    written.push_back(torque);
    return write_status;
  }

  Eigen::Vector2d handle{0.30, 0.35};
  std::array<double, 2> offset{};
  std::array<double, 2> volts{};
  bool is_button_pressed = false;
  drivers::DriverStatus status = drivers::DriverStatus::kOk;
  drivers::DriverStatus write_status = drivers::DriverStatus::kOk;
  std::vector<Eigen::Vector2d> written;

 private:
  const RigGeometry geometry_;
  std::int64_t cycle_ = 0;
};

class Safety : public ::testing::Test {
 protected:
  void SetUp() override { make(LoopConfig{}); }

  void make(const LoopConfig& config) {
    driver_ = std::make_unique<ScriptedDriver>();
    auto made = RigLoop::create(*driver_, config);
    ASSERT_TRUE(made) << made.error().message;
    loop_ = std::move(made).value();
  }

  // A trial that is waiting: the handle floats, and some torque would be given on purpose by the bias.
  void start_trial() {
    Command command;
    command.kind = CommandKind::kStartTrial;
    command.program.number = 9;
    command.program.posture = {0.0, 0.38};
    command.program.shoulder = shoulder_for({0.30, 0.35}, command.program.posture);
    command.program.centring_time = 0.1;
    command.program.rest_time = 0.0;
    command.program.wait = 60.0;
    ASSERT_TRUE(loop_->post(command));
    for (int i = 0; i < 200; ++i) step();
    ASSERT_EQ(loop_->state().phase, Phase::kWaiting);
  }

  void step(unsigned missed_periods = 0) {
    loop_->keep_alive();
    loop_->step(now_ns_ += 1'000'000, missed_periods);
    SampleRecord sample;
    while (loop_->next_sample(sample)) continue;
  }

  [[nodiscard]] bool is_safe() const {
    const SafetyLimits limits = loop_->config().limits;
    return loop_->state().phase == Phase::kSafe &&
           driver_->written.back().cwiseAbs().maxCoeff() <= limits.safe_torque;
  }

  // Cycles from the one that shows the violation (counted) to the one that is safe; 99 if never.
  int cycles_to_safe_state(const std::function<void()>& violate) {
    for (int cycle = 1; cycle <= 10; ++cycle) {
      violate();
      step();
      if (is_safe()) return cycle;
    }
    return 99;
  }

  void expect_fault(Fault fault) {
    EXPECT_NE(loop_->state().faults & bit(fault), 0U) << fault_name(fault);
    TrialResult result;
    ASSERT_TRUE(loop_->next_result(result));
    EXPECT_EQ(result.outcome, TrialOutcome::kFault);
    EXPECT_NE(result.faults & bit(fault), 0U);
    EXPECT_TRUE(loop_->flight_recorder().is_frozen());
  }

  std::unique_ptr<ScriptedDriver> driver_;
  std::unique_ptr<RigLoop> loop_;
  std::int64_t now_ns_ = 0;
};

TEST_F(Safety, StopsWithinTwoCyclesOutsideTheWorkspace) {
  LoopConfig config;
  config.limits.encoder_jump = 0.1;
  config.limits.speed = 1.5;
  config.limits.unexplained_torque = 0.0;  // nothing pushes this handle
  make(config);
  start_trial();
  for (int i = 0; i < 79; ++i) {  // 1 m/s towards the edge, still inside.
    driver_->handle.x() += 0.001;
    driver_->volts = {1e-4 * i, -1e-4 * i};
    step();
  }
  ASSERT_EQ(loop_->state().faults, 0U);
  EXPECT_LE(cycles_to_safe_state([&] { driver_->handle.x() += 0.001 + 1e-6; }), 2);
  expect_fault(Fault::kWorkspace);
}

TEST_F(Safety, StopsWithinTwoCyclesWhenTheHandleIsTooFast) {
  start_trial();
  // From rest to 0.85 m/s at once, towards the middle; the limit is 0.8 m/s.
  EXPECT_LE(cycles_to_safe_state([&] { driver_->handle.x() += 0.00085; }), 2);
  expect_fault(Fault::kSpeed);
}

TEST_F(Safety, StopsWithinTwoCyclesWhenTheForceIsTooLarge) {
  start_trial();
  EXPECT_LE(cycles_to_safe_state([&] { driver_->volts = {30.1 / 4.45, 0.0}; }), 2);
  expect_fault(Fault::kForce);
}

TEST_F(Safety, StopsWithinTwoCyclesWhenTheLawAsksForTooMuchTorqueAndNeverWritesIt) {
  LoopConfig config;
  config.limits.torque = {1.0, 1.0};
  config.limits.safe_torque = 0.5;
  make(config);
  start_trial();
  Command abort;
  ASSERT_TRUE(loop_->post(abort));
  for (int i = 0; i < 10; ++i) step();
  TrialResult aborted;
  ASSERT_TRUE(loop_->next_result(aborted));
  // A perturbation of 50 mm asks for far more than 1 N m at its onset.
  Command command;
  command.kind = CommandKind::kStartTrial;
  command.program.number = 10;
  command.program.shoulder = shoulder_for({0.30, 0.35}, {0.0, 0.38});
  command.program.posture = {0.0, 0.38};
  command.program.centring_time = 0.1;
  command.program.rest_time = 0.0;
  command.program.wait = 0.0;
  command.program.amplitude = 0.05;
  ASSERT_TRUE(loop_->post(command));
  int cycles = 0;
  while (loop_->state().faults == 0 && cycles++ < 1000) step();
  EXPECT_LE(cycles_to_safe_state([] {}), 1);  // The cycle after the one that asked.
  for (const auto& torque : driver_->written) EXPECT_LE(torque.cwiseAbs().maxCoeff(), 1.0);
  expect_fault(Fault::kTorque);
}

TEST_F(Safety, StopsWithinTwoCyclesAtAnEncoderJump) {
  start_trial();
  EXPECT_LE(cycles_to_safe_state([&] { driver_->offset[1] = 26.0; }), 2);  // 0.0204 rad; allowed are 0.02.
  expect_fault(Fault::kEncoderJump);
}

TEST_F(Safety, TakesASpeedThatNoForceGivesInACycleForAnEncoderThatJumps) {
  start_trial();
  EXPECT_LE(cycles_to_safe_state([&] { driver_->handle.x() = 0.303; }), 2);  // 3 mm at once, then at rest
  expect_fault(Fault::kEncoderJump);
  EXPECT_TRUE(driver_->written.back().isZero()) << "damping by a motion that is none";
}

TEST_F(Safety, StopsWithinTwoCyclesWhenAForceChannelJumps) {
  for (const double force_N : {7.6, -7.6}) {  // a quarter of the limit of 30 N and a little more
    make(LoopConfig{});
    start_trial();
    EXPECT_LE(cycles_to_safe_state([&] { driver_->volts[1] = force_N / 4.45; }), 2);
    expect_fault(Fault::kForceJump);
  }
}

TEST_F(Safety, StopsWithinTwoCyclesWhenAForceChannelIsSaturated) {
  start_trial();
  EXPECT_LE(cycles_to_safe_state([&] { driver_->volts[1] = -10.0; }), 2);
  expect_fault(Fault::kSensorSaturated);
}

TEST_F(Safety, StopsWithinTwoCyclesAtAValueThatIsNotFinite) {
  start_trial();
  EXPECT_LE(cycles_to_safe_state([&] { driver_->volts[0] = std::numeric_limits<double>::quiet_NaN(); }), 2);
  for (const auto& torque : driver_->written) EXPECT_TRUE(torque.allFinite());
  expect_fault(Fault::kNotFinite);
}

TEST_F(Safety, StopsWithinTwoCyclesAtACountThatIsNotFinite) {
  start_trial();
  EXPECT_LE(cycles_to_safe_state([&] { driver_->offset[0] = std::numeric_limits<double>::infinity(); }), 2);
  for (const auto& torque : driver_->written) EXPECT_TRUE(torque.allFinite());
  expect_fault(Fault::kNotFinite);
}

TEST_F(Safety, StopsWithinTwoCyclesAtAnEncoderJumpOfEitherJointInEitherDirection) {
  for (const std::size_t joint : {0U, 1U}) {
    for (const double counts : {26.0, -26.0}) {
      make(LoopConfig{});
      start_trial();
      EXPECT_LE(cycles_to_safe_state([&] { driver_->offset[joint] = counts; }), 2);
      expect_fault(Fault::kEncoderJump);
    }
  }
}

TEST_F(Safety, StopsWithinTwoCyclesWhenTheSensorIsDisconnected) {
  start_trial();
  EXPECT_LE(cycles_to_safe_state([&] { driver_->status = drivers::DriverStatus::kDisconnected; }), 2);
  EXPECT_EQ(driver_->written.back(), Eigen::Vector2d::Zero());  // Without a measurement, no damping.
  expect_fault(Fault::kDriver);
}

TEST_F(Safety, StopsWithinTwoCyclesWhenTheDriverRefusesATorque) {
  start_trial();
  EXPECT_LE(cycles_to_safe_state([&] { driver_->write_status = drivers::DriverStatus::kFailed; }), 2);
  expect_fault(Fault::kDriver);
}

TEST_F(Safety, StopsWithinTwoCyclesAtAnEmergencyStopFromAnyThread) {
  start_trial();
  EXPECT_LE(cycles_to_safe_state([&] { loop_->emergency_stop(); }), 2);
  expect_fault(Fault::kEmergencyStop);
}

TEST_F(Safety, StopsWithinTwoCyclesAtTheDevicesEmergencyStop) {
  start_trial();
  EXPECT_LE(cycles_to_safe_state([&] { driver_->is_button_pressed = true; }), 2);
  expect_fault(Fault::kEmergencyStop);
}

TEST_F(Safety, StopsWithinTwoCyclesOfTooManyMissedPeriods) {
  start_trial();
  step(24);
  EXPECT_EQ(loop_->state().faults, 0U);
  step(25);  // The first cycle after the gap.
  EXPECT_TRUE(is_safe());
  expect_fault(Fault::kOverrun);
}

TEST_F(Safety, StopsWithinTwoCyclesOfTheCommandTimeout) {
  start_trial();
  int cycles = 0;
  while (!is_safe() && cycles++ < 5000) {
    loop_->step(now_ns_ += 1'000'000);  // Nobody says that he is there.
    SampleRecord sample;
    while (loop_->next_sample(sample)) continue;
  }
  EXPECT_GT(cycles, 1000);  // The limit is 1 s.
  EXPECT_LE(cycles, 1002);
  expect_fault(Fault::kCommandTimeout);
}

TEST_F(Safety, LetsNobodyBeThereWhileNoTrialRuns) {
  for (int i = 0; i < 5000; ++i) loop_->step(now_ns_ += 1'000'000);
  EXPECT_EQ(loop_->state().faults, 0U);
}

TEST_F(Safety, ClearsAFaultOnlyByCommandAndOnlyWhenItsCauseIsGone) {
  start_trial();
  driver_->is_button_pressed = true;
  for (int i = 0; i < 200; ++i) step();
  const auto ask = [&](CommandKind kind) {
    Command command;
    command.kind = kind;
    command.request = 123;
    EXPECT_TRUE(loop_->post(command));
    CommandReply reply;
    for (int i = 0; i < 20; ++i) {
      step();
      while (loop_->next_reply(reply)) {
        if (reply.request == 123) return reply;
      }
    }
    ADD_FAILURE() << "no reply";
    return reply;
  };
  EXPECT_EQ(ask(CommandKind::kStartTrial).result, CommandResult::kFaultLatched);
  const CommandReply refused = ask(CommandKind::kClearFaults);
  EXPECT_EQ(refused.result, CommandResult::kCauseRemains);
  EXPECT_EQ(refused.remaining, bit(Fault::kEmergencyStop));
  driver_->is_button_pressed = false;
  for (int i = 0; i < 200; ++i) step();
  EXPECT_EQ(loop_->state().phase, Phase::kSafe);  // Not by itself.
  EXPECT_EQ(ask(CommandKind::kClearFaults).result, CommandResult::kDone);
  EXPECT_EQ(loop_->state().phase, Phase::kIdle);
  EXPECT_EQ(loop_->state().faults, 0U);
}

TEST_F(Safety, HoldsTheFlightRecordUntilItIsReadAlsoWhenTheFaultIsCleared) {
  start_trial();
  loop_->emergency_stop();
  for (int i = 0; i < 500; ++i) step();
  Command command;
  command.kind = CommandKind::kClearFaults;
  ASSERT_TRUE(loop_->post(command));
  for (int i = 0; i < 10; ++i) step();
  ASSERT_EQ(loop_->state().faults, 0U);
  EXPECT_TRUE(loop_->flight_recorder().is_frozen());
  loop_->set_flight_record_read(loop_->flight_recorder().number());
  step();
  EXPECT_FALSE(loop_->flight_recorder().is_frozen());
}

TEST_F(Safety, KeepsTheLastTwoSecondsOfEveryCycleUpToTheFault) {
  start_trial();
  for (int i = 0; i < 3000; ++i) step();
  loop_->emergency_stop();
  step();
  const std::uint64_t fault_cycle = loop_->state().cycle - 1;
  for (int i = 0; i < 500; ++i) step();
  const FlightRecorder& recorder = loop_->flight_recorder();
  ASSERT_EQ(recorder.size(), 2000U);
  for (std::size_t i = 0; i < 2000; ++i) ASSERT_EQ(recorder.at(i).cycle, fault_cycle - 1999 + i);
  EXPECT_EQ(recorder.at(1998).faults, 0U);
  EXPECT_EQ(recorder.at(1998).phase, Phase::kWaiting);
  EXPECT_EQ(recorder.at(1999).faults, bit(Fault::kEmergencyStop));
}

TEST_F(Safety, GoesOnSamplingInTheSafeState) {
  start_trial();
  loop_->emergency_stop();
  step();
  const std::uint64_t sequence = loop_->state().next_sequence;
  for (int i = 0; i < 100; ++i) step();
  EXPECT_EQ(loop_->state().next_sequence, sequence + 20);
}

TEST(SafetyInSimulation, DampsARingingArmToRestAndGivesNoTorqueThen) {
  SimulatedRig rig;
  rig.start(rig.program());
  ASSERT_TRUE(rig.step_until_phase(Phase::kPerturbing));
  for (int i = 0; i < 90; ++i) rig.step();  // At full speed.
  rig.loop().emergency_stop();
  rig.step();
  EXPECT_EQ(rig.loop().state().phase, Phase::kSafe);
  for (int i = 0; i < 3000; ++i) rig.step();
  const SampleRecord& last = rig.samples().back();
  const EndpointSample end = convert(rig.driver().geometry(), rig.program().shoulder, last.raw);
  EXPECT_NEAR((end.p_SE - Eigen::Vector2d(0.0, 0.38)).norm(), 0.0, 0.001);
  EXPECT_LT(end.f_S.norm(), 0.3);
  EXPECT_EQ(rig.ask(CommandKind::kClearFaults).result, CommandResult::kDone);
}

// The simulated rig beside a twin of its plant, which tells the true speed of the handle.
class WatchedDriver final : public drivers::Driver {
 public:
  explicit WatchedDriver(const simulation::Profile& profile)
      : links_(profile.manipulandum.links), rig_(profile), twin_(profile, 1.0 / profile.loop_rate) {}
  Result<void> configure(double period) override { return rig_.configure(period); }
  Result<void> activate() override { return rig_.activate(); }
  void deactivate() noexcept override { rig_.deactivate(); }
  [[nodiscard]] drivers::Capabilities capabilities() const noexcept override { return rig_.capabilities(); }
  [[nodiscard]] const RigGeometry& geometry() const noexcept override { return rig_.geometry(); }
  drivers::DriverStatus read(drivers::Reading& reading) noexcept override {
    true_speed = (links_.jacobian(twin_.state().q) * twin_.state().q_rate).norm();
    return rig_.read(reading);
  }
  drivers::DriverStatus write(const Eigen::Vector2d& torque) noexcept override {
    twin_.step(torque);
    return rig_.write(torque);
  }

  double true_speed = 0.0;  // m/s, at the last read.

 private:
  const TwoLink links_;
  drivers::Simulated rig_;
  simulation::Plant twin_;
};

TEST(SafetyInSimulation, StopsWithinTwoCyclesWhenAPushMakesTheHandleTooFast) {
  for (const std::uint64_t seed : {1U, 2U, 3U, 4U, 5U}) {
    simulation::Profile profile;
    profile.seed = seed;
    profile.limits.force = 100.0;
    profile.sensors.force_full_scale = 500.0;
    profile.limits.workspace_radius = 0.25;
    profile.subject.drift.is_on = true;  // Somebody pushes hard.
    profile.subject.drift.force = 60.0;
    profile.subject.drift.time_constant = 0.5;
    profile.subject.stiffness = {2.0, 2.0, 0.5};
    WatchedDriver driver(profile);
    ASSERT_TRUE(driver.configure(0.001));
    ASSERT_TRUE(driver.activate());
    auto loop = RigLoop::create(driver, simulation::loop_config(profile));
    ASSERT_TRUE(loop);
    int cycles_too_fast = 0;
    for (int i = 0; i < 20'000 && (*loop)->state().faults == 0; ++i) {
      (*loop)->step(i * 1'000'000);
      cycles_too_fast += driver.true_speed > profile.limits.speed ? 1 : 0;
    }
    // The measured speed has steps of up to 0.18 m/s, so that the loop may stop early, but never late.
    EXPECT_NE((*loop)->state().faults & bit(Fault::kSpeed), 0U);
    EXPECT_GT(driver.true_speed, profile.limits.speed - 0.2);
    EXPECT_LE(cycles_too_fast, 2);
  }
}

}  // namespace
}  // namespace tonus::control
