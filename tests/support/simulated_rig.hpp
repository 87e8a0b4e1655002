#pragma once

#include <cstdint>
#include <functional>
#include <gtest/gtest.h>
#include <memory>
#include <vector>

#include "rig_agent/control/rig_loop.hpp"
#include "rig_agent/control/validation.hpp"
#include "rig_agent/drivers/simulated.hpp"
#include "services/simulation/profile.hpp"

namespace tonus {

/// A loop over the simulated driver, stepped by hand: the clock of the loop advances by one period a step,
/// and somebody is always there.
class SimulatedRig {
 public:
  explicit SimulatedRig(const simulation::Profile& profile = {}) : profile_(profile), driver_(profile) {
    const control::LoopConfig config = simulation::loop_config(profile);
    EXPECT_TRUE(driver_.configure(1.0 / config.rate));
    EXPECT_TRUE(driver_.activate());
    auto made = control::RigLoop::create(driver_, config);
    EXPECT_TRUE(made) << (made ? "" : made.error().message);
    loop_ = std::move(made).value();
  }

  /// A trial with short waits at a posture (m in S), in direction (rad in S).
  [[nodiscard]] control::TrialProgram program(const Eigen::Vector2d& posture = {0.0, 0.38},
                                              double direction = 0.0) const {
    control::TrialProgram p;
    p.number = 1;
    p.posture = posture;
    p.shoulder = control::shoulder_for(profile_.manipulandum.home, posture);
    p.centring_time = 0.3;
    p.wait = 0.5;
    p.direction = direction;
    return p;
  }

  void step(unsigned missed_periods = 0) {
    loop_->keep_alive();
    loop_->step(now_ns_ += period_ns(), missed_periods);
    control::SampleRecord sample;
    while (loop_->next_sample(sample)) samples_.push_back(sample);
  }
  void step_silently() { loop_->step(now_ns_ += period_ns()); }

  /// Steps until the condition holds; false if it does not within `cycles`.
  bool step_until(const std::function<bool()>& condition, int cycles = 30000) {
    for (int i = 0; i < cycles; ++i) {
      if (condition()) return true;
      step();
    }
    return condition();
  }
  bool step_until_phase(control::Phase phase) {
    return step_until([&] { return loop_->state().phase == phase; });
  }

  void start(const control::TrialProgram& program) {
    control::Command command;
    command.request = ++request_;
    command.kind = control::CommandKind::kStartTrial;
    command.program = program;
    ASSERT_TRUE(loop_->post(command));
  }
  /// Posts a command and steps until it is answered.
  control::CommandReply ask(control::CommandKind kind) {
    control::Command command;
    command.request = ++request_;
    command.kind = kind;
    EXPECT_TRUE(loop_->post(command));
    control::CommandReply reply;
    EXPECT_TRUE(step_until([&] { return loop_->next_reply(reply) && reply.request == request_; }, 100));
    return reply;
  }

  /// Runs a trial to its result.
  control::TrialResult run(const control::TrialProgram& program) {
    start(program);
    control::TrialResult result;
    EXPECT_TRUE(step_until([&] { return loop_->next_result(result); }));
    return result;
  }

  [[nodiscard]] control::RigLoop& loop() { return *loop_; }
  [[nodiscard]] drivers::Simulated& driver() { return driver_; }
  [[nodiscard]] const simulation::Profile& profile() const { return profile_; }
  [[nodiscard]] const std::vector<control::SampleRecord>& samples() const { return samples_; }
  [[nodiscard]] std::int64_t now_ns() const { return now_ns_; }

 private:
  [[nodiscard]] std::int64_t period_ns() const {
    return static_cast<std::int64_t>(1e9 / profile_.loop_rate + 0.5);
  }

  const simulation::Profile profile_;
  drivers::Simulated driver_;
  std::unique_ptr<control::RigLoop> loop_;
  std::int64_t now_ns_ = 0;
  std::uint64_t request_ = 0;
  std::vector<control::SampleRecord> samples_;
};

/// A profile whose sensors are so fine that they show the true motion and force.
inline simulation::Profile profile_with_ideal_sensors() {
  simulation::Profile profile;
  profile.sensors.encoder_counts_per_rev = 1e8;
  profile.sensors.force_noise = 0.0;
  profile.sensors.force_resolution = 0.0;
  profile.sample_divider = 1;
  return profile;
}

/// The five postures of the published experiment, m in S: reference, distal, proximal, right, left.
inline const std::vector<Eigen::Vector2d>& published_postures() {
  static const std::vector<Eigen::Vector2d> postures = {
      {0.0, 0.38}, {0.0, 0.52}, {0.0, 0.24}, {0.295, 0.38}, {-0.295, 0.38}};
  return postures;
}

}  // namespace tonus
