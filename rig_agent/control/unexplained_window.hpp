#pragma once

#include <Eigen/Core>
#include <cmath>

namespace tonus::control {

/// Sums for the least squares |u - S x|^2 over the last third of a second: u is Servo::unexplained_torque(),
/// S the torques that may explain it (N m at the two joints, columns), both without their slow means.
///
/// All methods are REALTIME.
template <int kColumns>
class UnexplainedWindow {
 public:
  using Columns = Eigen::Matrix<double, 2, kColumns>;
  using Products = Eigen::Matrix<double, kColumns, kColumns>;
  using Responses = Eigen::Matrix<double, kColumns, 1>;

  /// `period` in s.
  explicit UnexplainedWindow(double period) noexcept
      : mean_share_(1.0 - std::exp(-period / kMeanTime)), window_share_(1.0 - std::exp(-period / kWindow)) {}

  void start(const Eigen::Vector2d& unexplained, const Columns& causes) noexcept {
    mean_causes_ = causes;
    mean_unexplained_ = unexplained;
    products_.setZero();
    responses_.setZero();
    power_ = 0.0;
  }

  /// One cycle.
  void take(const Eigen::Vector2d& unexplained, const Columns& causes) noexcept {
    mean_causes_ += mean_share_ * (causes - mean_causes_);
    mean_unexplained_ += mean_share_ * (unexplained - mean_unexplained_);
    const Columns s = causes - mean_causes_;
    const Eigen::Vector2d u = unexplained - mean_unexplained_;
    products_ += window_share_ * (s.transpose() * s - products_);
    responses_ += window_share_ * (s.transpose() * u - responses_);
    power_ += window_share_ * (u.squaredNorm() - power_);
  }

  [[nodiscard]] const Products& products() const noexcept { return products_; }     ///< S'S, (N m)^2.
  [[nodiscard]] const Responses& responses() const noexcept { return responses_; }  ///< S'u, (N m)^2.
  [[nodiscard]] double power() const noexcept { return power_; }                    ///< u'u, (N m)^2.

 private:
  static constexpr double kMeanTime = 0.5;  // s
  static constexpr double kWindow = 0.3;    // s

  const double mean_share_;  // Shares of the new value in one cycle.
  const double window_share_;
  Columns mean_causes_ = Columns::Zero();
  Eigen::Vector2d mean_unexplained_ = Eigen::Vector2d::Zero();
  Products products_ = Products::Zero();
  Responses responses_ = Responses::Zero();
  double power_ = 0.0;
};

}  // namespace tonus::control
