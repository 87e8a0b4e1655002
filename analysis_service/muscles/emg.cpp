#include "analysis_service/muscles/emg.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <optional>
#include <spdlog/fmt/fmt.h>

#include "analysis_service/impedance/butterworth.hpp"

namespace tonus::muscles {
namespace {

using impedance::SecondOrderFilter;

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr double kReferenceWindow = 0.5;     // s
constexpr double kEarliestResponse = 0.010;  // s; no reflex of a human arm is faster
/// Of the log-likelihood ratio, which takes values next to each other for independent: of band-passed EMG
/// without a change, 1 of 160 signals exceeds 12 and none 13; responses of the simulated subject exceed 4000.
constexpr double kSureChange = 20.0;
constexpr double kBeginning = 0.005;  // s, of a response, that its begin is looked for in again

/// As butterworth_lowpass(), the other side of the edge.
SecondOrderFilter butterworth_highpass(double cutoff, double sample_period) {
  const double c = std::tan(std::numbers::pi * cutoff * sample_period);
  const double norm = 1.0 + std::numbers::sqrt2 * c + c * c;
  return {{1.0 / norm, -2.0 / norm, 1.0 / norm},
          {1.0, 2.0 * (c * c - 1.0) / norm, (1.0 - std::numbers::sqrt2 * c + c * c) / norm}};
}

/// Forward only, from rest; transposed direct form II.
void filter(const SecondOrderFilter& f, std::vector<double>& signal) {
  double z1 = 0.0;
  double z2 = 0.0;
  for (double& value : signal) {
    const double input = value;
    value = f.b[0] * input + z1;
    z1 = f.b[1] * input - f.a[1] * value + z2;
    z2 = f.b[2] * input - f.a[2] * value;
  }
}

/// Mean of what was measured; NaN where nothing was.
double mean_of_measured(std::span<const float> values) {
  double sum = 0.0;
  std::size_t count = 0;
  for (const float value : values) {
    if (!std::isfinite(value)) continue;
    sum += value;
    ++count;
  }
  return count == 0 ? kNone : sum / static_cast<double>(count);
}

/// First value at or after an instant.
std::ptrdiff_t index_of(double time, double rate) {
  return static_cast<std::ptrdiff_t>(std::ceil(time * rate - 1e-6));
}

/// Where the variance of a signal changes with the largest likelihood (8).
class VarianceChange {
 public:
  VarianceChange(std::span<const double> squares, std::size_t trials)
      : trials_(trials), sum_(squares.size() + 1, 0.0) {
    std::partial_sum(squares.begin(), squares.end(), sum_.begin() + 1);
  }

  /// The index from `first` on where the values up to `end` rise, if it is a rise beyond chance.
  [[nodiscard]] std::optional<std::size_t> rise(std::size_t first, std::size_t end) const {
    std::optional<std::size_t> place;
    double best = kSureChange;
    for (std::size_t k = first; k + 2 < end; ++k) {
      if (mean(k, end) <= mean(0, k)) continue;
      const double gain = half_log(0, end) - half_log(0, k) - half_log(k, end);
      if (gain <= best) continue;
      best = gain;
      place = k;
    }
    return place;
  }

 private:
  [[nodiscard]] double mean(std::size_t first, std::size_t last) const {
    return (sum_[last] - sum_[first]) / static_cast<double>((last - first) * trials_);
  }
  /// Minus the log-likelihood, but for a constant.
  [[nodiscard]] double half_log(std::size_t first, std::size_t last) const {
    return 0.5 * static_cast<double>((last - first) * trials_) *
           std::log(std::max(mean(first, last), 1e-300));
  }

