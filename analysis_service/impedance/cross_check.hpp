#pragma once

#include <cstddef>
#include <optional>
#include <string>

namespace tonus::refined {
struct Estimate;
}

namespace tonus::impedance {

struct Estimate;

/// Trials from which on methods are held against each other: with fewer the intervals say little.
inline constexpr std::size_t kFewestCrossChecked = 8;

/// Joint 95 % half-widths by which the methods may differ. Both see the same noise, so that sound data differ
/// by less than independent estimates would; the limit counts the twelve elements (figures:
/// tests/RESULTS.md).
inline constexpr double kLargestDifference = 1.25;

/// Share of a matrix's largest element by which the methods' own discretisations may differ, whatever the
/// noise: without it two numbers that agree to four digits would be called different where the data have no
/// noise.
inline constexpr double kSameNumber = 0.002;

/// How far two methods are from each other in the same trials.
struct CrossCheck {
  double value = 0.0;  ///< Largest difference of an element, in joint 95 % half-widths.
  std::string detail;  ///< The element with its two numbers; residual correlation; condition number.

  [[nodiscard]] bool is_passed() const { return value <= kLargestDifference; }
};

/// Holds M, B, K of method refined against those of state_variable: each element's difference over the root
/// of the sum of the squared half-widths and of kSameNumber. Where state_variable has a known bias, its
/// intervals hold the number as given and less the bias, and the nearest in between is compared: what
/// simulates the bias may err, too. `state_variable`'s intervals are those without the bias. None where
/// either has no numbers.
[[nodiscard]] std::optional<CrossCheck> cross_check(const refined::Estimate& refined,
                                                    const Estimate& state_variable);

}  // namespace tonus::impedance
