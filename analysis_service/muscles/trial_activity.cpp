#include "analysis_service/muscles/trial_activity.hpp"

#include <algorithm>
#include <cmath>
#include <spdlog/fmt/fmt.h>
#include <vector>

namespace tonus::muscles {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr Window kShortLatency{0.020, 0.050};  // s after the onset
constexpr Window kLongLatency{0.050, 0.100};

Window after(double onset, const Window& window) { return {onset + window.from, onset + window.to}; }

/// From the time of the trial's samples to that of the series.
Window in_series(const AuxiliarySeries& series, const Window& window) {
  const double begin = series.time_of(0);
  return {window.from - begin, window.to - begin};
}

/// The envelope over a window, relative to `level`; empty where it reaches beyond the signal.
std::vector<double> envelope_in(const std::vector<double>& rectified, double rate, const Window& window,
                                double level) {
  const auto first = static_cast<std::ptrdiff_t>(std::ceil(window.from * rate - 1e-6));
  const auto end = static_cast<std::ptrdiff_t>(std::ceil(window.to * rate - 1e-6));
  if (first < 0 || end <= first || end > std::ssize(rectified)) return {};
  // What follows the window, the response to the push, is kept out of the low-pass that looks both ways.
  const auto before = std::span(rectified).first(static_cast<std::size_t>(end));
  const std::vector<double> envelope = envelope_of(before, rate);
  std::vector<double> part(envelope.begin() + first, envelope.end());
  for (double& value : part) value /= level;
  return part;
}

struct Envelope {
  std::vector<double> values;
  double rate = 0.0;  // 1/s
};

/// The values next to the instants of a lower rate; an envelope has nothing above 6 Hz.
std::vector<double> thinned(const Envelope& envelope, double rate) {
  std::vector<double> values;
  for (std::size_t k = 0;; ++k) {
    const auto at = static_cast<std::size_t>(std::llround(static_cast<double>(k) * envelope.rate / rate));
    if (at >= envelope.values.size()) return values;
    values.push_back(envelope.values[at]);
  }
}

/// Of two channels that may have other rates.
double co_contraction_of(const Envelope& first, const Envelope& second) {
  const double rate = std::min(first.rate, second.rate);
  if (!(rate > 0.0)) return kNone;
  auto a = thinned(first, rate);
  auto b = thinned(second, rate);
  a.resize(std::min(a.size(), b.size()));
  b.resize(a.size());
  return muscles::co_contraction(a, b);
}

}  // namespace

std::vector<std::string> TrialActivity::above(double limit) const {
  std::vector<std::string> active;
  for (const Activity& muscle : muscles) {
    if (muscle.is_normalised && muscle.before_onset > limit)
      active.push_back(fmt::format("{} {:.3f}", muscle.channel, muscle.before_onset));
  }
  return active;
}

void Reference::add(const Id& trial, std::span<const AuxiliarySeries> series) {
  for (const AuxiliarySeries& one : series) {
    if (one.channel.type != "EMG") continue;
    const auto rectified = rectified_emg(one.values, one.channel.rate);
    if (!rectified) continue;
    const double level = reference_level(*rectified, one.channel.rate);
    if (!(level > 0.0)) continue;
    levels_[trial][one.channel.name] = level;
  }
}

double Reference::level(const std::string& channel) const {
  double largest = kNone;
  for (const auto& [trial, levels] : levels_) {
    const auto known = levels.find(channel);
    if (known != levels.end() && !(known->second <= largest)) largest = known->second;
  }
  return largest;
}

TrialActivity Reference::measure(std::span<const AuxiliarySeries> series, const Window& rest, double onset,
                                 const MuscleSettings& settings) const {
  TrialActivity found;
  std::map<std::string, Envelope> envelopes;
  for (const AuxiliarySeries& one : series) {
    if (one.channel.type != "EMG") continue;
    const double rate = one.channel.rate;
    const double reference = level(one.channel.name);
    const bool is_normalised = std::isfinite(reference);
    const double unit = is_normalised ? reference : 1.0;
    Activity activity{one.channel.name, is_normalised, kNone, kNone, kNone};
    if (const auto rectified = rectified_emg(one.values, rate)) {
      const auto mean = [&](const Window& window) {
        return mean_activity(*rectified, rate, in_series(one, window)) / unit;
      };
      activity.before_onset = mean(rest);
      activity.short_latency = mean(after(onset, kShortLatency));
      activity.long_latency = mean(after(onset, kLongLatency));
      if (is_normalised)
        envelopes[one.channel.name] = {envelope_in(*rectified, rate, in_series(one, rest), reference), rate};
    }
    found.muscles.push_back(std::move(activity));
  }
  double sum = 0.0;
  int pairs = 0;
  for (const auto& [first, second] : settings.antagonists) {
    const double index = co_contraction_of(envelopes[first], envelopes[second]);
    if (!std::isfinite(index)) continue;
    sum += index;
    ++pairs;
  }
  if (pairs > 0) found.co_contraction = sum / pairs;
  return found;
}

}  // namespace tonus::muscles
