#include "analysis_service/impedance/optimal_fourier.hpp"

#include <cmath>
#include <complex>
#include <limits>
#include <numbers>
#include <vector>

#include "analysis_service/impedance/any_length_transform.hpp"

namespace tonus::impedance {
namespace {

using Complex = std::complex<double>;

/// A transform keeps its tables for the next signal of the same length: force and displacement of a trial,
/// and all trials that are simulated of a condition.
using Transform = AnyLengthTransform;

Transform& transform_of_this_thread() {
  thread_local Transform transform;
  return transform;
}

/// sum_k c_k sin(pi k n / M) (parity -1) or with cos (parity +1), n = 0 .. M, k = 1 .. M-1, from the odd or
/// even continuation of c. The transform is linear: a complex c carries two real series, one axis in each
/// part.
Eigen::VectorXcd series_sums(const Eigen::VectorXcd& c, double parity, Transform& transform) {
  const Eigen::Index M = c.size() + 1;
  std::vector<Complex> spectrum(static_cast<std::size_t>(2 * M));
  for (Eigen::Index k = 1; k < M; ++k) {
    spectrum[static_cast<std::size_t>(k)] = c[k - 1];
    spectrum[static_cast<std::size_t>(2 * M - k)] = parity * c[k - 1];
  }
  std::vector<Complex> sums;
  transform.inv(sums, spectrum);
  const Complex scale = parity < 0.0 ? Complex(0.0, -0.5) : Complex(0.5, 0.0);
  return scale * Eigen::Map<const Eigen::VectorXcd>(sums.data(), M + 1);
}

/// (k pi / T)^(2p), k = 1 ..
Eigen::ArrayXd penalties(Eigen::Index count, double duration, int p) {
  const Eigen::ArrayXd q =
      Eigen::ArrayXd::LinSpaced(count, 1.0, static_cast<double>(count)) * (std::numbers::pi / duration);
  Eigen::ArrayXd power = q.square();
  if (p >= 2) power *= q.square();
  if (p >= 3) power *= q.square();
  return power;
}

/// V(mu) of generalised cross-validation with the degrees of freedom weighed by `cost` (rho):
///
///     V = sum s_k^2 b_k^2 / (n - rho sum g_k)^2,   g_k = 1 / (1 + w_k), s_k = w_k g_k, w_k = mu penalty_k,
///
/// n the number of coefficients. Infinite where the series keeps so much that rho sum g_k is n or more.
class CrossValidation {
 public:
  CrossValidation(const Eigen::VectorXd& b, double duration, int p, double cost)
      : b_squared_(b.array().square()), penalty_(penalties(b.size(), duration, p)), cost_(cost) {}

  [[nodiscard]] const Eigen::ArrayXd& penalty() const { return penalty_; }

  [[nodiscard]] double value(double mu) {
    weigh(mu);
    if (!(freedom_ > 0.0)) return std::numeric_limits<double>::infinity();
    return (s_.square() * b_squared_).sum() / (freedom_ * freedom_);
  }

  /// Half of d ln V / d ln mu; ds / d ln mu = s g.
  [[nodiscard]] double slope(double mu) {
    weigh(mu);
    if (!(freedom_ > 0.0)) return -1.0;
    loss_ = s_.square() * b_squared_;
    const double lost = loss_.sum();
    if (lost == 0.0) return 0.0;
    return (loss_ * g_).sum() / lost - cost_ * (s_ * g_).sum() / freedom_;
  }

 private:
  void weigh(double mu) {
    g_ = (1.0 + mu * penalty_).inverse();
    s_ = mu * penalty_ * g_;
    freedom_ = static_cast<double>(penalty_.size()) - cost_ * g_.sum();
  }

