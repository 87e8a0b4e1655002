#include "analysis_service/spectral/activity.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

namespace tonus::spectral {
namespace {

constexpr double kActiveShare = 0.05;
constexpr Eigen::Index kPieces = 120;

}  // namespace

std::vector<std::size_t> pieces_with_input(const Eigen::MatrixXd& power) {
  const auto count = static_cast<std::size_t>(power.rows());
  Eigen::VectorXd of_axes = Eigen::VectorXd::Zero(power.rows());
  for (Eigen::Index axis = 0; axis < power.cols(); ++axis) {
    const double total = power.col(axis).sum();
    if (total > 0.0) of_axes += power.col(axis) / total;
  }
  std::vector<double> sorted(of_axes.begin(), of_axes.end());
  std::ranges::sort(sorted, std::greater<>());
  const std::size_t strongest = std::min(count, std::max<std::size_t>(3, count / 20));
  double mean = 0.0;
  for (std::size_t i = 0; i < strongest; ++i) mean += sorted[i] / static_cast<double>(strongest);
  std::vector<std::size_t> active;
  for (std::size_t i = 0; i < count; ++i) {
    if (of_axes[static_cast<Eigen::Index>(i)] > kActiveShare * mean) active.push_back(i);
  }
  return active;
}

Eigen::Index rows_with_input(std::span<const Record> records) {
  Eigen::Index rows = 0;
  for (const Record& record : records) rows += record.samples();
  const Eigen::Index piece = std::max<Eigen::Index>(2, rows / kPieces);
  Eigen::Index count = 0;
  for (const Record& record : records) count += record.samples() / piece;
  if (count == 0) return rows;
  Eigen::MatrixXd power(count, records.front().axes());
  Eigen::Index at = 0;
  for (const Record& record : records) {
    for (Eigen::Index first = 0; first + piece <= record.samples(); first += piece, ++at) {
      const auto x = record.displacement.middleRows(first, piece);
      power.row(at) = (x.rowwise() - x.colwise().mean()).colwise().squaredNorm();
    }
  }
  const auto active = static_cast<double>(pieces_with_input(power).size());
  return static_cast<Eigen::Index>(
      std::llround(static_cast<double>(rows) * active / static_cast<double>(count)));
}

}  // namespace tonus::spectral
