#pragma once

#include <Eigen/Core>

namespace tonus::impedance {

/// What is known of the elements of a matrix, row by row.
struct Belief {
  Eigen::VectorXd value;
  Eigen::MatrixXd covariance;
  double freedom = 1.0;  ///< Degrees of freedom behind the covariance.
};

/// An estimate combined with what was known before.
struct Combined {
  Belief belief;
  Eigen::VectorXd std;
  Eigen::VectorXd half;  ///< Half-widths of 95 % intervals.
  double apart = 0.0;    ///< Largest difference of the two, in joint 95 % half-widths: above 1 they disagree.
};

/// Bayesian update, normal on both sides, element by element: each takes the mean of the two, weighted by
/// their inverse variances. The covariances of a few trials have too low a rank to be inverted, so that what
/// the elements' errors have in common does not guide the weights; it is carried into the result's
/// covariance. Student's t with the degrees of freedom of Welch and Satterthwaite. Both have the same size
/// and positive variances.
[[nodiscard]] Combined combine(const Belief& estimate, const Belief& prior);

/// Belief from several estimates of different people or days (at least two): their mean, and the scatter by
/// which the next one may differ from it.
[[nodiscard]] Belief belief_of_many(const Eigen::MatrixXd& values_by_column);

}  // namespace tonus::impedance
