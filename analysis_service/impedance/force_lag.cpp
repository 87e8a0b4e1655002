#include "analysis_service/impedance/force_lag.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <optional>

namespace tonus::impedance {
namespace {

/// Rows of the response that are examined, and how far the force is shifted.
struct Examined {
  Eigen::Index first = 0;
  Eigen::Index rows = 0;
  Eigen::Index reach = 0;  ///< Rows, to both sides.
};

std::optional<Examined> examined_rows(const ConditionResponse& response, double frequency) {
  const auto rows_in = [&response](double duration) {
    return static_cast<Eigen::Index>(std::llround(duration / response.sample_period));
  };
  const Eigen::Index regressors = 3 * response.axes() + 1;
  const Eigen::Index reach = rows_in(kLagScanned);
  const Eigen::Index before = std::min(response.rest - reach, rows_in(0.1));
  const Eigen::Index after = std::min(rows_in(1.25 / frequency), response.rows() - response.rest - reach);
  if (before < 1 || after < 4 * regressors) return std::nullopt;
  return Examined{response.rest - before, before + after, reach};
}

/// What one channel shows at one shift.
struct Fit {
  double misfit = 0.0;
  bool is_possible = false;
  double share = 0.0;  ///< Root mean square of the residual over that of the force.
};

/// Model (3) against the response at any shift of the force.
class ShiftedFit {
 public:
  ShiftedFit(const ConditionResponse& response, const Examined& examined)
      : axes_(response.axes()), examined_(examined) {
    const Eigen::Index rows = examined.rows;
    for (Eigen::Index i = 0; i < axes_; ++i) {
      mean_states_.push_back(response.mean(response.states, i));
      mean_force_.push_back(response.mean(response.force, i));
    }
    Eigen::MatrixXd Phi(axes_ * rows, 3 * axes_ + 1);
    for (Eigen::Index i = 0; i < axes_; ++i) {
      Phi.block(i * rows, 0, rows, 3 * axes_) = mean_states_[at(i)].middleRows(examined.first, rows);
    }
    Phi.rightCols(1).setOnes();
    const Eigen::HouseholderQR<Eigen::MatrixXd> qr(Phi);
    Q_ = qr.householderQ() * Eigen::MatrixXd::Identity(Phi.rows(), Phi.cols());
    R_ = qr.matrixQR().topRows(Phi.cols());

    take_own(response);
    own_square_ = own_states_.transpose() * own_states_;
    const auto freedom = static_cast<double>(response.displacements.rows() - axes_);
    own_share_ = response.weights.squaredNorm() / freedom;
  }

  /// Of each channel.
  [[nodiscard]] std::vector<Fit> at_shift(Eigen::Index shift) const {
    const Eigen::Index first = examined_.first + shift;
    const Eigen::MatrixXd F = stacked(mean_force_, first);
    const Eigen::MatrixXd Z = Q_.transpose() * F;
    const Eigen::MatrixXd Theta = R_.triangularView<Eigen::Upper>().solve(Z);
    const Eigen::VectorXd residual = (F - Q_ * Z).colwise().squaredNorm();
    const Eigen::MatrixXd own_force = stacked(own_force_, first);
    const Eigen::MatrixXd own_product = own_states_.transpose() * own_force;
    std::vector<Fit> fits;
    for (Eigen::Index i = 0; i < axes_; ++i) {
      const Eigen::VectorXd theta = Theta.col(i).head(3 * axes_);
      // ||own force - own states theta||^2; at least rounding of the residual, for signals without noise.
      const double own = own_force.col(i).squaredNorm() - 2.0 * theta.dot(own_product.col(i)) +
                         theta.dot(own_square_ * theta);
      const double expected = std::max(own_share_ * own, kRounding * F.col(i).squaredNorm());
      fits.push_back({expected > 0.0 ? residual[i] / expected : 1.0,
                      theta[i] > 0.0 && theta[axes_ + i] > 0.0 && theta[2 * axes_ + i] > 0.0,
                      std::sqrt(residual[i] / std::max(F.col(i).squaredNorm(), 1e-300))});
    }
    return fits;
  }

