#include "analysis_service/refined/command_response.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <unsupported/Eigen/MatrixFunctions>
#include <utility>

#include "analysis_service/refined/weak_form.hpp"

namespace tonus::refined {
namespace {

constexpr double kGoodFit = 0.02;      // Share left unexplained below which no other start is tried.
constexpr double kLongestDelay = 0.1;  // s, either way.
constexpr int kMostSteps = 40;
constexpr double kLeastGain = 1e-5;  // Of the squares, by a step: less is the minimum.

/// Output error of (3) for one number of axes.
template <int kAxes>
class OutputError {
 public:
  static constexpr int kElements = kAxes * kAxes;
  static constexpr int kUnknowns = 3 * kElements + 1;
  using Matrix = Eigen::Matrix<double, kAxes, kAxes>;
  using Unknowns = Eigen::Vector<double, kUnknowns>;  // P, Q, G column by column, delay

  explicit OutputError(const MeanResponse& measured) : measured_(measured) {
    if (measured.of_axis.empty()) return;  // nothing to fit, only to respond to
    const Eigen::Index rows = measured.shape.size();
    target_.resize(rows, kElements);
    for (Eigen::Index b = 0; b < kAxes; ++b) {
      const auto& response = measured.of_axis[static_cast<std::size_t>(b)];
      target_.middleCols(b * kAxes, kAxes) = response;
    }
    take_rest(target_);
  }

  [[nodiscard]] double squares() const { return target_.squaredNorm(); }

  /// R(t) of (3), rows x elements; not finite where (3) has no solution. `rate`, where asked for: R'(t).
  [[nodiscard]] Eigen::MatrixXd response(const Unknowns& p, Eigen::MatrixXd* rate = nullptr) const {
    using State = Eigen::Matrix<double, 2 * kAxes, kAxes>;
    constexpr int kSize = 4 * kAxes;
    const double h = measured_.sample_period;
    const Matrix inertia = p.template head<kElements>().reshaped(kAxes, kAxes).inverse();
    Eigen::Matrix<double, kSize, kSize> held = Eigen::Matrix<double, kSize, kSize>::Zero();
    held.template block<kAxes, kAxes>(0, kAxes) = h * Matrix::Identity();
    held.template block<kAxes, kAxes>(kAxes, 0) = -h * inertia;
    held.template block<kAxes, kAxes>(kAxes, kAxes) =
        -h * inertia * p.template segment<kElements>(kElements).reshaped(kAxes, kAxes);
    held.template block<kAxes, kAxes>(kAxes, 2 * kAxes) =
        h * inertia * p.template segment<kElements>(2 * kElements).reshaped(kAxes, kAxes);
    held.template block<kAxes, kAxes>(2 * kAxes, 3 * kAxes) = Matrix::Identity();
    const Eigen::Index rows = measured_.shape.size();
    Eigen::MatrixXd out = Eigen::MatrixXd::Zero(rows, kElements);
    if (rate != nullptr) *rate = out;
    if (!held.allFinite() || held.norm() > 1e3) {
      out.fill(std::numeric_limits<double>::quiet_NaN());
      return out;
    }
    // Exact for a command that is straight between rows: x+ = E x + G1 s + G2 (s+ - s).
    const Eigen::Matrix<double, kSize, kSize> step = held.exp();
    const Eigen::Matrix<double, 2 * kAxes, 2 * kAxes> E = step.template topLeftCorner<2 * kAxes, 2 * kAxes>();
    const State G1 = step.template block<2 * kAxes, kAxes>(0, 2 * kAxes);
    const State G2 = step.template block<2 * kAxes, kAxes>(0, 3 * kAxes);
    const double delay = p[kUnknowns - 1] / h;
    State x = State::Zero();
    double before = command(-delay);
    for (Eigen::Index k = 1; k < rows; ++k) {
      const double now = command(static_cast<double>(k) - delay);
      x = (E * x + G1 * before + G2 * (now - before)).eval();
      out.row(k) = x.template topRows<kAxes>().reshaped().transpose();
      if (rate != nullptr) rate->row(k) = x.template bottomRows<kAxes>().reshaped().transpose();
      before = now;
    }
    return out;
  }

