#include "tests/fault/driver/fault_campaign.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <optional>
#include <random>
#include <stdexcept>

#include "rig_agent/control/rig_loop.hpp"
#include "rig_agent/control/validation.hpp"
#include "services/simulation/profile.hpp"

namespace tonus::testing {
namespace {

using control::Phase;

constexpr int kCyclesAfter = 3000;     // watched after the fault began, in its own trial
constexpr int kCyclesDetected = 1500;  // watched after it was found
constexpr int kLongestTrial = 30000;
constexpr int kTrialsOfOtherRig = 4;

constexpr Phase kPhases[] = {Phase::kCentring, Phase::kWaiting,    Phase::kBiasRamp,
                             Phase::kBiasHold, Phase::kPerturbing, Phase::kReturning};

void scale(simulation::JointImpedance& joints, double factor) {
  joints.shoulder *= factor;
  joints.elbow *= factor;
  joints.two_joint *= factor;
}

class Bench {
 public:
  Bench(std::uint64_t seed, const Hardness& hardness) : random_(seed) {
    profile_.seed = seed;
    const double firmness = uniform(0.5, 1.3);
    scale(profile_.subject.stiffness, firmness);
    scale(profile_.subject.damping, std::sqrt(firmness));
    profile_.subject.tremor.is_on = integer(0, 1) == 1;
    profile_.subject.drift.is_on = integer(0, 1) == 1;
    control::LoopConfig config = simulation::loop_config(profile_);
    if (hardness.is_model_wrong) blur(config.model);
    if (hardness.is_rig_other) make_other(config);
    driver_ = std::make_unique<FaultyDriver>(profile_, seed);
    limits_ = config.limits;
    if (!driver_->configure(1.0 / config.rate) || !driver_->activate())
      throw std::runtime_error("the simulated rig does not start");
    auto loop = control::RigLoop::create(*driver_, config);
    if (!loop) throw std::runtime_error(loop.error().message);
    loop_ = std::move(*loop);
    start();
  }

  double uniform(double low, double high) { return std::uniform_real_distribution<>(low, high)(random_); }
  int integer(int low, int high) { return std::uniform_int_distribution<>(low, high)(random_); }

  void step() {
    loop_->keep_alive();
    const unsigned missed = driver_->missed_periods();
    loop_->step(now_ns_ += 1'000'000 * static_cast<std::int64_t>(1 + missed), missed);
    control::SampleRecord sample;
    while (loop_->next_sample(sample)) continue;
    control::CommandReply reply;
    while (loop_->next_reply(reply)) continue;
  }
  [[nodiscard]] bool is_over() {
    control::TrialResult result;
    return loop_->next_result(result);
  }

  /// The session goes on.
  void start_next() {
    for (int i = 0; i < kLongestTrial && state().phase != Phase::kIdle && state().faults == 0; ++i) step();
    start();
  }

  void stop() { loop_->emergency_stop(); }

  /// Of the handle as the plant has it: m/s, J, and the power of the torque on it, W.
  [[nodiscard]] double speed() const {
    const auto& state = driver_->plant().state();
    return (profile_.manipulandum.links.jacobian(state.q) * state.q_rate).norm();
  }
  [[nodiscard]] double kinetic_energy() const {
    const auto& state = driver_->plant().state();
    return 0.5 * state.q_rate.dot(
                     simulation::loop_config(profile_).model.inertia.mass_matrix(std::cos(state.q[1])) *
                     state.q_rate);
  }
  [[nodiscard]] double power() const { return driver_->torque().dot(driver_->plant().state().q_rate); }

  [[nodiscard]] control::LoopState state() const { return loop_->state(); }
  [[nodiscard]] FaultyDriver& driver() { return *driver_; }
  [[nodiscard]] const control::SafetyLimits& limits() const { return limits_; }

  [[nodiscard]] double way_beyond() const {
    return (driver_->plant().handle() - limits_.workspace_centre).norm() - limits_.workspace_radius;
  }
  [[nodiscard]] double force_share() const { return driver_->plant().flexure_force().norm() / limits_.force; }
  /// Torque that is more than what the safe state may give: it drives, or is larger than its limit.
  [[nodiscard]] bool is_driven() const {
    const Eigen::Vector2d& torque = driver_->torque();
    if (torque.isZero(0.0)) return false;
    const bool drives =
        torque.dot(driver_->plant().state().q_rate) > 0.01;  // W; a lag of the rates by a cycle
    return drives || torque.cwiseAbs().maxCoeff() > limits_.safe_torque + 1e-9;
  }

