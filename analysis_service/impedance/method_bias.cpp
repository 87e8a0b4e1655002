#include "analysis_service/impedance/method_bias.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "analysis_service/impedance/fit_signals.hpp"
#include "analysis_service/impedance/mean_motion.hpp"
#include "analysis_service/impedance/parameters.hpp"
#include "analysis_service/impedance/pooled_fit.hpp"
#include "analysis_service/impedance/sized.hpp"
#include "analysis_service/impedance/uncertainty.hpp"
#include "analysis_service/impedance/unit_factor.hpp"

namespace tonus::impedance {
namespace {

constexpr int kPairs = 2;  // of conditions with opposite signs

/// M, B, K of all trials pooled by a published method; no intervals.
template <int kSize, int kAxes>
Parameters fit_of(const std::vector<Trial>& trials, const Options& options, double natural_frequency) {
  RecursiveLeastSquares<kSize, kAxes> factor;
  for (const Trial& trial : trials) {
    const auto rows = static_cast<Eigen::Index>(std::llround(options.window / trial.sample_period));
    factor.merge(factor_of<kSize, kAxes>(fit_signals(trial, options, natural_frequency), trial.onset, rows));
  }
  return parameters_from(solve(factor), kAxes);
}

/// By the method's own numbers plus a change.
EllipseIntervals shifted_intervals(const AxisMatrix& value, const MatrixUncertainty& uncertainty,
                                   const AxisMatrix& change) {
  const Eigen::Matrix4d covariance = uncertainty.covariance;
  return ellipse_intervals(Eigen::Matrix2d(value + change), covariance, [&](const Eigen::Vector4d& weights) {
    return CombinationSpread{std::sqrt(weights.dot(covariance * weights)), uncertainty.freedom};
  });
}

void widen_one(AxisMatrix Parameters::*matrix, const Parameters& by, Estimate& estimate) {
  const AxisMatrix& change = by.*matrix;
  MatrixUncertainty& uncertainty = uncertainty_of(estimate, matrix);
  AxisMatrix& low = estimate.low.*matrix;
  AxisMatrix& high = estimate.high.*matrix;
  low = low.cwiseMin(low + change).eval();
  high = high.cwiseMax(high + change).eval();
  if (uncertainty.ellipse)
    uncertainty.ellipse =
        hull(*uncertainty.ellipse, shifted_intervals(estimate.value.*matrix, uncertainty, change));
}

}  // namespace

ResampledCondition::ResampledCondition(std::span<const Trial* const> trials, const Eigen::MatrixXd& theta,
                                       refined::CommandMotion motion)
    : rest_(motion.rest), motion_(std::move(motion)) {
  const Trial& first = *trials.front();
  form_.sample_period = first.sample_period;
  form_.handle_mass = first.handle_mass;
  form_.onset = rest_;
  impedance_ = parameters_from(theta, first.axes());
  impedance_.X0.resize(0);
  offset_ = AxisVector::Zero(first.axes());
  const Eigen::Index rows = motion_.of_axis.front().x.rows();
  for (std::size_t j = 0; j < trials.size(); ++j) {
    const Trial& trial = *trials[j];
    const Beyond clean = predicted(j, impedance_);
    const Eigen::Index begin = trial.onset - rest_;
    const bool has_command = trial.commanded.rows() == trial.samples();
    commanded_.push_back(has_command ? Signals(trial.commanded.middleRows(begin, rows)) : Signals());
    beyond_.push_back({trial.displacement.middleRows(begin, rows) - clean.displacement,
                       trial.force.middleRows(begin, rows) - clean.force});
    offset_ += mean_of_rows(beyond_.back().force, 0, rest_) / static_cast<double>(trials.size());
  }
  for (Beyond& one : beyond_) one.force.rowwise() -= offset_.transpose();
}

ResampledCondition::Beyond ResampledCondition::predicted(std::size_t number,
                                                         const Parameters& impedance) const {
  const Eigen::Index axes = motion_.targets.cols();
  const Eigen::Index rows = motion_.of_axis.front().x.rows();
  Signals x = Signals::Zero(rows, axes);
  Signals v = x;
  Signals a = x;
  for (Eigen::Index b = 0; b < axes; ++b) {
    const double share = motion_.targets(static_cast<Eigen::Index>(number), b);
    const refined::AxisMotion& of = motion_.of_axis[static_cast<std::size_t>(b)];
    x += share * of.x;
    v += share * of.v;
    a += share * of.a;
  }
  Eigen::MatrixXd M = impedance.M;
  M.diagonal().array() += form_.handle_mass;
  Signals force = a * M.transpose() + v * Eigen::MatrixXd(impedance.B).transpose() +
                  x * Eigen::MatrixXd(impedance.K).transpose();
  return {std::move(x), std::move(force)};
}

Trial ResampledCondition::trial(std::size_t number, std::size_t of, double sign,
                                const Parameters& impedance) const {
  Beyond clean = predicted(number, impedance);
  Trial trial = form_;
  trial.number = static_cast<std::uint32_t>(number + 1);
  trial.commanded = commanded_[number];
  trial.displacement = clean.displacement + sign * beyond_[of].displacement;
  trial.force = (clean.force + sign * beyond_[of].force).rowwise() + offset_.transpose();
  return trial;
}

std::optional<Parameters> method_bias(std::span<const Trial* const> trials, const refined::Estimate& found,
                                      const Options& options, double natural_frequency) {
  const bool is_published = options.method != Method::kRefined && options.method != Method::kSpectral;
  if (!is_published || options.model != Model::kLinear) return std::nullopt;
  if (found.shortage != refined::Shortage::kNone) return std::nullopt;
  const auto used = trials.first(std::min(trials.size(), kBiasTrials));
  refined::CommandMotion motion = mean_motion(trials, options.window);
  if (motion.rest == 0) return std::nullopt;
  const ResampledCondition condition(used, found.theta, std::move(motion));
  const int axes = trials.front()->axes();
  const auto fitted = [&](const std::vector<double>& signs, double of_all) {
    std::vector<Trial> made;
    for (std::size_t j = 0; j < condition.size(); ++j)
      made.push_back(condition.trial(j, j, of_all * signs[j], condition.impedance()));
    return with_sizes(options.model, axes, [&]<int kSize, int kAxes>() {
      return fit_of<kSize, kAxes>(made, options, natural_frequency);
    });
  };
  std::mt19937_64 random(1);
  Parameters bias = condition.impedance();
  for (AxisMatrix* matrix : {&bias.M, &bias.B, &bias.K}) matrix->setZero();
  for (int pair = 0; pair < kPairs; ++pair) {
    std::vector<double> signs;
    for (std::size_t j = 0; j < condition.size(); ++j) signs.push_back((random() & 1U) != 0U ? 1.0 : -1.0);
    for (const double of_all : {1.0, -1.0}) {
      const Parameters one = fitted(signs, of_all);
      for (const auto matrix : {&Parameters::M, &Parameters::B, &Parameters::K})
        bias.*matrix += (one.*matrix - condition.impedance().*matrix) / (2.0 * kPairs);
    }
  }
  const bool is_finite = bias.M.allFinite() && bias.B.allFinite() && bias.K.allFinite();
  return is_finite ? std::optional(bias) : std::nullopt;
}

void state_bias(const Parameters& bias, Estimate& estimate) {
  for (const auto matrix : {&Parameters::M, &Parameters::B, &Parameters::K})
    uncertainty_of(estimate, matrix).known_bias = bias.*matrix;
}

void widen(const Parameters& change, Estimate& estimate) {
  for (const auto matrix : {&Parameters::M, &Parameters::B, &Parameters::K})
    widen_one(matrix, change, estimate);
}

void carry_bias(const Parameters& bias, Estimate& estimate) {
  widen({-bias.M, -bias.B, -bias.K, {}}, estimate);
  state_bias(bias, estimate);
}

}  // namespace tonus::impedance
