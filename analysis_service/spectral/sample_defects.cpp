#include "analysis_service/spectral/sample_defects.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace tonus::spectral {
namespace {

constexpr int kMostHeld = 60;
constexpr std::size_t kFewestChanges = 20;
constexpr double kChangesAtStep = 0.95;  // of all changes: at one place of the step

/// Samples a step at whose beginning nearly all changes lie; 1: none.
int step_of(const std::vector<Eigen::Index>& changes, Eigen::Index samples) {
  if (changes.size() < kFewestChanges ||
      static_cast<double>(changes.size()) > 0.8 * static_cast<double>(samples))
    return 1;
  int step = 1;
  for (int r = 2; r < kMostHeld; ++r) {
    std::vector<std::size_t> at(static_cast<std::size_t>(r), 0);
    for (const Eigen::Index change : changes) ++at[static_cast<std::size_t>(change % r)];
    const bool is_at_one_place = static_cast<double>(*std::ranges::max_element(at)) >
                                 kChangesAtStep * static_cast<double>(changes.size());
    if (is_at_one_place && static_cast<double>(changes.size()) > 0.5 * static_cast<double>(samples) / r)
      step = r;
  }
  return step;
}

/// Samples at an extreme that is held in runs of three or more and is met much more often than the value next
/// to it: an extreme of quantised motion is not, because the motion passes through the next step as well.
Eigen::Index clipped_at(const Eigen::Ref<const Eigen::VectorXd>& signal, double extreme) {
  Eigen::Index at_extreme = 0;
  Eigen::Index in_runs = 0;
  Eigen::Index run = 0;
  double next = extreme;
  Eigen::Index at_next = 0;
  for (const double value : signal) {
    if (value == extreme) {
      ++at_extreme;
      if (++run >= 3) ++in_runs;
      continue;
    }
    run = 0;
    if (value == next) {
      ++at_next;
    } else if (next == extreme || std::abs(value - extreme) < std::abs(next - extreme)) {
      next = value;
      at_next = 1;
    }
  }
  return in_runs >= 3 && at_extreme > 5 * at_next ? at_extreme : 0;
}

}  // namespace

SampleDefects sample_defects_of(const Eigen::Ref<const Eigen::VectorXd>& signal) {
  SampleDefects defects;
  const Eigen::Index samples = signal.size();
  if (samples < 4) return defects;
  const double low = signal.minCoeff();
  const double high = signal.maxCoeff();
  const double least = 1e-9 * (high - low);
  std::vector<Eigen::Index> changes;
  std::vector<Eigen::Index> bends;
  for (Eigen::Index i = 1; i < samples; ++i) {
    if (std::abs(signal[i] - signal[i - 1]) > least) changes.push_back(i);
    if (i + 1 < samples && std::abs(signal[i + 1] - 2.0 * signal[i] + signal[i - 1]) > least)
      bends.push_back(i);
  }
  defects.held_for = std::max(step_of(changes, samples), step_of(bends, samples));
  defects.held_share = 1.0 - 1.0 / defects.held_for;

  if (high > low) {
    for (const double extreme : {low, high})
      defects.clipped_share +=
          static_cast<double>(clipped_at(signal, extreme)) / static_cast<double>(samples);
  }
  return defects;
}

}  // namespace tonus::spectral
