#include "analysis_service/impedance/tuning.hpp"

#include <cmath>
#include <complex>
#include <unsupported/Eigen/FFT>
#include <vector>

namespace tonus::impedance {
namespace {

/// A transform keeps its table of twiddle factors for the next signal of the same length.
using Transform = Eigen::FFT<double>;

double peak_of(const Signals& displacement, Eigen::Index first, Eigen::Index rows, double sample_period,
               Transform& transform) {
  const auto moved = displacement.middleRows(first, rows);
  if ((moved.colwise().maxCoeff() - moved.colwise().minCoeff()).maxCoeff() == 0.0) return 0.0;
  const AxisVector mean = mean_of_rows(displacement, first, rows);
  std::size_t length = 256;
  while (length < 8 * static_cast<std::size_t>(rows)) length *= 2;

  // Both axes in one transform: |Z(f)|^2 + |Z(-f)|^2 = 2 (|X1(f)|^2 + |X2(f)|^2) for z = x1 + i x2.
  std::vector<std::complex<double>> z(length);
  for (Eigen::Index k = 0; k < rows; ++k) {
    const double x1 = displacement(first + k, 0) - mean[0];
    const double x2 = displacement.cols() > 1 ? displacement(first + k, 1) - mean[1] : 0.0;
    z[static_cast<std::size_t>(k)] = {x1, x2};
  }
  std::vector<std::complex<double>> spectrum;
  transform.fwd(spectrum, z);
  const auto power = [&](std::size_t bin) {
    return std::norm(spectrum[bin]) + std::norm(spectrum[length - bin]);
  };

  const double bin_width = 1.0 / (static_cast<double>(length) * sample_period);
  const double lowest = 0.5 / (static_cast<double>(rows) * sample_period);
  const auto first_bin = std::max<std::size_t>(1, static_cast<std::size_t>(std::ceil(lowest / bin_width)));
  std::size_t peak = first_bin;
  for (std::size_t bin = first_bin; bin <= length / 4; ++bin) {
    if (power(bin) > power(peak)) peak = bin;
  }
  const double before = power(peak - 1);
  const double after = power(peak + 1);
  const double curvature = before - 2.0 * power(peak) + after;
  const double shift = peak > first_bin && curvature < 0.0 ? 0.5 * (before - after) / curvature : 0.0;
  return (static_cast<double>(peak) + shift) * bin_width;
}

}  // namespace

double peak_frequency(const Signals& displacement, Eigen::Index first, Eigen::Index rows,
                      double sample_period) {
  Transform transform;
  return peak_of(displacement, first, rows, sample_period, transform);
}

double tuned_natural_frequency(std::span<const Trial* const> trials, double window, double block) {
  Transform transform;
  double sum = 0.0;
  int count = 0;
  const auto add = [&](const Trial& trial, Eigen::Index first, Eigen::Index rows) {
    const double peak = peak_of(trial.displacement, first, rows, trial.sample_period, transform);
    if (peak <= 0.0) return;
    sum += peak;
    ++count;
  };
  for (const Trial* trial : trials) {
    const auto rows_in = [&](double duration) {
      return static_cast<Eigen::Index>(std::llround(duration / trial->sample_period));
    };
    if (!trial->is_continuous) {
      add(*trial, trial->onset, std::min(rows_in(window), trial->samples() - trial->onset));
      continue;
    }
    const Eigen::Index rows = rows_in(block);
    for (Eigen::Index first = 0; first + rows <= trial->samples(); first += rows) add(*trial, first, rows);
  }
  return count > 0 ? sum / count : 0.0;
}

}  // namespace tonus::impedance