 private:
  static constexpr double kRounding = 1e-12;

  [[nodiscard]] static std::size_t at(Eigen::Index i) { return static_cast<std::size_t>(i); }

  /// The examined number of rows from `first` on, one signal below the other.
  [[nodiscard]] Eigen::MatrixXd stacked(const std::vector<Eigen::MatrixXd>& signals,
                                        Eigen::Index first) const {
    const Eigen::Index rows = examined_.rows;
    Eigen::MatrixXd all(static_cast<Eigen::Index>(signals.size()) * rows, signals.front().cols());
    for (std::size_t n = 0; n < signals.size(); ++n) {
      all.middleRows(static_cast<Eigen::Index>(n) * rows, rows) = signals[n].middleRows(first, rows);
    }
    return all;
  }

  /// What is the trials' own: their signals less their displacement times the response.
  void take_own(const ConditionResponse& response) {
    std::vector<Eigen::MatrixXd> states = response.states;
    own_force_ = response.force;
    for (std::size_t g = 0; g < states.size(); ++g) {
      for (Eigen::Index i = 0; i < axes_; ++i) {
        const double d = response.displacements(static_cast<Eigen::Index>(g), i);
        states[g] -= d * mean_states_[at(i)];
        own_force_[g] -= d * mean_force_[at(i)];
      }
    }
    own_states_ = stacked(states, examined_.first);
  }

  Eigen::Index axes_;
  Examined examined_;
  std::vector<Eigen::MatrixXd> mean_states_;
  std::vector<Eigen::MatrixXd> mean_force_;
  Eigen::MatrixXd Q_;
  Eigen::MatrixXd R_;
  Eigen::MatrixXd own_states_;              // of all trials, one below the other
  std::vector<Eigen::MatrixXd> own_force_;  // of each trial, all rows
  Eigen::MatrixXd own_square_;
  double own_share_ = 0.0;  // trace(W W') over degrees of freedom
};

/// `fits`: of one channel, at shifts of -reach to +reach rows.
ForceLag lag_from(const std::vector<Fit>& fits, Eigen::Index reach, double sample_period) {
  const Fit& unshifted = fits[static_cast<std::size_t>(reach)];
  const Fit* best = nullptr;
  for (const Fit& fit : fits) {
    if (fit.is_possible && (best == nullptr || fit.misfit < best->misfit)) best = &fit;
  }
  if (best == nullptr) return {0.0, false, unshifted.misfit, unshifted.share};
  const double time = static_cast<double>(best - &unshifted) * sample_period;
  const double ratio = unshifted.is_possible ? kLagMisfitRatio : 1.0;
  return {time, std::abs(time) > kLagTolerated && unshifted.misfit > ratio * best->misfit, unshifted.misfit,
          unshifted.share};
}

}  // namespace

std::vector<ForceLag> force_lags(const ConditionResponse& response, double frequency) {
  const auto axes = static_cast<std::size_t>(response.axes());
  const auto examined = examined_rows(response, frequency);
  if (!examined || response.force.size() < axes + 2) return std::vector<ForceLag>(axes);
  const ShiftedFit fit(response, *examined);
  std::vector<std::vector<Fit>> fits(axes);
  for (Eigen::Index shift = -examined->reach; shift <= examined->reach; ++shift) {
    const auto of_channels = fit.at_shift(shift);
    for (std::size_t i = 0; i < axes; ++i) fits[i].push_back(of_channels[i]);
  }
  std::vector<ForceLag> lags;
  lags.reserve(fits.size());
  for (const auto& channel : fits) lags.push_back(lag_from(channel, examined->reach, response.sample_period));
  return lags;
}

}  // namespace tonus::impedance
