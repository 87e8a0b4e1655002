#include "analysis_service/certify/imperfect_arm.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <vector>

#include "analysis_service/certify/own_force.hpp"

namespace tonus::certify {
namespace {

constexpr double kStep = 2e-4;             // s
constexpr int kStepsOfForce = 5;           // The own force is straight in between.
constexpr double kSettling = 1.5;          // s before the rest
constexpr double kAmplitude = 0.005;       // m, of the secant
constexpr double kContactStiffness = 1e5;  // N/m
constexpr double kContactDamping = 200.0;  // N s/m
constexpr double kSlow = 5e-4;             // m/s, at which friction has half its force

/// Handle and hand; one and the same without slack.
struct State {
  Eigen::Vector2d x, v, y, w;
};

State moved(const State& at, const State& slope, double h) {
  return {at.x + h * slope.x, at.v + h * slope.v, at.y + h * slope.y, at.w + h * slope.w};
}

class ImperfectArm {
 public:
  ImperfectArm(const Truth& truth, const ModelError& error)
      : truth_(truth),
        error_(error),
        inverse_hand_(truth.arm.M.inverse()),
        inverse_handle_(truth.rig_mass.inverse()),
        inverse_both_((truth.arm.M + truth.rig_mass).inverse()) {}

  /// Force that moves the hand at y with velocity w without acceleration.
  [[nodiscard]] Eigen::Vector2d resistance(const State& at, const Eigen::Vector2d& own) const {
    const double harder = 1.0 + error_.hardening * at.y.squaredNorm() / (kAmplitude * kAmplitude);
    return truth_.arm.B * at.w + truth_.arm.K * (harder * at.y + error_.reflex * delayed()) +
           error_.friction / (at.w.norm() + kSlow) * at.w - own;
  }

  [[nodiscard]] Eigen::Vector2d force(const State& at, const Eigen::Vector2d& own,
                                      const Eigen::Vector2d& command) const {
    if (error_.slack > 0.0) return contact(at);
    const Eigen::Vector2d resisted = resistance(at, own);
    return truth_.arm.M * (inverse_both_ * (drive(at, command) - resisted)) + resisted;
  }

  [[nodiscard]] State slope(const State& at, const Eigen::Vector2d& own,
                            const Eigen::Vector2d& command) const {
    const Eigen::Vector2d resisted = resistance(at, own);
    if (error_.slack > 0.0) {
      const Eigen::Vector2d f = contact(at);
      return {at.v, inverse_handle_ * (drive(at, command) - f), at.w, inverse_hand_ * (f - resisted)};
    }
    const Eigen::Vector2d a = inverse_both_ * (drive(at, command) - resisted);
    return {at.v, a, at.w, a};
  }

  void remember(const Eigen::Vector2d& y) { past_.push_back(y); }

 private:
  [[nodiscard]] Eigen::Vector2d drive(const State& at, const Eigen::Vector2d& command) const {
    return truth_.rig_stiffness * (command - at.x) - truth_.rig_damping * at.v;
  }
  [[nodiscard]] Eigen::Vector2d contact(const State& at) const {
    const Eigen::Vector2d apart = at.x - at.y;
    const double distance = apart.norm();
    if (distance <= error_.slack) return Eigen::Vector2d::Zero();
    const Eigen::Vector2d n = apart / distance;
    const double push = kContactStiffness * (distance - error_.slack) + kContactDamping * n.dot(at.v - at.w);
    return std::max(0.0, push) * n;
  }
  [[nodiscard]] Eigen::Vector2d delayed() const {
    const auto late = static_cast<std::size_t>(std::llround(error_.reflex_delay / kStep));
    return past_.size() > late ? past_[past_.size() - 1 - late] : Eigen::Vector2d::Zero();
  }

