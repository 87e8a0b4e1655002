#include "analysis_service/study/loaded_postures.hpp"

#include <algorithm>
#include <iterator>
#include <map>
#include <spdlog/fmt/fmt.h>
#include <utility>

#include "analysis_service/study/units.hpp"

namespace tonus::study {
namespace {

Eigen::Matrix2d matrix(const v1::MatrixEstimate& estimate) {
  const auto& v = estimate.value();
  return (Eigen::Matrix2d() << v[0], v[1], v[2], v[3]).finished();
}

Eigen::Vector2d vector(const std::array<double, 2>& v) { return {v[0], v[1]}; }

bool is_loaded(const v1::Estimate& estimate) { return vector(estimate.bias_N()) != Eigen::Vector2d::Zero(); }

bool belongs(const v1::Estimate& estimate) {
  return estimate.axes() == 2 && estimate.model() == "linear" && estimate.set_number() != 0 &&
         estimate.status() != v1::ESTIMATE_UNDETERMINED;
}

/// The sets of one posture by one method, by number.
using Sets = std::map<std::int32_t, const v1::Estimate*>;

/// Mean of the first and the last unloaded set; false where there is none.
bool take_reference(const Sets& sets, LoadedPosture& posture) {
  std::vector<const v1::Estimate*> unloaded;
  for (const auto& [number, estimate] : sets) {
    if (!is_loaded(*estimate)) unloaded.push_back(estimate);
  }
  if (unloaded.empty()) return false;
  for (const v1::Estimate* estimate : {unloaded.front(), unloaded.back()}) {
    posture.K_unloaded += 0.5 * matrix(estimate->stiffness_N_per_m());
    posture.B_unloaded += 0.5 * matrix(estimate->damping_Ns_per_m());
    posture.sigma_unloaded += 0.5 * vector(estimate->sigma_N());
  }
  return true;
}

std::optional<LoadedSet> loaded_set(const v1::Estimate& estimate, const LoadedPosture& reference) {
  LoadedSet set;
  set.set_number = estimate.set_number();
  set.bias = vector(estimate.bias_N());
  const auto predicted = impedance::predicted_spring_centre(reference.K_unloaded, set.bias);
  if (!predicted) return std::nullopt;
  set.predicted = *predicted;
  set.actual = vector(estimate.spring_centre_m().value());
  set.actual_std = vector(estimate.spring_centre_m().standard_error());
  set.comparison = impedance::compare(set.actual, set.predicted);
  set.stiffness = impedance::modulation(matrix(estimate.stiffness_N_per_m()), reference.K_unloaded);
  set.damping = impedance::modulation(matrix(estimate.damping_Ns_per_m()), reference.B_unloaded);
  set.sigma = vector(estimate.sigma_N());
  return set;
}

std::string modulation_text(const char* name, const std::optional<impedance::Modulation>& modulation) {
  if (!modulation) return fmt::format("{}: no ellipse", name);
  return fmt::format("{}: size x {:.2f}, shape x {:.2f}, turned {}", name, modulation->size_ratio,
                     modulation->shape_ratio,
                     modulation->has_rotation ? fmt::format("{:+.0f} deg", kDegrees * modulation->rotation)
                                              : std::string("-"));
}

}  // namespace

std::vector<LoadedPosture> loaded_postures(std::span<const v1::Estimate> estimates) {
  std::map<std::pair<std::uint32_t, std::string>, Sets> by_posture;
  for (const v1::Estimate& estimate : estimates) {
    if (!belongs(estimate)) continue;
    by_posture[{estimate.posture_index(), estimate.method()}][estimate.set_number()] = &estimate;
  }
  std::vector<LoadedPosture> postures;
  for (const auto& [key, sets] : by_posture) {
    LoadedPosture posture;
    posture.posture_index = key.first;
    posture.method = key.second;
    posture.posture = sets.begin()->second->posture();
    if (!take_reference(sets, posture)) continue;
    for (const auto& [number, estimate] : sets) {
      if (!is_loaded(*estimate)) continue;
      if (auto set = loaded_set(*estimate, posture)) posture.sets.push_back(*set);
    }
    if (!posture.sets.empty()) postures.push_back(std::move(posture));
  }
  return postures;
}

std::string as_text(const LoadedPosture& posture) {
  std::string text =
      fmt::format("{}, loaded against unloaded; {}; fitting error unloaded {:.3f}, {:.3f} N\n",
                  posture.posture, posture.method, posture.sigma_unloaded[0], posture.sigma_unloaded[1]);
  auto out = std::back_inserter(text);
  for (const LoadedSet& set : posture.sets) {
    fmt::format_to(
        out,
        "  set {}: bias ({:+.2f}, {:+.2f}) N; spring centre predicted ({:+.2f}, {:+.2f}) mm, actual "
        "({:+.2f} ± {:.2f}, {:+.2f} ± {:.2f}) mm: {:.2f} times as far, turned {:+.0f} deg\n"
        "         {}; {}; fitting error {:.3f}, {:.3f} N\n",
        set.set_number, set.bias[0], set.bias[1], kMillimetres * set.predicted[0],
        kMillimetres * set.predicted[1], kMillimetres * set.actual[0], kMillimetres * set.actual_std[0],
        kMillimetres * set.actual[1], kMillimetres * set.actual_std[1], set.comparison.magnitude_ratio,
        kDegrees * set.comparison.turn, modulation_text("stiffness", set.stiffness),
        modulation_text("damping", set.damping), set.sigma[0], set.sigma[1]);
  }
  return text;
}

}  // namespace tonus::study
