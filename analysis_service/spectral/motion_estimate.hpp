#pragma once

#include <Eigen/Core>

#include "analysis_service/spectral/segment_fit.hpp"

namespace tonus::spectral {

/// Motion of a record: a row a sample, a column an axis, SI.
struct MotionEstimate {
  Eigen::MatrixXd position;
  Eigen::MatrixXd velocity;
};

/// x^ = x + nx Z^H N^-1 R (equation 13), the best estimate from both signals, and its rate, both `delay` s
/// later: x^(t - delay). It is independent of R where the model holds. `record` is filled() and one that the
/// fit was made from. Within the fitted band; with `is_slow_kept` what is slower stands as it was measured,
/// because a function of the whole displacement is not that of its fast part.
template <int N>
[[nodiscard]] MotionEstimate motion_estimate(const Record& record, const SegmentFit<N>& fit,
                                             double delay = 0.0, bool is_slow_kept = false);

}  // namespace tonus::spectral
