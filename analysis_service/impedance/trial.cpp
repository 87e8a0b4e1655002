#include "analysis_service/impedance/trial.hpp"

#include <algorithm>
#include <cmath>
#include <spdlog/fmt/fmt.h>
#include <utility>

namespace tonus::impedance {
namespace {

Result<void> check_samples(std::span<const EndpointSample> samples, const Preparation& preparation,
                           const std::vector<bool>& is_missing = {}) {
  const bool has_stamps = samples.front().acquisition_ns != samples.back().acquisition_ns;
  std::size_t last = samples.size();  // that is there; none yet
  for (std::size_t k = 0; k < samples.size(); ++k) {
    if (!is_missing.empty() && is_missing[k]) continue;
    const std::size_t before = std::exchange(last, k);
    if (!samples[k].p_SE.allFinite() || !samples[k].f_S.allFinite()) {
      return fail(ErrorCode::kDataLoss, fmt::format("trial: sample {} is not finite", k));
    }
    if (!has_stamps || before == samples.size()) continue;
    const double step =
        1e-9 * static_cast<double>(samples[k].acquisition_ns - samples[before].acquisition_ns);
    const double expected = static_cast<double>(k - before) * preparation.sample_period;
    if (std::abs(step - expected) > 0.5 * preparation.sample_period) {
      return fail(ErrorCode::kDataLoss,
                  fmt::format("trial: sample {} comes {} s after the one before it; expected {} s", k, step,
                              expected));
    }
  }
  return {};
}

Trial copy_rows(std::uint32_t number, std::span<const EndpointSample> samples, const Preparation& preparation,
                std::span<const Eigen::Vector2d> commanded) {
  const auto rows = static_cast<Eigen::Index>(samples.size());
  Trial trial;
  trial.number = number;
  trial.sample_period = preparation.sample_period;
  trial.handle_mass = preparation.handle_mass;
  trial.displacement.resize(rows, preparation.axes);
  trial.force.resize(rows, preparation.axes);
  trial.commanded.resize(static_cast<Eigen::Index>(commanded.size()), preparation.axes);
  for (Eigen::Index k = 0; k < rows; ++k) {
    const auto i = static_cast<std::size_t>(k);
    for (int axis = 0; axis < preparation.axes; ++axis) {
      trial.displacement(k, axis) = samples[i].p_SE[axis];
      trial.force(k, axis) = samples[i].f_S[axis];
      if (!commanded.empty()) trial.commanded(k, axis) = commanded[i][axis];
    }
  }
  return trial;
}

void subtract(Signals& signals, const AxisVector& offset) {
  for (Eigen::Index axis = 0; axis < signals.cols(); ++axis) signals.col(axis).array() -= offset[axis];
}

/// Takes the mean of the rows that are there away, where asked; the others become zero.
void centre_present(Signals& signals, const std::vector<bool>& is_missing, bool is_centred) {
  for (Eigen::Index axis = 0; axis < signals.cols(); ++axis) {
    double sum = 0.0;
    double count = 0.0;
    for (Eigen::Index k = 0; k < signals.rows(); ++k) {
      if (is_missing[static_cast<std::size_t>(k)]) continue;
      sum += signals(k, axis);
      count += 1.0;
    }
    const double mean = is_centred && count > 0.0 ? sum / count : 0.0;
    for (Eigen::Index k = 0; k < signals.rows(); ++k)
      signals(k, axis) = is_missing[static_cast<std::size_t>(k)] ? 0.0 : signals(k, axis) - mean;
  }
}

Result<void> check_shapes(std::span<const EndpointSample> samples, const Preparation& preparation,
                          std::span<const Eigen::Vector2d> commanded) {
  if (auto valid = validate(preparation); !valid) return valid;
  if (samples.empty())
    return fail(ErrorCode::kInvalidArgument, "trial: 0 samples are not allowed; expected 1 or more");
  if (!commanded.empty() && commanded.size() != samples.size()) {
    return fail(ErrorCode::kInvalidArgument,
                fmt::format("trial: {} commanded values are not allowed; expected 0 or {}", commanded.size(),
                            samples.size()));
  }
  return {};
}

}  // namespace

Result<void> validate(const Preparation& preparation) {
  const auto refuse = [](const char* what, double value, const char* allowed) {
    return fail(ErrorCode::kInvalidArgument,
                fmt::format("preparation: {}: {} is not allowed; expected {}", what, value, allowed));
  };
  if (preparation.axes != 1 && preparation.axes != 2) return refuse("axes", preparation.axes, "1 or 2");
  if (!(preparation.sample_period > 0.0) || !std::isfinite(preparation.sample_period)) {
    return refuse("sample period", preparation.sample_period, "more than 0 s");
  }
  if (!(preparation.rest >= preparation.sample_period) || !std::isfinite(preparation.rest)) {
    return refuse("rest", preparation.rest, "one sample period or more");
  }
  if (!(preparation.handle_mass >= 0.0))
    return refuse("handle mass", preparation.handle_mass, "0 kg or more");
  return {};
}

AxisVector mean_of_rows(const Signals& signals, Eigen::Index first, Eigen::Index rows) {
  // Plain loops: a vectorised sum depends, in its last bits, on where the data stand in memory.
  AxisVector mean = AxisVector::Zero(signals.cols());
  for (Eigen::Index axis = 0; axis < signals.cols(); ++axis) {
    for (Eigen::Index k = 0; k < rows; ++k) mean[axis] += signals(first + k, axis);
    mean[axis] /= static_cast<double>(rows);
  }
  return mean;
}

void tare(Trial& trial, bool is_force_tared) {
  trial.displacement_taken = mean_of_rows(trial.displacement, 0, trial.onset);
  subtract(trial.displacement, trial.displacement_taken);
  if (!is_force_tared) return;
  trial.force_taken = mean_of_rows(trial.force, 0, trial.onset);
  subtract(trial.force, trial.force_taken);
}

Result<Trial> prepare_trial(std::uint32_t number, std::span<const EndpointSample> samples, Eigen::Index onset,
                            const Preparation& preparation, std::span<const Eigen::Vector2d> commanded) {
  if (auto valid = check_shapes(samples, preparation, commanded); !valid) return valid.error();
  const auto rows = static_cast<Eigen::Index>(samples.size());
  if (onset < 1 || onset >= rows) {
    return fail(ErrorCode::kInvalidArgument,
                fmt::format("trial {}: onset at sample {} is not allowed; expected 1 to {}", number, onset,
                            rows - 1));
  }
  const auto longest = static_cast<Eigen::Index>(std::llround(preparation.rest / preparation.sample_period));
  const auto skipped = static_cast<std::size_t>(std::max<Eigen::Index>(0, onset - longest));
  samples = samples.subspan(skipped);
  if (!commanded.empty()) commanded = commanded.subspan(skipped);
  onset -= static_cast<Eigen::Index>(skipped);
  if (auto valid = check_samples(samples, preparation); !valid) return valid.error();

  Trial trial = copy_rows(number, samples, preparation, commanded);
  trial.onset = onset;
  tare(trial, preparation.is_force_tared);
  return trial;
}

Result<Trial> prepare_record(std::uint32_t number, std::span<const EndpointSample> samples,
                             const Preparation& preparation, std::span<const Eigen::Vector2d> commanded,
                             std::vector<bool> is_missing) {
  if (auto valid = check_shapes(samples, preparation, commanded); !valid) return valid.error();
  if (!is_missing.empty() && is_missing.size() != samples.size()) {
    return fail(ErrorCode::kInvalidArgument,
                fmt::format("trial {}: {} marks of missing rows are not allowed; expected 0 or {}", number,
                            is_missing.size(), samples.size()));
  }
  const bool has_gap = std::ranges::find(is_missing, true) != is_missing.end();
  if (!has_gap) is_missing.clear();
  if (auto valid = check_samples(samples, preparation, is_missing); !valid) return valid.error();
  Trial trial = copy_rows(number, samples, preparation, commanded);
  trial.is_continuous = true;
  if (!has_gap) {
    subtract(trial.displacement, mean_of_rows(trial.displacement, 0, trial.samples()));
    if (preparation.is_force_tared) subtract(trial.force, mean_of_rows(trial.force, 0, trial.samples()));
    return trial;
  }
  trial.is_missing = std::move(is_missing);
  centre_present(trial.displacement, trial.is_missing, true);
  centre_present(trial.force, trial.is_missing, preparation.is_force_tared);
  return trial;
}

bool is_clipped(std::span<const RawSample> raw, double saturation_V) {
  for (const RawSample& sample : raw) {
    for (const double volts : sample.force_V) {
      if (std::abs(volts) >= saturation_V) return true;
    }
  }
  return false;
}

}  // namespace tonus::impedance