  std::size_t trials_;
  std::vector<double> sum_;
};

}  // namespace

Result<std::vector<double>> rectified_emg(std::span<const float> values, double rate,
                                          const EmgOptions& options) {
  const double high = std::min(options.high, options.most_of_nyquist * 0.5 * rate);
  if (!(high > options.low)) {
    return fail(ErrorCode::kInvalidArgument,
                fmt::format("EMG: a rate of {:g} Hz is not allowed; expected more than {:g} Hz", rate,
                            2.0 * options.low / options.most_of_nyquist));
  }
  const double mean = mean_of_measured(values);
  std::vector<double> signal(values.size());
  for (std::size_t k = 0; k < values.size(); ++k)
    signal[k] = std::isfinite(values[k]) ? values[k] - mean : 0.0;
  filter(butterworth_highpass(options.low, 1.0 / rate), signal);
  filter(impedance::butterworth_lowpass(high, 1.0 / rate), signal);
  for (std::size_t k = 0; k < values.size(); ++k)
    signal[k] = std::isfinite(values[k]) ? std::abs(signal[k]) : kNone;
  return signal;
}

std::vector<double> envelope_of(std::span<const double> rectified, double rate, const EmgOptions& options) {
  std::vector<double> envelope(rectified.begin(), rectified.end());
  for (double& value : envelope) {
    if (!std::isfinite(value)) value = 0.0;
  }
  const auto rows = static_cast<Eigen::Index>(envelope.size());
  if (rows <= impedance::kZeroPhasePadding) return envelope;
  impedance::Signals column(rows, 1);
  column.col(0) = Eigen::Map<const Eigen::VectorXd>(envelope.data(), rows);
  const auto smooth =
      impedance::zero_phase(impedance::butterworth_lowpass(options.envelope, 1.0 / rate), column);
  for (Eigen::Index k = 0; k < rows; ++k) envelope[static_cast<std::size_t>(k)] = std::max(0.0, smooth(k, 0));
  return envelope;
}

double mean_activity(std::span<const double> rectified, double rate, const Window& window) {
  const std::ptrdiff_t first = index_of(window.from, rate);
  const std::ptrdiff_t end = index_of(window.to, rate);
  if (first < 0 || end <= first || end > std::ssize(rectified)) return kNone;
  double sum = 0.0;
  std::ptrdiff_t count = 0;
  for (std::ptrdiff_t k = first; k < end; ++k) {
    const double value = rectified[static_cast<std::size_t>(k)];
    if (!std::isfinite(value)) continue;
    sum += value;
    ++count;
  }
  return 2 * count < end - first ? kNone : sum / static_cast<double>(count);
}

double reference_level(std::span<const double> rectified, double rate) {
  double largest = kNone;
  const double length = static_cast<double>(rectified.size()) / rate;
  const double step = kReferenceWindow / 10.0;
  for (int i = 0; step * i + kReferenceWindow <= length + 1e-9; ++i) {
    const double mean = mean_activity(rectified, rate, {step * i, step * i + kReferenceWindow});
    if (std::isfinite(mean)) largest = std::isnan(largest) ? mean : std::max(largest, mean);
  }
  return largest;
}

double co_contraction(std::span<const double> first, std::span<const double> second) {
  if (first.size() != second.size()) return kNone;
  double common = 0.0;
  double sum = 0.0;
  for (std::size_t k = 0; k < first.size(); ++k) {
    if (!std::isfinite(first[k]) || !std::isfinite(second[k])) continue;
    common += std::min(first[k], second[k]);
    sum += first[k] + second[k];
  }
  return sum > 0.0 ? 2.0 * common / sum : kNone;
}

double response_latency(std::span<const double> squares, std::size_t trials, std::size_t onset, double rate,
                        double latest) {
  const std::size_t earliest = onset + static_cast<std::size_t>(std::lround(kEarliestResponse * rate));
  std::size_t end = std::min(squares.size(), onset + static_cast<std::size_t>(std::lround(latest * rate)));
  if (trials == 0 || onset == 0) return kNone;
  const VarianceChange search(squares, trials);
  auto found = search.rise(earliest, end);
  if (!found) return kNone;
  // What rises gradually is drawn towards its middle; its beginning alone is not.
  const auto beginning = static_cast<std::size_t>(std::lround(kBeginning * rate));
  while (true) {
    end = std::min(end, *found + beginning);
    const auto earlier = search.rise(earliest, end);
    if (!earlier || *earlier >= *found) return static_cast<double>(*found - onset) / rate;
    found = earlier;
  }
}

}  // namespace tonus::muscles
