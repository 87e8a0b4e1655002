#pragma once

namespace tonus::spectral {

/// x with P(t <= x) = probability, of Student's t.
[[nodiscard]] double student_t_quantile(double probability, double freedom);
/// x with P(F <= x) = probability, of the F distribution.
[[nodiscard]] double fisher_quantile(double probability, double freedom, double freedom_below);

}  // namespace tonus::spectral