 private:
  /// No lab knows its manipulandum to the last percent.
  void blur(control::ManipulandumModel& model) {
    for (double* value : {&model.inertia.inner, &model.inertia.outer, &model.inertia.coupling})
      *value *= uniform(0.85, 1.15);
    model.friction.viscous *= uniform(0.5, 2.0);
    model.friction.coulomb *= uniform(0.5, 2.0);
  }

  /// A rig and a subject that are sound, and not what the law expects. The size of the unexplained torque,
  /// which stops a weak motor under load, is given its widest limit.
  void make_other(control::LoopConfig& config) {
    auto& rig = profile_.manipulandum;
    rig.motor_gains = {uniform(0.2, 1.0), uniform(0.2, 1.0)};
    if (integer(0, 1) == 1) rig.motor_gains.y() = rig.motor_gains.x();
    const double friction = std::exp(uniform(std::log(0.3), std::log(3.0)));
    rig.friction.viscous *= friction;
    rig.friction.coulomb *= friction;
    const double firmness = std::exp(uniform(std::log(0.1), std::log(3.0)));
    scale(profile_.subject.stiffness, firmness);
    scale(profile_.subject.damping, std::sqrt(firmness));
    profile_.subject.link_masses *= std::exp(uniform(std::log(0.5), std::log(2.0)));
    if (integer(0, 1) == 1) config.gains.force_trim_limit = 0.0;
    config.limits.unexplained_torque = 10.0;
  }

  void start() {
    static const Eigen::Vector2d kPostures[] = {
        {0.0, 0.38}, {0.0, 0.52}, {0.0, 0.24}, {0.295, 0.38}, {-0.295, 0.38}};
    control::Command command;
    command.kind = control::CommandKind::kStartTrial;
    auto& p = command.program;
    p.number = 1;
    p.posture = kPostures[integer(0, 4)];
    // The target is up to 1.5 cm from where the handle stands: the centring has a way to go.
    const double where = uniform(0.0, 2.0 * std::numbers::pi);
    const Eigen::Vector2d target =
        profile_.manipulandum.home + uniform(0.0, 0.015) * Eigen::Vector2d(std::cos(where), std::sin(where));
    p.shoulder = control::shoulder_for(target, p.posture);
    p.wait = uniform(0.3, 0.8);
    p.direction = uniform(0.0, 2.0 * std::numbers::pi);
    p.amplitude = uniform(0.004, 0.008);
    p.rise_time = uniform(0.2, 0.3);
    p.hold = 1.0;
    if (integer(0, 1) == 1) {
      const double angle = uniform(0.0, 2.0 * std::numbers::pi);
      p.bias = uniform(1.0, 4.0) * Eigen::Vector2d(std::cos(angle), std::sin(angle));
      p.bias_ramp = 0.5;
      p.bias_hold = 0.3;
      p.bias_threshold = 1.0;
    }
    has_bias = !p.bias.isZero(0.0);
    if (!loop_->post(command)) throw std::runtime_error("the loop takes no command");
  }

 public:
  bool has_bias = false;