  const Truth& truth_;
  const ModelError& error_;
  Eigen::Matrix2d inverse_hand_;
  Eigen::Matrix2d inverse_handle_;
  Eigen::Matrix2d inverse_both_;
  std::vector<Eigen::Vector2d> past_;  // of the hand, by step
};

State stepped(const ImperfectArm& arm, const State& z, const Eigen::Vector2d& own0,
              const Eigen::Vector2d& own1, const Eigen::Vector2d& command0, const Eigen::Vector2d& command1) {
  const Eigen::Vector2d own = 0.5 * (own0 + own1);
  const Eigen::Vector2d command = 0.5 * (command0 + command1);
  const State a = arm.slope(z, own0, command0);
  const State b = arm.slope(moved(z, a, 0.5 * kStep), own, command);
  const State c = arm.slope(moved(z, b, 0.5 * kStep), own, command);
  const State d = arm.slope(moved(z, c, kStep), own1, command1);
  const State sum = moved(moved(moved(a, b, 2.0), c, 2.0), d, 1.0);
  return moved(z, sum, kStep / 6.0);
}

}  // namespace

Motion simulate_imperfect(const Truth& truth, const Design& design, const Disturbance& disturbance,
                          const ModelError& error, const Eigen::Vector2d& target, std::mt19937_64& random) {
  const auto steps = static_cast<Eigen::Index>(std::llround(design.sample_period / kStep));
  const auto rest = static_cast<Eigen::Index>(std::llround(design.rest / design.sample_period));
  const auto rows = rest + static_cast<Eigen::Index>(std::llround(design.window / design.sample_period));
  ImperfectArm arm(truth, error);
  OwnForce own_force(disturbance, kStepsOfForce * kStep, random);
  const auto command = [&](double t) -> Eigen::Vector2d {
    return std::clamp(t / std::max(design.rise, kStep), 0.0, 1.0) * target;
  };
  Motion motion{Eigen::MatrixXd(rows, 2), Eigen::MatrixXd(rows, 2), Eigen::MatrixXd(0, 2),
                Eigen::MatrixXd(rows, 2), Eigen::MatrixXd(rows, 2)};
  Eigen::Vector2d before = own_force.next();
  Eigen::Vector2d after = own_force.next();
  State z{Eigen::Vector2d::Zero(), Eigen::Vector2d::Zero(), Eigen::Vector2d::Zero(), Eigen::Vector2d::Zero()};
  const auto settling = static_cast<Eigen::Index>(std::llround(kSettling / kStep));
  for (Eigen::Index i = 0; i < settling + rows * steps; ++i) {
    const Eigen::Index phase = i % kStepsOfForce;
    if (i > 0 && phase == 0) {
      before = after;
      after = own_force.next();
    }
    const Eigen::Vector2d own0 = before + static_cast<double>(phase) / kStepsOfForce * (after - before);
    const Eigen::Vector2d own1 = before + static_cast<double>(phase + 1) / kStepsOfForce * (after - before);
    const double t = static_cast<double>(i - settling - rest * steps) * kStep;
    arm.remember(z.y);
    if (i >= settling && (i - settling) % steps == 0) {
      const Eigen::Index row = (i - settling) / steps;
      motion.x.row(row) = z.x.transpose();
      motion.velocity.row(row) = z.v.transpose();
      motion.force.row(row) = arm.force(z, own0, command(t)).transpose();
      motion.commanded.row(row) = command(t).transpose();
    }
    z = stepped(arm, z, own0, own1, command(t), command(t + kStep));
  }
  return motion;
}

impedance::CartesianImpedance slow_impedance(const Truth& truth, const ModelError& error) {
  const double d = error.reflex_delay;
  impedance::CartesianImpedance slow = truth.arm;
  slow.M += 0.5 * error.reflex * d * d * truth.arm.K;
  slow.B -= error.reflex * d * truth.arm.K;
  slow.K *= 1.0 + error.reflex + error.hardening;
  return slow;
}

}  // namespace tonus::certify
