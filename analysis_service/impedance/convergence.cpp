#include "analysis_service/impedance/convergence.hpp"

#include "analysis_service/impedance/parameters.hpp"

namespace tonus::impedance {
namespace {

bool is_within(const AxisMatrix& matrix, const AxisMatrix& final, double share) {
  return matrix.size() == 0 || largest_element(matrix - final) <= share * largest_element(final);
}

}  // namespace

std::optional<double> settling_time(const std::vector<ConvergencePoint>& trace, const Parameters& final,
                                    double share) {
  std::optional<double> settled;
  for (auto point = trace.rbegin(); point != trace.rend(); ++point) {
    const Parameters& p = point->value;
    if (!is_within(p.M, final.M, share) || !is_within(p.B, final.B, share) || !is_within(p.K, final.K, share))
      break;
    settled = point->end_time;
  }
  if (settled && settled == trace.back().end_time) return std::nullopt;
  return settled;
}

}  // namespace tonus::impedance
