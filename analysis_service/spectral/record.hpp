#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

namespace tonus::spectral {

/// A continuous record: equally spaced samples of motion and force, one row a sample and one column an axis.
struct Record {
  double sample_period = 0.0;    ///< s.
  Eigen::MatrixXd displacement;  ///< m.
  Eigen::MatrixXd force;         ///< N.
  std::vector<bool> is_missing;  ///< By row; empty: none is. What stands in such a row is not looked at.

  [[nodiscard]] int axes() const { return static_cast<int>(displacement.cols()); }
  [[nodiscard]] Eigen::Index samples() const { return displacement.rows(); }
  [[nodiscard]] bool is_row_missing(Eigen::Index row) const {
    return !is_missing.empty() && is_missing[static_cast<std::size_t>(row)];
  }
};

/// The record with its means taken away and missing rows filled by straight lines, so that it can be
/// transformed as a whole. Which rows are missing stays marked.
[[nodiscard]] Record filled(const Record& record);

/// The record with the force of each axis taken `lead[axis]` seconds later: f(t + lead), exact for signals
/// without content above half the sample rate (equation 9).
[[nodiscard]] Record with_force_advanced(const Record& record, const Eigen::VectorXd& lead);

/// Smallest even length of at least `least` without a prime factor above 5: transforms of other lengths
/// take up to quadratic time.
[[nodiscard]] Eigen::Index fast_length(Eigen::Index least);

}  // namespace tonus::spectral
