#include "rig_agent/calibration/fit.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <Eigen/QR>
#include <Eigen/SVD>
#include <cmath>
#include <spdlog/fmt/fmt.h>

namespace tonus::calibration {
namespace {

constexpr std::size_t kFewest = 4;
constexpr double kSpan = 0.1;  // Smaller over larger singular value.

Result<void> check_number(const char* what, std::size_t count) {
  if (count >= kFewest) return {};
  return fail(ErrorCode::kInvalidArgument,
              fmt::format("{}: {} is not allowed; expected {} or more", what, count, kFewest));
}

Result<void> check_span(const char* what, const Eigen::MatrixX2d& rows) {
  const Eigen::Vector2d values = Eigen::JacobiSVD<Eigen::MatrixX2d>(rows).singularValues();
  const double span = values[0] > 0.0 ? values[1] / values[0] : 0.0;
  if (span >= kSpan) return {};
  return fail(ErrorCode::kInvalidArgument,
              fmt::format("{} span the plane by {:.3g}; expected {} or more: use other directions", what,
                          span, kSpan));
}

double root_mean(double sum_of_squares, Eigen::Index rows, Eigen::Index unknowns) {
  return std::sqrt(sum_of_squares / static_cast<double>(2 * rows - unknowns));
}

}  // namespace

Result<ForceFit> fit_force(std::span<const KnownForce> readings) {
  if (auto enough = check_number("readings of known forces", readings.size()); !enough) return enough.error();
  const auto n = static_cast<Eigen::Index>(readings.size());
  Eigen::MatrixX3d regressors(n, 3);
  Eigen::MatrixX2d forces(n, 2);
  for (Eigen::Index i = 0; i < n; ++i) {
    const KnownForce& reading = readings[static_cast<std::size_t>(i)];
    regressors.row(i) << reading.volts.transpose(), 1.0;
    forces.row(i) = reading.force.transpose();
  }
  const Eigen::MatrixX2d volts =
      regressors.leftCols<2>().rowwise() - regressors.leftCols<2>().colwise().mean();
  if (auto spans = check_span("the volts of the readings", volts); !spans) return spans.error();

  const Eigen::Matrix<double, 3, 2> solution = regressors.colPivHouseholderQr().solve(forces);
  ForceFit fit;
  fit.matrix = solution.topRows<2>().transpose();
  if (!(std::abs(fit.matrix.determinant()) > 1e-12))
    return fail(ErrorCode::kInvalidArgument, "the readings give a singular matrix: are the loads right?");
  fit.offset = -fit.matrix.inverse() * solution.row(2).transpose();
  fit.residual = root_mean((forces - regressors * solution).squaredNorm(), n, 6);
  return fit;
}

double SpringFit::along(double direction) const {
  const Eigen::Vector2d u(std::cos(direction), std::sin(direction));
  return u.dot(stiffness * u);
}

Result<SpringFit> fit_spring(std::span<const SpringStep> steps) {
  if (auto enough = check_number("steps against the spring", steps.size()); !enough) return enough.error();
  const auto n = static_cast<Eigen::Index>(steps.size());
  Eigen::MatrixX2d displacements(n, 2);
  Eigen::MatrixX2d forces(n, 2);
  for (Eigen::Index i = 0; i < n; ++i) {
    displacements.row(i) = steps[static_cast<std::size_t>(i)].displacement.transpose();
    forces.row(i) = steps[static_cast<std::size_t>(i)].force.transpose();
  }
  if (auto spans = check_span("the displacements", displacements); !spans) return spans.error();
  const Eigen::Matrix2d solution = displacements.colPivHouseholderQr().solve(forces);
  SpringFit fit;
  fit.stiffness = solution.transpose();
  const Eigen::MatrixX2d left = forces - displacements * solution;
  fit.residual = root_mean(left.squaredNorm(), n, 4);
  const Eigen::Vector2d shape = (displacements.transpose() * displacements).inverse().diagonal();
  for (Eigen::Index axis = 0; axis < 2; ++axis) {
    const double variance = left.col(axis).squaredNorm() / static_cast<double>(n - 2);
    fit.standard_error.row(axis) = (variance * shape).cwiseSqrt().transpose();
  }
  return fit;
}

}  // namespace tonus::calibration