  /// The motion by axis: x" by (3) itself.
  [[nodiscard]] std::vector<AxisMotion> motion(const Unknowns& p) const {
    Eigen::MatrixXd rate;
    const Eigen::MatrixXd place = response(p, &rate);
    const Matrix inertia = p.template head<kElements>().reshaped(kAxes, kAxes).inverse();
    const Matrix Q = p.template segment<kElements>(kElements).reshaped(kAxes, kAxes);
    const Matrix G = p.template segment<kElements>(2 * kElements).reshaped(kAxes, kAxes);
    const double delay = p[kUnknowns - 1] / measured_.sample_period;
    std::vector<AxisMotion> all;
    for (Eigen::Index b = 0; b < kAxes; ++b) {
      AxisMotion one{place.middleCols(b * kAxes, kAxes), rate.middleCols(b * kAxes, kAxes), {}};
      one.a.resize(place.rows(), kAxes);
      for (Eigen::Index k = 0; k < place.rows(); ++k) {
        const Eigen::Vector<double, kAxes> driven = G.col(b) * command(static_cast<double>(k) - delay);
        one.a.row(k) =
            (inertia * (driven - Q * one.v.row(k).transpose() - one.x.row(k).transpose())).transpose();
      }
      all.push_back(std::move(one));
    }
    return all;
  }

  [[nodiscard]] double error(const Unknowns& p, Eigen::MatrixXd& residual) const {
    residual = target_ - response(p);
    const double squares = residual.squaredNorm();
    const bool is_allowed = std::abs(p[kUnknowns - 1]) < kLongestDelay;
    return std::isfinite(squares) && is_allowed ? squares : std::numeric_limits<double>::infinity();
  }

  /// (3) by least squares in the weak form; without delay.
  [[nodiscard]] Unknowns start() const {
    const WeakForm weak(measured_.shape.size(), measured_.sample_period, step_of(measured_.sample_period));
    const Eigen::Index n = weak.size();
    const Eigen::VectorXd s = weak.apply(0, measured_.shape);
    Eigen::MatrixXd left = Eigen::MatrixXd::Zero(n * kAxes, 3 * kAxes);
    Eigen::MatrixXd right(n * kAxes, kAxes);
    for (Eigen::Index b = 0; b < kAxes; ++b) {
      const Eigen::MatrixXd x = target_.middleCols(b * kAxes, kAxes);
      left.block(b * n, 0, n, kAxes) = -weak.apply(2, x);
      left.block(b * n, kAxes, n, kAxes) = -weak.apply(1, x);
      left.col(2 * kAxes + b).segment(b * n, n) = s;
      right.middleRows(b * n, n) = weak.apply(0, x);
    }
    const Eigen::MatrixXd C = left.colPivHouseholderQr().solve(right);
    Unknowns p = Unknowns::Zero();
    for (Eigen::Index i = 0; i < 3; ++i)
      p.template segment<kElements>(i * kElements) =
          Matrix(C.middleRows(i * kAxes, kAxes).transpose()).reshaped();
    return p;
  }

  [[nodiscard]] static Unknowns oscillator(double frequency) {
    Unknowns p = Unknowns::Zero();
    const Matrix one = Matrix::Identity();
    p.template head<kElements>() = (one / (frequency * frequency)).reshaped();
    p.template segment<kElements>(kElements) = (0.6 / frequency * one).reshaped();
    p.template segment<kElements>(2 * kElements) = one.reshaped();
    return p;
  }

  /// Size that a change of each unknown is measured by.
  [[nodiscard]] static Unknowns scale() {
    Unknowns scale;
    scale << Eigen::Vector<double, kElements>::Constant(2e-3),
        Eigen::Vector<double, kElements>::Constant(1e-2), Eigen::Vector<double, kElements>::Ones(), 0.01;
    return scale;
  }

 private:
  void take_rest(Eigen::MatrixXd& signals) const {
    if (measured_.rest == 0) return;
    const Eigen::RowVectorXd mean = signals.topRows(measured_.rest).colwise().mean();
    signals.rowwise() -= mean;
  }

