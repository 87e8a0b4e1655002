#include "services/protocol/estimate_look.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace tonus::protocol {
namespace {

/// Largest half-width over the largest element; not a number where there is no interval.
double width_of(const v1::MatrixEstimate& matrix, std::uint32_t axes) {
  double widest = 0.0;
  double largest = 0.0;
  for (std::size_t i = 0; i < (axes == 1 ? 1U : 4U); ++i) {
    const double half = 0.5 * (matrix.high95()[i] - matrix.low95()[i]);
    if (!std::isfinite(half)) return std::numeric_limits<double>::quiet_NaN();
    widest = std::max(widest, half);
    largest = std::max(largest, std::abs(matrix.value()[i]));
  }
  return largest > 0.0 ? widest / largest : std::numeric_limits<double>::quiet_NaN();
}

bool is_of_linearity(v1::FitTest test) {
  return test == v1::FIT_BANDS || test == v1::FIT_REFLEX || test == v1::FIT_FRICTION ||
         test == v1::FIT_HARDENING || test == v1::FIT_POSITION;
}

}  // namespace

Look look_at(const v1::Estimate& estimate) {
  Look look;
  look.trials = estimate.trials_used();
  const bool has_numbers = estimate.status() != v1::ESTIMATE_UNDETERMINED;
  const auto width = [&](const v1::MatrixEstimate& matrix) {
    return has_numbers ? width_of(matrix, estimate.axes()) : std::numeric_limits<double>::quiet_NaN();
  };
  look.stiffness = width(estimate.stiffness_N_per_m());
  look.mass = width(estimate.mass_kg());
  look.damping = width(estimate.damping_Ns_per_m());
  look.is_ok = estimate.status() == v1::ESTIMATE_OK;
  look.is_linear = has_numbers && std::none_of(estimate.checks().begin(), estimate.checks().end(),
                                               [](const v1::FitCheck& check) {
                                                 return !check.passed() && is_of_linearity(check.test());
                                               });
  return look;
}

}  // namespace tonus::protocol
