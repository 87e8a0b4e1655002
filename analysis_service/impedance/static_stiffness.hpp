#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "analysis_service/impedance/axes.hpp"
#include "analysis_service/impedance/trial.hpp"
#include "services/core/result.hpp"

namespace tonus::impedance {

/// When a trajectory counts as standing still (method, section 8). The defaults are the published settings.
struct StaticOptions {
  double duration = 0.2;  ///< s, at least.
  double speed = 0.005;   ///< m/s, less than.
  double cutoff = 10.0;   ///< Hz, low-pass before the speed is taken: an encoder step is no motion.
};

/// Mean displacement (m) and force (N) over the last stretch of a trial that stands still.
struct StaticPoint {
  std::uint32_t trial = 0;
  Eigen::Index first = 0;  ///< First row of the stretch.
  Eigen::Index rows = 0;
  AxisVector X;
  AxisVector F;
};

/// Scans from the end backward to the first stretch of at least `duration` below `speed`, all of it; none
/// where there is none after the onset, or the trial is continuous.
[[nodiscard]] std::optional<StaticPoint> static_point(const Trial& trial, const StaticOptions& options);

/// F = K (X - X0) (19), least squares over the trials' static points.
struct StaticStiffness {
  AxisMatrix K;      ///< N/m.
  AxisVector X0;     ///< m: the actual spring centre of a loaded condition.
  AxisMatrix K_std;  ///< Leave-one-trial-out jackknife, as in identify().
  AxisVector X0_std;
  AxisVector sigma;  ///< N, (16) of the static points.
  std::vector<StaticPoint> points;
  std::vector<std::uint32_t> moving;  ///< Trials that never stood still.
};

/// Loaded trials keep their bias force (Preparation::is_force_tared false).
/// Errors (kInvalidArgument): options not positive, no trials, different axes; kNotFound: too few trials
/// stand still, or they do not span the plane.
[[nodiscard]] Result<StaticStiffness> static_stiffness(std::span<const Trial> trials,
                                                       const StaticOptions& options);

/// Predicted spring centre of a loaded condition. F_bias is the force of the handle on the arm, held at X =
/// 0, so that (19) reads F_bias = -K X0:
///
///     X0 = -K_unloaded^-1 F_bias.
///
/// (20) is printed without the sign, which holds for the force of the arm on the handle.
/// Error kInvalidArgument: K_unloaded is singular.
[[nodiscard]] Result<Eigen::Vector2d> predicted_spring_centre(const Eigen::Matrix2d& K_unloaded,
                                                              const Eigen::Vector2d& F_bias);

/// Fig. 10: actual against predicted.
struct SpringCentreComparison {
  double magnitude_ratio = 0.0;  ///< |actual| / |predicted|.
  double turn = 0.0;             ///< rad from predicted to actual, in (-pi, pi].
};
[[nodiscard]] SpringCentreComparison compare(const Eigen::Vector2d& actual, const Eigen::Vector2d& predicted);

}  // namespace tonus::impedance
