#pragma once

#include <Eigen/Core>

namespace tonus::impedance {

/// Most measured axes: 2 (the horizontal plane). A one-axis rig has 1.
inline constexpr int kMaxAxes = 2;

/// One value per axis, sized at run time, never on the heap.
using AxisVector = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, kMaxAxes, 1>;

/// Impedance matrix, axes x axes; the velocity term of model (14) has 3 columns. Never on the heap.
using AxisMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, kMaxAxes, 3>;

/// Sampled signals, one row a sample and one column an axis.
using Signals = Eigen::MatrixXd;

}  // namespace tonus::impedance
