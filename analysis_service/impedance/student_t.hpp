#pragma once

namespace tonus::impedance {

/// P(|t| <= x) of Student's t with `freedom` > 0 degrees of freedom, x >= 0.
[[nodiscard]] double student_t_within(double x, double freedom);

/// x with P(|t| <= x) = share, share in (0, 1): 0.95 gives the factor of a 95 % interval.
[[nodiscard]] double student_t_factor(double share, double freedom);

}  // namespace tonus::impedance