 private:
  std::mt19937_64 random_;
  simulation::Profile profile_;
  control::SafetyLimits limits_;
  std::unique_ptr<FaultyDriver> driver_;
  std::unique_ptr<control::RigLoop> loop_;
  std::int64_t now_ns_ = 0;
};

/// Steps until the phase, and some way into it; false where the trial has none such, or where the hand leaves
/// the workspace by itself before: run_healthy_case() counts those.
bool go_to(Bench& bench, Phase phase) {
  for (int i = 0; i < kLongestTrial && bench.state().phase != phase; ++i) {
    bench.step();
    if (bench.state().faults != 0 || bench.is_over()) return false;
  }
  const int longest = phase == Phase::kPerturbing ? 300 : 200;
  for (int i = bench.integer(0, longest); i > 0 && bench.state().phase == phase; --i) bench.step();
  return bench.state().faults == 0;
}

void watch(Bench& bench, int trials_after, FaultCase& seen) {
  int detected_at = -1;
  int trials_left = trials_after;
  for (int cycle = 1; trials_after > 0 || cycle <= kCyclesAfter; ++cycle) {
    bench.step();
    seen.way_beyond = std::max(seen.way_beyond, bench.way_beyond());
    seen.force_share = std::max(seen.force_share, bench.force_share());
    if (detected_at < 0 && bench.state().faults != 0) {
      detected_at = cycle;
      seen.found = bench.state().faults;
      seen.cycles_to_detection = cycle;
    }
    if (detected_at >= 0 && bench.is_driven()) seen.cycles_under_torque = cycle - detected_at;
    if (detected_at >= 0 && cycle - detected_at >= kCyclesDetected) break;
    if (detected_at >= 0 || !bench.is_over()) continue;
    if (trials_left-- <= 0) break;
    bench.start_next();
  }
  seen.was_harmless = detected_at < 0 && seen.way_beyond <= 0.0 && seen.force_share <= 1.0;
}

}  // namespace

namespace {

/// None: the trial that was drawn ends before its fault could begin.
std::optional<FaultCase> try_fault_case(std::uint64_t seed, std::uint64_t draw, const Hardness& hardness) {
  Bench bench(seed + 1'000'003 * draw, hardness);
  FaultCase seen;
  seen.fault = static_cast<DeviceFault>(seed % kDeviceFaults);
  const auto axis = static_cast<std::size_t>(bench.integer(0, 1));
  const double size = bench.uniform(0.1, 1.0);
  Phase phase = kPhases[bench.integer(0, 5)];
  if (!bench.has_bias && (phase == Phase::kBiasRamp || phase == Phase::kBiasHold)) phase = Phase::kPerturbing;
  if (!go_to(bench, phase)) return std::nullopt;
  seen.phase = phase;
  seen.way_beyond = bench.way_beyond();
  bench.driver().begin(seen.fault, axis, size);
  watch(bench, hardness.trials_after, seen);
  return seen;
}

}  // namespace

FaultCase run_fault_case(std::uint64_t seed, const Hardness& hardness) {
  for (std::uint64_t draw = 0; draw < 100; ++draw) {
    if (const auto seen = try_fault_case(seed, draw, hardness)) return *seen;
  }
  throw std::runtime_error("no trial lasts until its fault");
}

control::FaultBits run_healthy_case(std::uint64_t seed, const Hardness& hardness) {
  Bench bench(seed, hardness);
  const int trials = hardness.is_rig_other ? kTrialsOfOtherRig : 1;
  for (int trial = 0; trial < trials; ++trial) {
    if (trial > 0) bench.start_next();
    for (int i = 0; i < kLongestTrial && !bench.is_over(); ++i) bench.step();
    if (bench.state().faults != 0) break;
  }
  return bench.state().faults;
}

namespace {

constexpr int kCyclesStopped = 2000;

void watch_stop(Bench& bench, StopCase& seen) {
  seen.energy_at_stop = bench.kinetic_energy();
  seen.way_beyond = bench.way_beyond();
  double given = 0.0;
  for (int cycle = 0; cycle < kCyclesStopped; ++cycle) {
    bench.step();
    const bool has_torque = !bench.driver().torque().isZero(0.0);
    if (has_torque) seen.cycles_under_torque = cycle + 1;
    if (!has_torque && seen.cycles_under_torque == cycle) seen.speed_when_dropped = bench.speed();
    given += 0.001 * bench.power();
    seen.energy_put_in = std::max(seen.energy_put_in, given);
    seen.way_beyond = std::max(seen.way_beyond, bench.way_beyond());
  }
  seen.energy_taken = -given;
}

}  // namespace

StopCase run_stop_case(std::uint64_t seed, std::optional<DeviceFault> fault, const Hardness& hardness) {
  for (std::uint64_t draw = 0; draw < 100; ++draw) {
    Bench bench(seed + 1'000'003 * draw, hardness);
    const auto axis = static_cast<std::size_t>(bench.integer(0, 1));
    if (!go_to(bench, kPhases[bench.integer(0, 5)])) continue;
    if (fault) bench.driver().begin(*fault, axis, 1.0);
    for (int i = bench.integer(0, 400); i > 0 && bench.state().faults == 0; --i) bench.step();
    if (bench.state().faults != 0) continue;
    StopCase seen;
    bench.stop();
    watch_stop(bench, seen);
    return seen;
  }
  throw std::runtime_error("no trial lasts until its stop");
}

}  // namespace tonus::testing
