#pragma once

/// Quantiles and tails of the distributions that intervals and tests use, by Boost.Math. Degrees of freedom
/// are positive and need not be whole.
namespace tonus::statistics {

/// x with P(t <= x) = probability, of Student's t.
[[nodiscard]] double student_t_quantile(double probability, double freedom);
/// x with P(|t| <= x) = share: 0.95 gives the factor of a 95 % interval.
[[nodiscard]] double student_t_factor(double share, double freedom);
/// x with P(F <= x) = probability, of the F distribution.
[[nodiscard]] double fisher_quantile(double probability, double freedom, double freedom_below);
/// P(F > ratio).
[[nodiscard]] double fisher_tail(double ratio, double freedom, double freedom_below);
/// P(chi squared > squares).
[[nodiscard]] double chi_squared_tail(double squares, double freedom);

}  // namespace tonus::statistics