  Eigen::ArrayXd b_squared_;
  Eigen::ArrayXd penalty_;
  double cost_;
  Eigen::ArrayXd g_;
  Eigen::ArrayXd s_;
  Eigen::ArrayXd loss_;
  double freedom_ = 0.0;
};

/// Root of a rising slope between low and high by false position, the kept end's value halved where it stays
/// (Illinois rule); `middle` where the slope has no sign change there.
template <typename Slope>
double root_between(double low, double middle, double high, const Slope& slope_at) {
  constexpr int kMostSteps = 100;
  constexpr double kPrecision = 1e-14;
  double at_low = slope_at(low);
  double at_high = slope_at(high);
  if (!(at_low < 0.0) || !(at_high > 0.0)) return middle;
  int kept = 0;  // -1: low was kept last time, +1: high.
  double root = middle;
  for (int i = 0; i < kMostSteps && high - low > kPrecision * std::abs(high); ++i) {
    const double before = root;
    root = low + (high - low) * at_low / (at_low - at_high);
    const double at_root = slope_at(root);
    if (at_root == 0.0 || (i > 0 && std::abs(root - before) <= kPrecision * std::abs(root))) break;
    if (at_root < 0.0) {
      low = root;
      at_low = at_root;
      if (kept == 1) at_high *= 0.5;
      kept = 1;
    } else {
      high = root;
      at_high = at_root;
      if (kept == -1) at_low *= 0.5;
      kept = -1;
    }
  }
  return root;
}

/// Sine coefficients of x without the line through its ends: b = i/M times the transform of the odd
/// continuation.
Eigen::VectorXcd coefficients_of(const Eigen::VectorXcd& x, Transform& transform) {
  const Eigen::Index M = x.size() - 1;
  std::vector<Complex> odd(static_cast<std::size_t>(2 * M));
  const Complex slope = (x[M] - x[0]) / static_cast<double>(M);
  for (Eigen::Index n = 1; n < M; ++n) {
    const Complex r = x[n] - x[0] - slope * static_cast<double>(n);
    odd[static_cast<std::size_t>(n)] = r;
    odd[static_cast<std::size_t>(2 * M - n)] = -r;
  }
  std::vector<Complex> spectrum;
  transform.fwd(spectrum, odd);
  return Complex(0.0, 1.0 / static_cast<double>(M)) *
         Eigen::Map<const Eigen::VectorXcd>(spectrum.data() + 1, M - 1);
}

}  // namespace

Eigen::VectorXd sine_coefficients(const Eigen::VectorXd& x) {
  return coefficients_of(x.cast<Complex>(), transform_of_this_thread()).real();
}

double regularisation(const Eigen::VectorXd& b, double duration, int p, double cost) {
  constexpr int kGridPoints = 30;
  CrossValidation validation(b, duration, p, cost);
  const Eigen::ArrayXd& penalty = validation.penalty();
  // The harmonic that is halved runs from 0.5 to four times the highest one.
  const double log_low = -std::log(penalty[penalty.size() - 1]) - 2.0 * p * std::log(4.0);
  const double log_high = -std::log(penalty[0]) + 2.0 * p * std::log(2.0);
  const double step = (log_high - log_low) / (kGridPoints - 1);
  int best = 0;
  double best_value = std::numeric_limits<double>::infinity();
  for (int i = 0; i < kGridPoints; ++i) {
    const double value = validation.value(std::exp(log_low + step * i));
    if (value < best_value) {
      best_value = value;
      best = i;
    }
  }
  const auto slope_at = [&](double log_mu) { return validation.slope(std::exp(log_mu)); };
  return std::exp(root_between(log_low + step * std::max(best - 1, 0), log_low + step * best,
                               log_low + step * std::min(best + 1, kGridPoints - 1), slope_at));
}

OptimalDerivatives optimal_fourier(const Signals& signals, double sample_period) {
  const Eigen::Index M = signals.rows() - 1;
  const bool has_second = signals.cols() > 1;
  const double duration = static_cast<double>(M) * sample_period;
  const Eigen::ArrayXd q =
      Eigen::ArrayXd::LinSpaced(M - 1, 1.0, static_cast<double>(M - 1)) * (std::numbers::pi / duration);
  Eigen::VectorXcd x(M + 1);
  x.real() = signals.col(0);
  if (has_second) {
    x.imag() = signals.col(1);
  } else {
    x.imag().setZero();
  }
  Transform& transform = transform_of_this_thread();
  const Eigen::VectorXcd b = coefficients_of(x, transform);
  // Either axis is shrunk by its own mu.
  const auto shrunk = [&](int p) {
    const Eigen::ArrayXd penalty = penalties(M - 1, duration, p);
    Eigen::ArrayXcd c(M - 1);
    c.real() = b.real().array() / (1.0 + regularisation(b.real(), duration, p) * penalty);
    c.imag().setZero();
    if (has_second) c.imag() = b.imag().array() / (1.0 + regularisation(b.imag(), duration, p) * penalty);
    return c;
  };
  const Eigen::ArrayXcd c = shrunk(2);
  const Eigen::VectorXcd line = Eigen::VectorXcd::LinSpaced(M + 1, x[0], x[M]);
  const Eigen::VectorXcd value = line + series_sums(c.matrix(), -1.0, transform);
  const Eigen::VectorXcd rate =
      series_sums((q * c).matrix(), 1.0, transform).array() + (x[M] - x[0]) / duration;
  const Eigen::VectorXcd acceleration = -series_sums((q.square() * shrunk(3)).matrix(), -1.0, transform);

  const auto split = [&](const Eigen::VectorXcd& both) {
    Signals columns(M + 1, signals.cols());
    columns.col(0) = both.real();
    if (has_second) columns.col(1) = both.imag();
    return columns;
  };
  return {split(value), split(rate), split(acceleration)};
}

}  // namespace tonus::impedance
