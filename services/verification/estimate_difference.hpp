#pragma once

#include <string>

#include <idl/estimate.h>

namespace tonus::verification {

/// How two estimates of one condition by one method differ.
struct EstimateDifference {
  bool is_equal = true;  ///< Every number is the same, bit for bit.
  double largest = 0.0;  ///< Largest difference of an element, as a share of the largest of its matrix.
  std::string where;     ///< Of it: "K(1,2)"; "trials_used", ... where a count or the status differs.
};

/// Compares matrices with their errors and intervals, the spring centre, the fit's figures, the settings that
/// were used, the counts of trials and samples, and the status.
[[nodiscard]] EstimateDifference difference_of(const v1::Estimate& a, const v1::Estimate& b);

}  // namespace tonus::verification
