#include "analysis_service/spectral/windowed_spectra.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <unsupported/Eigen/FFT>

namespace tonus::spectral {
namespace {

using Complex = std::complex<double>;

/// h = sin^4(pi t / T), scaled to sum h^2 = 1, and its derivatives by time (equation 1).
struct Window {
  Eigen::VectorXd h;
  Eigen::VectorXd h1;
  Eigen::VectorXd h2;
};

Window window_of(Eigen::Index length, double sample_period) {
  Window window{Eigen::VectorXd(length), Eigen::VectorXd(length), Eigen::VectorXd(length)};
  const double rate = 2.0 * std::numbers::pi / (static_cast<double>(length) * sample_period);
  for (Eigen::Index i = 0; i < length; ++i) {
    const double p = 2.0 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(length);
    window.h[i] = (3.0 - 4.0 * std::cos(p) + std::cos(2.0 * p)) / 8.0;
    window.h1[i] = rate * (4.0 * std::sin(p) - 2.0 * std::sin(2.0 * p)) / 8.0;
    window.h2[i] = rate * rate * (4.0 * std::cos(p) - 4.0 * std::cos(2.0 * p)) / 8.0;
  }
  const double norm = window.h.norm();
  window.h /= norm;
  window.h1 /= norm;
  window.h2 /= norm;
  return window;
}

/// Transforms of two real signals by one complex transform.
class PairTransform {
 public:
  explicit PairTransform(Eigen::Index length) : input_(static_cast<std::size_t>(length)) {}

  template <typename First, typename Second>
  void operator()(const First& first, const Second& second) {
    for (std::size_t i = 0; i < input_.size(); ++i)
      input_[i] = {first(static_cast<Eigen::Index>(i)), second(static_cast<Eigen::Index>(i))};
    transform_.fwd(output_, input_);
  }
  [[nodiscard]] Complex first(Eigen::Index bin) const {
    return 0.5 * (at(bin) + std::conj(at(mirrored(bin))));
  }
  [[nodiscard]] Complex second(Eigen::Index bin) const {
    return Complex(0.0, -0.5) * (at(bin) - std::conj(at(mirrored(bin))));
  }

 private:
  [[nodiscard]] Complex at(Eigen::Index bin) const { return output_[static_cast<std::size_t>(bin)]; }
  [[nodiscard]] Eigen::Index mirrored(Eigen::Index bin) const {
    return bin == 0 ? 0 : static_cast<Eigen::Index>(output_.size()) - bin;
  }
  Eigen::FFT<double> transform_;
  std::vector<Complex> input_;
  std::vector<Complex> output_;
};

}  // namespace

std::vector<Segment> segments_of(std::span<const Record> records, Eigen::Index length) {
  std::vector<Segment> segments;
  const Eigen::Index hop = std::max<Eigen::Index>(1, length / 4);
  for (std::size_t r = 0; r < records.size(); ++r) {
    const Record& record = records[r];
    std::vector<Eigen::Index> missing_before(static_cast<std::size_t>(record.samples()) + 1, 0);
    for (Eigen::Index i = 0; i < record.samples(); ++i) {
      const auto at = static_cast<std::size_t>(i);
      missing_before[at + 1] = missing_before[at] + (record.is_row_missing(i) ? 1 : 0);
    }
    for (Eigen::Index first = 0; first + length <= record.samples();) {
      const auto begin = static_cast<std::size_t>(first);
      const auto end = static_cast<std::size_t>(first + length);
      if (missing_before[end] == missing_before[begin]) {
        segments.push_back({r, first});
        first += hop;
      } else {  // on from behind the last missing row in it
        Eigen::Index last = first + length - 1;
        while (!record.is_row_missing(last)) --last;
        first = last + 1;
      }
    }
  }
  return segments;
}

std::vector<Eigen::MatrixXcd> windowed_spectra(std::span<const Record> records,
                                               std::span<const Segment> segments, Eigen::Index length,
                                               const Bins& bins) {
  std::vector<Eigen::MatrixXcd> spectra;
  if (records.empty()) return spectra;
  const int axes = records.front().axes();
  const double period = records.front().sample_period;
  const Window window = window_of(length, period);
  PairTransform transform(length);
  spectra.reserve(segments.size());
  for (const Segment& segment : segments) {
    const Record& record = records[segment.record];
    Eigen::MatrixXcd Y(4 * axes, bins.end - bins.first);
    for (int axis = 0; axis < axes; ++axis) {
      const auto x = record.displacement.col(axis).segment(segment.first, length);
      const auto f = record.force.col(axis).segment(segment.first, length);
      const double centre = x.mean();  // an offset is only rounding here
      transform([&](Eigen::Index i) { return f[i] * window.h[i]; },
                [&](Eigen::Index i) { return (x[i] - centre) * window.h[i]; });
      for (Eigen::Index k = bins.first; k < bins.end; ++k) {
        Y(axis, k - bins.first) = transform.first(k);
        Y(3 * axes + axis, k - bins.first) = transform.second(k);
      }
      transform([&](Eigen::Index i) { return (x[i] - centre) * window.h1[i]; },
                [&](Eigen::Index i) { return (x[i] - centre) * window.h2[i]; });
      for (Eigen::Index k = bins.first; k < bins.end; ++k) {
        const Complex jw(
            0.0, 2.0 * std::numbers::pi * static_cast<double>(k) / (static_cast<double>(length) * period));
        const Complex X0 = Y(3 * axes + axis, k - bins.first);
        Y(2 * axes + axis, k - bins.first) = jw * X0 - transform.first(k);  // (2)
        Y(axes + axis, k - bins.first) =
            transform.second(k) - 2.0 * jw * transform.first(k) + jw * jw * X0;  // (3)
      }
    }
    spectra.push_back(std::move(Y));
  }
  return spectra;
}

std::vector<Eigen::MatrixXcd> windowed_spectra(std::span<const Eigen::MatrixXd> signals,
                                               std::span<const Segment> segments, Eigen::Index length,
                                               std::span<const Eigen::Index> bins) {
  std::vector<Eigen::MatrixXcd> spectra;
  const Window window = window_of(length, 1.0);
  PairTransform transform(length);
  spectra.reserve(segments.size());
  for (const Segment& segment : segments) {
    const Eigen::MatrixXd& all = signals[segment.record];
    Eigen::MatrixXcd Y(all.cols(), static_cast<Eigen::Index>(bins.size()));
    for (Eigen::Index c = 0; c < all.cols(); c += 2) {
      const bool has_second = c + 1 < all.cols();
      const auto a = all.col(c).segment(segment.first, length);
      const auto b = all.col(has_second ? c + 1 : c).segment(segment.first, length);
      transform([&](Eigen::Index i) { return a[i] * window.h[i]; },
                [&](Eigen::Index i) { return b[i] * window.h[i]; });
      for (std::size_t k = 0; k < bins.size(); ++k) {
        Y(c, static_cast<Eigen::Index>(k)) = transform.first(bins[k]);
        if (has_second) Y(c + 1, static_cast<Eigen::Index>(k)) = transform.second(bins[k]);
      }
    }
    spectra.push_back(std::move(Y));
  }
  return spectra;
}

}  // namespace tonus::spectral
