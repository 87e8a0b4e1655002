#include "analysis_service/impedance/cross_check.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <spdlog/fmt/fmt.h>
#include <tuple>

#include "analysis_service/impedance/identification.hpp"
#include "analysis_service/impedance/uncertainty.hpp"
#include "analysis_service/refined/identification.hpp"
#include "analysis_service/statistics/distributions.hpp"

namespace tonus::impedance {

std::optional<CrossCheck> cross_check(const refined::Estimate& refined, const Estimate& state_variable) {
  if (refined.shortage != refined::Shortage::kNone || state_variable.status == Status::kUndetermined)
    return std::nullopt;
  using Entry = std::tuple<const char*, AxisMatrix Parameters::*, Eigen::Index>;
  const Eigen::Index axes = refined.theta.cols();
  const Eigen::Index q = refined.theta.rows();
  const std::array<Entry, 3> matrices{Entry{"M", &Parameters::M, 0}, Entry{"B", &Parameters::B, axes},
                                      Entry{"K", &Parameters::K, 2 * axes}};
  CrossCheck check;
  for (const auto& [name, matrix, first] : matrices) {
    const AxisMatrix& bias = uncertainty_of(state_variable, matrix).known_bias;
    const double same = kSameNumber * (state_variable.value.*matrix).cwiseAbs().maxCoeff();
    for (Eigen::Index i = 0; i < axes; ++i) {
      for (Eigen::Index j = 0; j < axes; ++j) {
        const auto spread = refined.covariance->spread_of(Eigen::VectorXd::Unit(q * axes, i * q + first + j));
        const double own = statistics::student_t_factor(0.95, spread.freedom) * spread.std;
        const double other = 0.5 * ((state_variable.high.*matrix)(i, j) - (state_variable.low.*matrix)(i, j));
        const double a = refined.theta(first + j, i);
        const double given = (state_variable.value.*matrix)(i, j);
        const double less_bias = bias.size() == 0 ? given : given - bias(i, j);
        const double b = std::clamp(a, std::min(given, less_bias), std::max(given, less_bias));
        const double value = std::abs(a - b) / std::hypot(own, other, same);
        if (!(value > check.value)) continue;
        check.value = value;
        check.detail = fmt::format(
            "methods refined and state_variable differ by {:.2f} joint 95 % half-widths in {}({},{}), {:.4g} "
            "and {:.4g}, at most {:.2f}; correlation of neighbouring residuals {:.2f}, condition number "
            "{:.0f}",
            value, name, i + 1, j + 1, a, b, kLargestDifference, refined.white, refined.condition);
      }
    }
  }
  return check;
}

}  // namespace tonus::impedance