  /// The command at a row that need not be whole.
  [[nodiscard]] double command(double row) const {
    const auto last = static_cast<double>(measured_.shape.size() - 1);
    const double at = std::clamp(row, 0.0, last);
    const auto below = static_cast<Eigen::Index>(at);
    const Eigen::Index above = std::min(below + 1, measured_.shape.size() - 1);
    const double share = at - static_cast<double>(below);
    return (1.0 - share) * measured_.shape[below] + share * measured_.shape[above];
  }

  const MeanResponse& measured_;
  Eigen::MatrixXd target_;  // rows x elements
};

/// Levenberg-Marquardt from `p`; returns the squares left.
template <int kAxes>
double minimise(const OutputError<kAxes>& problem, typename OutputError<kAxes>::Unknowns& p) {
  using Problem = OutputError<kAxes>;
  constexpr int kUnknowns = Problem::kUnknowns;
  constexpr double kProbe = 1e-5;
  const auto scale = Problem::scale();
  Eigen::MatrixXd residual;
  double squares = problem.error(p, residual);
  double damping = 1e-3;
  Eigen::MatrixXd slopes(residual.size(), kUnknowns);
  for (int step = 0; step < kMostSteps && std::isfinite(squares); ++step) {
    for (int i = 0; i < kUnknowns; ++i) {
      auto probe = p;
      probe[i] += kProbe * scale[i];
      Eigen::MatrixXd moved;
      if (!std::isfinite(problem.error(probe, moved))) return squares;
      slopes.col(i) = (residual - moved).reshaped() / kProbe;
    }
    Eigen::Matrix<double, kUnknowns, kUnknowns> H = slopes.transpose() * slopes;
    const Eigen::Vector<double, kUnknowns> g = slopes.transpose() * residual.reshaped();
    const double before = squares;
    for (; damping < 1e8; damping *= 10.0) {
      auto damped = H;
      damped.diagonal() *= 1.0 + damping;
      damped.diagonal().array() += 1e-12 * H.diagonal().maxCoeff();
      const auto next = (p + scale.cwiseProduct(damped.ldlt().solve(g))).eval();
      Eigen::MatrixXd there;
      const double found = problem.error(next, there);
      if (!(found < squares)) continue;
      p = next;
      residual = std::move(there);
      squares = found;
      damping = std::max(damping / 10.0, 1e-9);
      break;
    }
    if (!(before - squares > kLeastGain * before)) break;
  }
  return squares;
}

template <int kAxes>
CommandResponse fit(const MeanResponse& measured) {
  using Problem = OutputError<kAxes>;
  const Problem problem(measured);
  CommandResponse found;
  const double whole = problem.squares();
  if (!(whole > 0.0)) return found;
  std::optional<typename Problem::Unknowns> best;
  double least = std::numeric_limits<double>::infinity();
  for (typename Problem::Unknowns p :
       {problem.start(), Problem::oscillator(20.0), Problem::oscillator(12.0), Problem::oscillator(35.0)}) {
    if (!p.allFinite()) continue;
    const double left = minimise(problem, p);
    if (!(left < least)) continue;
    least = left;
    best = p;
    if (least < kGoodFit * whole) break;
  }
  if (!best) return found;
  const Eigen::MatrixXd response = problem.response(*best);
  for (Eigen::Index b = 0; b < kAxes; ++b) found.of_axis.emplace_back(response.middleCols(b * kAxes, kAxes));
  found.unexplained = least / whole;
  found.unknowns = *best;
  found.is_found = true;
  return found;
}

}  // namespace

std::vector<AxisMotion> motion_of(const CommandResponse& fitted, Eigen::Index axes,
                                  const Eigen::VectorXd& shape, double sample_period) {
  MeanResponse command;
  command.sample_period = sample_period;
  command.shape = shape;
  if (axes == 1) return OutputError<1>(command).motion(fitted.unknowns);
  return OutputError<2>(command).motion(fitted.unknowns);
}

CommandResponse command_response(const MeanResponse& measured) {
  return measured.of_axis.size() == 1 ? fit<1>(measured) : fit<2>(measured);
}

}  // namespace tonus::refined
