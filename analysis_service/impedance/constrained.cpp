#include "analysis_service/impedance/constrained.hpp"

#include <Eigen/Dense>
#include <spdlog/fmt/fmt.h>

#include "analysis_service/impedance/parameters.hpp"

namespace tonus::impedance {

Result<ConstrainedDamping> constrain(const Estimate& estimate, const AxisMatrix& M, const AxisMatrix& K) {
  const Eigen::Index axes = estimate.axes;
  if (estimate.status == Status::kUndetermined || estimate.model != Model::kLinear) {
    return fail(ErrorCode::kInvalidArgument, fmt::format("constrained fit: estimate: {} of model {} is not "
                                                         "allowed; expected a determined one of model linear",
                                                         name_of(estimate.status), name_of(estimate.model)));
  }
  if (M.rows() != axes || M.cols() != axes || K.rows() != axes || K.cols() != axes) {
    return fail(
        ErrorCode::kInvalidArgument,
        fmt::format(
            "constrained fit: M of {} x {} and K of {} x {} elements are not allowed; expected {} x {}",
            M.rows(), M.cols(), K.rows(), K.cols(), axes, axes));
  }
  // ||R Theta - Z||^2 with the rows of M and K in Theta held: their part moves to the other side.
  const Information& data = estimate.information;
  const Eigen::MatrixXd remaining =
      data.Z - data.R.leftCols(axes) * M.transpose() - data.R.middleCols(2 * axes, axes) * K.transpose();
  Eigen::MatrixXd free(data.R.rows(), axes + 1);
  free << data.R.middleCols(axes, axes), data.R.rightCols(1);
  const Eigen::MatrixXd theta = free.colPivHouseholderQr().solve(remaining);

  ConstrainedDamping result;
  result.B = theta.topRows(axes).transpose();
  const Eigen::MatrixXd stiffness = K;
  result.X0 = -stiffness.partialPivLu().solve(theta.bottomRows(1).transpose());
  const Eigen::VectorXd residual =
      data.residual + (remaining - free * theta).colwise().squaredNorm().transpose();
  result.sigma = (residual / static_cast<double>(data.samples)).cwiseSqrt();
  result.change = largest_element(result.B - estimate.value.B) / largest_element(estimate.value.B);
  return result;
}

}  // namespace tonus::impedance
