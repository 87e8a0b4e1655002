#include "analysis_service/impedance/static_stiffness.hpp"

#include <Eigen/Dense>
#include <cmath>
#include <spdlog/fmt/fmt.h>

#include "analysis_service/impedance/butterworth.hpp"

namespace tonus::impedance {
namespace {

/// Least inverse condition of the static points' regressor [X 1], columns at unit length.
constexpr double kStaticMargin = 1e-3;

struct Line {
  Eigen::MatrixXd theta;  ///< (axes + 1) x axes: K' and c' of F = K X + c.
  Eigen::MatrixXd residual;
};

std::optional<Line> fit(const std::vector<StaticPoint>& points, std::size_t left_out) {
  const Eigen::Index axes = points.front().X.size();
  const auto rows = static_cast<Eigen::Index>(points.size() - (left_out < points.size() ? 1 : 0));
  Eigen::MatrixXd phi(rows, axes + 1);
  Eigen::MatrixXd force(rows, axes);
  Eigen::Index row = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (i == left_out) continue;
    phi.row(row) << points[i].X.transpose(), 1.0;
    force.row(row) = points[i].F.transpose();
    ++row;
  }
  if (rows < axes + 1) return std::nullopt;
  const Eigen::VectorXd lengths = phi.colwise().norm();
  if (!(lengths.minCoeff() > 0.0)) return std::nullopt;
  const Eigen::MatrixXd scaled = phi * lengths.cwiseInverse().asDiagonal();
  const Eigen::VectorXd values = scaled.jacobiSvd().singularValues();
  if (!(values[axes] > kStaticMargin * values[0])) return std::nullopt;
  Line line;
  line.theta = phi.colPivHouseholderQr().solve(force);
  line.residual = force - phi * line.theta;
  return line;
}

/// K and X0, one below the other in one column.
Eigen::VectorXd elements(const Line& line) {
  const Eigen::Index axes = line.theta.cols();
  const Eigen::MatrixXd K = line.theta.topRows(axes).transpose();
  Eigen::VectorXd all(axes * axes + axes);
  all << K.reshaped(), -K.partialPivLu().solve(line.theta.bottomRows(1).transpose());
  return all;
}

}  // namespace

std::optional<StaticPoint> static_point(const Trial& trial, const StaticOptions& options) {
  if (trial.is_continuous || trial.samples() <= kZeroPhasePadding) return std::nullopt;
  const SecondOrderFilter filter = butterworth_lowpass(options.cutoff, trial.sample_period);
  const Eigen::VectorXd speed =
      central_difference(zero_phase(filter, trial.displacement), trial.sample_period).rowwise().norm();
  const auto least = static_cast<Eigen::Index>(std::ceil(options.duration / trial.sample_period - 1e-9));
  Eigen::Index rows = 0;
  for (Eigen::Index k = trial.samples() - 1; k >= trial.onset - 1; --k) {
    if (k >= trial.onset && speed[k] < options.speed) {
      ++rows;
      continue;
    }
    if (rows >= least) {
      return StaticPoint{trial.number, k + 1, rows, mean_of_rows(trial.displacement, k + 1, rows),
                         mean_of_rows(trial.force, k + 1, rows)};
    }
    rows = 0;
  }
  return std::nullopt;
}

Result<StaticStiffness> static_stiffness(std::span<const Trial> trials, const StaticOptions& options) {
  if (!(options.duration > 0.0) || !(options.speed > 0.0) || !(options.cutoff > 0.0)) {
    return fail(ErrorCode::kInvalidArgument, fmt::format("static stiffness: duration {} s, speed {} m/s, "
                                                         "cutoff {} Hz are not allowed; expected more than 0",
                                                         options.duration, options.speed, options.cutoff));
  }
  if (trials.empty())
    return fail(ErrorCode::kInvalidArgument,
                "static stiffness: 0 trials are not allowed; expected 1 or more");
  StaticStiffness result;
  for (const Trial& trial : trials) {
    if (trial.axes() != trials.front().axes() || options.cutoff * trial.sample_period >= 0.5) {
      return fail(
          ErrorCode::kInvalidArgument,
          fmt::format("static stiffness: trial {}: {} axes at {} s are not allowed; expected {} axes and a "
                      "cutoff below half the "
                      "sampling rate",
                      trial.number, trial.axes(), trial.sample_period, trials.front().axes()));
    }
    if (auto point = static_point(trial, options)) {
      result.points.push_back(std::move(*point));
    } else {
      result.moving.push_back(trial.number);
    }
  }
  const auto too_few = [&] {
    return fail(ErrorCode::kNotFound,
                fmt::format("static stiffness: {} of {} trials stand still, which does not determine it",
                            result.points.size(), trials.size()));
  };
  const std::size_t count = result.points.size();
  if (count == 0) return too_few();
  const auto all = fit(result.points, count);
  if (!all) return too_few();
  const Eigen::VectorXd values = elements(*all);
  Eigen::VectorXd variance = Eigen::VectorXd::Zero(values.size());
  for (std::size_t i = 0; i < count; ++i) {
    const auto others = fit(result.points, i);
    if (!others) return too_few();
    variance += (elements(*others) - values).cwiseAbs2();
  }
  const Eigen::VectorXd deviation =
      (variance * (static_cast<double>(count - 1) / static_cast<double>(count))).cwiseSqrt();
  const Eigen::Index axes = trials.front().axes();
  result.K = values.head(axes * axes).reshaped(axes, axes);
  result.X0 = values.tail(axes);
  result.K_std = deviation.head(axes * axes).reshaped(axes, axes);
  result.X0_std = deviation.tail(axes);
  result.sigma = (all->residual.colwise().squaredNorm() / static_cast<double>(count)).cwiseSqrt().transpose();
  return result;
}

Result<Eigen::Vector2d> predicted_spring_centre(const Eigen::Matrix2d& K_unloaded,
                                                const Eigen::Vector2d& F_bias) {
  const double determinant = K_unloaded.determinant();
  if (!std::isfinite(determinant) || determinant == 0.0) {
    return fail(
        ErrorCode::kInvalidArgument,
        fmt::format(
            "spring centre: determinant of the stiffness: {} is not allowed; expected one that is not 0",
            determinant));
  }
  return Eigen::Vector2d(-(K_unloaded.inverse() * F_bias));
}

SpringCentreComparison compare(const Eigen::Vector2d& actual, const Eigen::Vector2d& predicted) {
  const double cross = predicted.x() * actual.y() - predicted.y() * actual.x();
  return {actual.norm() / predicted.norm(), std::atan2(cross, predicted.dot(actual))};
}

}  // namespace tonus::impedance
