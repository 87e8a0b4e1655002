#include "analysis_service/certify/bound.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

namespace tonus::certify {
namespace {

using Complex = std::complex<double>;
constexpr double kTwoPi = 2.0 * std::numbers::pi;
constexpr Eigen::Index kFrequencies = 4096;  // Of the circle; the slowest process, drift, is 0.1 Hz wide.

/// Spectrum of a sampled first-order process of unit variance and pole p, at angle w.
double first_order(Complex p, double w) {
  const Complex z = std::polar(1.0, w);
  return (1.0 - std::norm(p)) / std::norm(z - p);
}

/// Covariance of e by lag, 2x2, from its spectrum.
std::vector<Eigen::Matrix2d> lagged_covariance(const Truth& truth, const Design& design,
                                               const Setting& setting, Eigen::Index lags) {
  const Sensors& sensors = setting.sensors;
  const Disturbance& disturbance = setting.disturbance;
  const double drift_pole = std::exp(-design.sample_period / disturbance.drift_time);
  const Complex tremor_pole =
      std::polar(std::exp(-kTwoPi * disturbance.tremor_bandwidth * design.sample_period),
                 kTwoPi * disturbance.tremor_frequency * design.sample_period);
  const Eigen::Matrix2d steps = sensors.encoder_step * truth.rig_jacobian;
  const Eigen::Matrix2d noise =
      sensors.displacement_noise * sensors.displacement_noise * Eigen::Matrix2d::Identity() +
      steps * steps.transpose() / 12.0;
  std::vector<Eigen::Matrix2cd> spectrum;
  for (Eigen::Index i = 0; i < kFrequencies; ++i) {
    const double w = kTwoPi * static_cast<double>(i) / kFrequencies;
    const double signed_w = w < std::numbers::pi ? w : w - kTwoPi;
    const Complex s(0.0, signed_w / design.sample_period);
    const Eigen::Matrix2cd Z = truth.arm.M * s * s + truth.arm.B * s + truth.arm.K.cast<Complex>();
    const double own = disturbance.drift * disturbance.drift * first_order(drift_pole, w) +
                       disturbance.tremor * disturbance.tremor * 0.5 *
                           (first_order(tremor_pole, w) + first_order(std::conj(tremor_pole), w));
    Eigen::Matrix2cd S = Z * noise.cast<Complex>() * Z.adjoint();
    S.diagonal().array() += sensors.force_noise * sensors.force_noise + own;
    spectrum.push_back(S);
  }
  std::vector<Eigen::Matrix2d> covariance;
  for (Eigen::Index lag = 0; lag < lags; ++lag) {
    Eigen::Matrix2cd sum = Eigen::Matrix2cd::Zero();
    for (Eigen::Index i = 0; i < kFrequencies; ++i)
      sum += spectrum[static_cast<std::size_t>(i)] *
             std::polar(1.0, kTwoPi * static_cast<double>((i * lag) % kFrequencies) / kFrequencies);
    covariance.emplace_back(sum.real() / static_cast<double>(kFrequencies));
  }
  return covariance;
}

/// E e(t + k) e(t)' by lag, as the matrix of a trial.
Eigen::MatrixXd trial_covariance(const std::vector<Eigen::Matrix2d>& by_lag) {
  const auto n = static_cast<Eigen::Index>(by_lag.size());
  Eigen::MatrixXd gamma(2 * n, 2 * n);
  for (Eigen::Index t = 0; t < n; ++t) {
    for (Eigen::Index s = 0; s < n; ++s) {
      const auto& C = by_lag[static_cast<std::size_t>(std::abs(t - s))];
      for (Eigen::Index i = 0; i < 2; ++i) {
        for (Eigen::Index j = 0; j < 2; ++j) gamma(i * n + t, j * n + s) = t >= s ? C(i, j) : C(j, i);
      }
    }
  }
  return gamma;
}

}  // namespace

Eigen::MatrixXd cramer_rao(const std::vector<Eigen::MatrixXd>& regressors, const Eigen::MatrixXd& gamma,
                           int axes) {
  const Eigen::Index n = regressors.front().rows();
  const Eigen::Index q = regressors.front().cols();
  const Eigen::LLT<Eigen::MatrixXd> factor(gamma);
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(axes * q, axes * q);
  for (const Eigen::MatrixXd& phi : regressors) {
    Eigen::MatrixXd X = Eigen::MatrixXd::Zero(axes * n, axes * q);
    for (Eigen::Index axis = 0; axis < axes; ++axis) X.block(axis * n, axis * q, n, q) = phi;
    const Eigen::MatrixXd whitened = factor.matrixL().solve(X);
    information += whitened.transpose() * whitened;
  }
  const Eigen::VectorXd scale = information.diagonal().cwiseSqrt().cwiseInverse();
  return scale.asDiagonal() * (scale.asDiagonal() * information * scale.asDiagonal()).inverse() *
         scale.asDiagonal();
}

Eigen::VectorXd bound_of(const Truth& truth, const Design& design, const Setting& setting) {
  std::mt19937_64 unused(0);
  std::vector<Eigen::MatrixXd> regressors;
  for (int number = 0; number < std::min(design.trials, 8); ++number) {
    const Motion motion = simulate_motion(truth, design, {}, target_of(design, number), unused);
    Eigen::MatrixXd phi(motion.x.rows(), 7);
    phi << motion.acceleration, motion.velocity, motion.x, Eigen::VectorXd::Ones(motion.x.rows());
    regressors.push_back(std::move(phi));
  }
  const auto gamma = trial_covariance(lagged_covariance(truth, design, setting, regressors.front().rows()));
  // The directions repeat, so that more trials divide the variance.
  const double repeats = static_cast<double>(design.trials) / static_cast<double>(regressors.size());
  const Eigen::VectorXd variance = cramer_rao(regressors, gamma, 2).diagonal() / repeats;
  Eigen::VectorXd bound(12);
  for (Eigen::Index matrix = 0; matrix < 3; ++matrix) {
    for (Eigen::Index column = 0; column < 2; ++column) {
      for (Eigen::Index row = 0; row < 2; ++row)
        bound[4 * matrix + 2 * column + row] = std::sqrt(variance[7 * row + 2 * matrix + column]);
    }
  }
  return bound;
}

}  // namespace tonus::certify
