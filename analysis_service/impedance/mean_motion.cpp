#include "analysis_service/impedance/mean_motion.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "analysis_service/impedance/condition_response.hpp"
#include "analysis_service/impedance/optimal_fourier.hpp"

namespace tonus::impedance {
namespace {

constexpr double kMedianOfSquares = 0.455;  // chi-squared of one degree of freedom
constexpr Eigen::Index kNeighbours = 8;     // harmonics that are asked together
constexpr double kStandsOut = 4.0;          // of their mean square over the noise's: one in 10,000 by chance
constexpr double kBeginning = 0.05;         // s, at most

/// Harmonics up to the first that do not stand out of the noise.
Eigen::Index band_of(const Eigen::VectorXd& b) {
  const Eigen::ArrayXd power = b.array().square();
  const Eigen::Index count = power.size();
  if (count < 4 * kNeighbours) return count;
  std::vector<double> upper(power.data() + count - count / 4, power.data() + count);
  const auto middle = upper.begin() + static_cast<std::ptrdiff_t>(upper.size() / 2);
  std::ranges::nth_element(upper, middle);
  const double noise = *middle / kMedianOfSquares;
  Eigen::Index band = kNeighbours;
  while (band < count - kNeighbours && power.segment(band, kNeighbours).mean() > kStandsOut * noise) ++band;
  return band;
}

/// Lets one column of the motion begin at the onset, from rest. What noise and a cut series leave before it
/// is a motion that had begun before, whose momentum a filter that is set to the rest would take for a force.
/// Its place and rate at the onset, of the noise's size, are taken away within `T` s by the polynomials of
/// degree five that have them there and end in rest, so that v and a stay the derivatives of x.
void begin_from_rest(Eigen::Index rest, double T, double sample_period, Eigen::Index column,
                     refined::AxisMotion& motion) {
  const double x0 = motion.x(rest, column);
  const double v0 = motion.v(rest, column);
  for (Eigen::MatrixXd* signal : {&motion.x, &motion.v, &motion.a}) signal->col(column).head(rest).setZero();
  for (Eigen::Index n = rest; n < motion.x.rows(); ++n) {
    const double u = static_cast<double>(n - rest) * sample_period / T;
    if (u >= 1.0) break;
    const double u2 = u * u;
    const double u3 = u2 * u;
    const double u4 = u3 * u;
    const double u5 = u4 * u;
    motion.x(n, column) -=
        (1.0 - 10.0 * u3 + 15.0 * u4 - 6.0 * u5) * x0 + T * (u - 6.0 * u3 + 8.0 * u4 - 3.0 * u5) * v0;
    motion.v(n, column) -=
        (-30.0 * u2 + 60.0 * u3 - 30.0 * u4) / T * x0 + (1.0 - 18.0 * u2 + 32.0 * u3 - 15.0 * u4) * v0;
    motion.a(n, column) -=
        (-60.0 * u + 180.0 * u2 - 120.0 * u3) / (T * T) * x0 + (-36.0 * u + 96.0 * u2 - 60.0 * u3) / T * v0;
  }
  motion.a(rest, column) *= 0.5;  // it begins there: the mean of both sides
}

/// Of a motion (rows): its band-limited form, rate and acceleration.
void take_column(const Eigen::VectorXd& measured, Eigen::Index rest, double sample_period,
                 Eigen::Index column, refined::AxisMotion& motion) {
  const Eigen::Index M = measured.size() - 1;
  const Eigen::VectorXd b = sine_coefficients(measured);
  const Eigen::Index band = band_of(b);
  const double w = std::numbers::pi / (static_cast<double>(M) * sample_period);
  const Eigen::ArrayXd angle = Eigen::ArrayXd::LinSpaced(2 * M, 0.0, static_cast<double>(2 * M - 1)) *
                               (std::numbers::pi / static_cast<double>(M));
  const Eigen::ArrayXd sine = angle.sin();
  const Eigen::ArrayXd cosine = angle.cos();
  const double slope = (measured[M] - measured[0]) / static_cast<double>(M);
  Eigen::VectorXd x = measured[0] + slope * Eigen::ArrayXd::LinSpaced(M + 1, 0.0, static_cast<double>(M));
  Eigen::VectorXd v = Eigen::VectorXd::Constant(M + 1, slope / sample_period);
  Eigen::VectorXd a = Eigen::VectorXd::Zero(M + 1);
  for (Eigen::Index k = 1; k <= band; ++k) {
    const double q = w * static_cast<double>(k);
    const double bk = b[k - 1];
    Eigen::Index at = 0;  // k n modulo 2 M
    for (Eigen::Index n = 0; n <= M; ++n) {
      x[n] += bk * sine[at];
      v[n] += q * bk * cosine[at];
      a[n] -= q * q * bk * sine[at];
      at += k;
      if (at >= 2 * M) at -= 2 * M;
    }
  }
  motion.x.col(column) = x;
  motion.v.col(column) = v;
  motion.a.col(column) = a;
  const double shortest =
      2.0 * std::numbers::pi / (w * static_cast<double>(band));  // period of the band's end
  begin_from_rest(rest, std::min(kBeginning, shortest), sample_period, column, motion);
}

}  // namespace

refined::CommandMotion mean_motion(std::span<const Trial* const> trials, double window) {
  refined::CommandMotion motion;
  motion.rest = trials.front()->onset;
  Eigen::Index moving = trials.front()->samples() - motion.rest;
  for (const Trial* trial : trials) {
    motion.rest = std::min(motion.rest, trial->onset);
    moving = std::min(moving, trial->samples() - trial->onset);
  }
  const Eigen::Index rows = motion.rest + moving;
  const Eigen::Index axes = trials.front()->axes();
  motion.targets = means_over_window(trials, window,
                                     [](const Trial& trial) -> const Signals& { return trial.displacement; });
  const Eigen::MatrixXd weights = motion.targets * (motion.targets.transpose() * motion.targets).inverse();
  if (!weights.allFinite()) return {};
  for (Eigen::Index b = 0; b < axes; ++b) {
    Eigen::MatrixXd mean = Eigen::MatrixXd::Zero(rows, axes);
    for (std::size_t j = 0; j < trials.size(); ++j)
      mean += weights(static_cast<Eigen::Index>(j), b) *
              trials[j]->displacement.middleRows(trials[j]->onset - motion.rest, rows);
    refined::AxisMotion one{Eigen::MatrixXd(rows, axes), Eigen::MatrixXd(rows, axes),
                            Eigen::MatrixXd(rows, axes)};
    for (Eigen::Index column = 0; column < axes; ++column)
      take_column(mean.col(column), motion.rest, trials.front()->sample_period, column, one);
    motion.of_axis.push_back(std::move(one));
  }
  return motion;
}

}  // namespace tonus::impedance
