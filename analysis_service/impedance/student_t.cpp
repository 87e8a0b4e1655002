#include "analysis_service/impedance/student_t.hpp"

#include <cmath>

namespace tonus::impedance {
namespace {

/// Regularised incomplete beta function I_x(a, b) by its continued fraction (DLMF 8.17.22), evaluated from
/// the front by Lentz's method; it converges fast for x < (a + 1)/(a + b + 2).
double incomplete_beta(double a, double b, double x) {
  if (x <= 0.0) return 0.0;
  if (x >= 1.0) return 1.0;
  if (x > (a + 1.0) / (a + b + 2.0)) return 1.0 - incomplete_beta(b, a, 1.0 - x);
  constexpr double kTiny = 1e-300;
  const double front =
      std::exp(std::lgamma(a + b) - std::lgamma(a) - std::lgamma(b) + a * std::log(x) + b * std::log1p(-x)) /
      a;
  double fraction = 1.0;  // 1 + 1/(1 + d1/(1 + d2/(1 + ...))): one more than what is asked for.
  double c = 1.0;
  double d = 0.0;
  for (int n = 0; n < 1000; ++n) {
    const int m = n / 2;
    double term = 1.0;
    if (n > 0) {
      term = n % 2 == 0 ? m * (b - m) * x / ((a + 2.0 * m - 1.0) * (a + 2.0 * m))
                        : -(a + m) * (a + b + m) * x / ((a + 2.0 * m) * (a + 2.0 * m + 1.0));
    }
    d = 1.0 + term * d;
    d = 1.0 / (std::abs(d) < kTiny ? kTiny : d);
    c = 1.0 + term / c;
    if (std::abs(c) < kTiny) c = kTiny;
    fraction *= c * d;
    if (std::abs(c * d - 1.0) < 1e-16) break;
  }
  return front * (fraction - 1.0);
}

}  // namespace

double student_t_within(double x, double freedom) {
  return 1.0 - incomplete_beta(0.5 * freedom, 0.5, freedom / (freedom + x * x));
}

double student_t_factor(double share, double freedom) {
  double high = 1.0;
  while (student_t_within(high, freedom) < share && high < 1e12) high *= 2.0;
  double low = 0.0;
  for (int i = 0; i < 200 && high - low > 1e-15 * high; ++i) {
    const double middle = 0.5 * (low + high);
    (student_t_within(middle, freedom) < share ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

}  // namespace tonus::impedance
