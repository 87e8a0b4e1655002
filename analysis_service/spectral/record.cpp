#include "analysis_service/spectral/record.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <unsupported/Eigen/FFT>

namespace tonus::spectral {
namespace {

/// Straight lines over runs of missing rows; the nearest value before the first and after the last usable
/// row.
void fill(const Record& record, Eigen::Ref<Eigen::VectorXd> signal) {
  const Eigen::Index rows = record.samples();
  Eigen::Index last = -1;
  for (Eigen::Index i = 0; i <= rows; ++i) {
    if (i < rows && record.is_row_missing(i)) continue;
    const Eigen::Index gap = i - last - 1;
    for (Eigen::Index g = 1; g <= gap; ++g) {
      const double share = static_cast<double>(g) / static_cast<double>(gap + 1);
      if (last < 0) {
        signal[last + g] = i < rows ? signal[i] : 0.0;
      } else {
        signal[last + g] = i < rows ? (1.0 - share) * signal[last] + share * signal[i] : signal[last];
      }
    }
    last = i;
  }
}

double mean_of_usable(const Record& record, const Eigen::Ref<const Eigen::VectorXd>& signal) {
  double sum = 0.0;
  double count = 0.0;
  for (Eigen::Index i = 0; i < record.samples(); ++i) {
    if (record.is_row_missing(i)) continue;
    sum += signal[i];
    count += 1.0;
  }
  return count > 0.0 ? sum / count : 0.0;
}

/// f(t + lead): the line through the ends is shifted by itself, the rest by its transform, behind zeros that
/// keep its ends apart.
void advance(Eigen::Ref<Eigen::VectorXd> f, double lead, double sample_period) {
  const Eigen::Index rows = f.size();
  const Eigen::Index end = std::min<Eigen::Index>(20, rows);
  const Eigen::VectorXd line = Eigen::VectorXd::LinSpaced(rows, f.head(end).mean(), f.tail(end).mean());
  const double shift = lead / sample_period;
  const Eigen::Index length =
      fast_length(rows + static_cast<Eigen::Index>(4.0 * std::ceil(std::abs(shift))) + 100);
  std::vector<std::complex<double>> padded(static_cast<std::size_t>(length));
  for (Eigen::Index i = 0; i < rows; ++i) padded[static_cast<std::size_t>(i)] = f[i] - line[i];
  Eigen::FFT<double> transform;
  std::vector<std::complex<double>> spectrum;
  transform.fwd(spectrum, padded);
  for (Eigen::Index k = 0; k < length; ++k) {
    const auto signed_k = static_cast<double>(k <= length / 2 ? k : k - length);
    const double phase = 2.0 * std::numbers::pi * signed_k * shift / static_cast<double>(length);
    spectrum[static_cast<std::size_t>(k)] *= std::polar(1.0, phase);
  }
  transform.inv(padded, spectrum);
  const double step = rows > 1 ? (line[rows - 1] - line[0]) / static_cast<double>(rows - 1) : 0.0;
  for (Eigen::Index i = 0; i < rows; ++i)
    f[i] = padded[static_cast<std::size_t>(i)].real() + line[i] + step * shift;
}

}  // namespace

Record filled(const Record& record) {
  Record whole = record;
  for (auto* signals : {&whole.displacement, &whole.force}) {
    for (Eigen::Index axis = 0; axis < signals->cols(); ++axis) {
      const double mean = mean_of_usable(record, signals->col(axis));
      for (Eigen::Index i = 0; i < record.samples(); ++i) {
        if (!record.is_row_missing(i)) (*signals)(i, axis) -= mean;
      }
      fill(record, signals->col(axis));
    }
  }
  return whole;
}

Record with_force_advanced(const Record& record, const Eigen::VectorXd& lead) {
  Record shifted = record;
  for (Eigen::Index axis = 0; axis < shifted.force.cols(); ++axis)
    advance(shifted.force.col(axis), lead[axis], record.sample_period);
  return shifted;
}

Eigen::Index fast_length(Eigen::Index least) {
  const auto is_fast = [](Eigen::Index n) {
    for (const Eigen::Index prime : {2, 3, 5}) {
      while (n % prime == 0) n /= prime;
    }
    return n == 1;
  };
  Eigen::Index length = std::max<Eigen::Index>(2, least + least % 2);
  while (!is_fast(length)) length += 2;
  return length;
}

}  // namespace tonus::spectral
