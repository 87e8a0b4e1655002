#include "services/cli/results.hpp"

#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <spdlog/fmt/fmt.h>

#include "services/contract/names.hpp"
#include "services/contract/rig.hpp"

namespace tonus::cli {
namespace {

using nlohmann::json;

contract::MatrixUnits units_of(const v1::Estimate& e) {
  return contract::matrix_units({e.displacement_unit(), e.force_unit()});
}

std::string matrix_row(const v1::MatrixEstimate& m, unsigned axes, unsigned row) {
  std::string text;
  for (unsigned column = 0; column < axes; ++column) {
    const std::size_t i = row * 2 + column;
    text += fmt::format("{:>10.4g} ± {:<8.2g}", m.value()[i], m.standard_error()[i]);
  }
  return text;
}

/// 95 % intervals of the ellipse's numbers.
std::string intervals_text(const v1::MatrixEstimate& m) {
  const std::string orientation =
      std::isfinite(m.orientation_low95_deg())
          ? fmt::format("{:+.0f} to {:+.0f} deg", m.orientation_low95_deg(), m.orientation_high95_deg())
          : "orientation undetermined: may be a circle";
  return fmt::format("  95 %: size {:.4g} to {:.4g}, shape {:.2f} to {:.2f}, {}; curl {:.0f} to {:.0f} %",
                     m.size_low95(), m.size_high95(), m.shape_low95(), m.shape_high95(), orientation,
                     100.0 * m.curl_low95(), 100.0 * m.curl_high95());
}

/// The method's bias, where it was simulated and is more than a twentieth of the elements' errors.
std::string bias_text(const char* name, const v1::MatrixEstimate& m, unsigned axes) {
  constexpr double kNotable = 0.05;
  bool is_notable = false;
  std::string text;
  for (std::size_t i = 0; i < 4; ++i) {
    if (axes == 1 && i > 0) break;
    if (!std::isfinite(m.known_bias()[i])) return {};
    is_notable |= std::abs(m.known_bias()[i]) > kNotable * m.standard_error()[i];
    text += fmt::format("{}{:+.2g}", text.empty() ? "" : ", ", m.known_bias()[i]);
  }
  return is_notable ? fmt::format("    known bias of the method in {}: {}; the 95 % intervals carry it\n",
                                  name, text)
                    : std::string{};
}

std::string matrix_text(const char* name, const std::string& unit, const v1::MatrixEstimate& m, unsigned axes,
                        const Eigen::Matrix2d* truth) {
  std::string text;
  for (unsigned row = 0; row < axes; ++row) {
    text +=
        fmt::format("  {:<2}{:<10}{}", row == 0 ? name : "", row == 0 ? unit : "", matrix_row(m, axes, row));
    if (truth != nullptr) {
      text += row == 0 ? "  true " : "       ";
      for (unsigned column = 0; column < axes; ++column)
        text += fmt::format("{:>9.4g}", (*truth)(row, column));
    }
    if (row == 0 && axes == 2) {
      text += m.has_ellipse()
                  ? fmt::format("  ellipse: size {:.4g}, shape {:.2f}, {:+.0f} deg; curl {:.0f} %", m.size(),
                                m.shape(), m.orientation_deg(), 100.0 * m.curl())
                  : "  no ellipse: not positive definite";
    }
    if (row == 1 && m.has_ellipse() && std::isfinite(m.size_low95())) text += intervals_text(m);
    text += "\n";
  }
  return text + bias_text(name, m, axes);
}

json pair(const Eigen::Vector2d& v) { return json::array({v[0], v[1]}); }

json modulation_json(const std::optional<impedance::Modulation>& modulation) {
  if (!modulation) return nullptr;
  constexpr double kDegrees = 180.0 / std::numbers::pi;
  return {{"size_ratio", modulation->size_ratio},
          {"shape_ratio", modulation->shape_ratio},
          {"rotation_deg", modulation->has_rotation ? json(kDegrees * modulation->rotation) : json(nullptr)}};
}

json loaded_set(const study::LoadedSet& set) {
  return {{"set", set.set_number},
          {"bias_N", pair(set.bias)},
          {"X0_predicted_m", pair(set.predicted)},
          {"X0_actual_m", pair(set.actual)},
          {"X0_actual_std_m", pair(set.actual_std)},
          {"magnitude_ratio", set.comparison.magnitude_ratio},
          {"turn_deg", set.comparison.turn * 180.0 / std::numbers::pi},
          {"K_modulation", modulation_json(set.stiffness)},
          {"B_modulation", modulation_json(set.damping)},
          {"sigma_N", pair(set.sigma)}};
}

/// What was chosen from the data and how well it fits.
std::string fit_text(const v1::Estimate& e) {
  std::string text;
  const auto add = [&](const std::string& part) { text += (text.empty() ? "  " : "; ") + part; };
  if (std::isfinite(e.explained_share())) add(fmt::format("explained {:.1f} %", 100.0 * e.explained_share()));
  if (e.band_high_Hz() > 0.0)
    add(fmt::format("band {:.3g} to {:.3g} Hz, segments of {:.3g} s", e.band_low_Hz(), e.band_high_Hz(),
                    e.window_s()));
  for (unsigned i = 0; i < e.axes(); ++i) {
    if (!std::isfinite(e.lag_s()[i])) continue;
    const std::string axis = e.axes() == 2 ? fmt::format(" of axis {}", i + 1) : std::string();
    const double half = 0.5 * (e.lag_high95_s()[i] - e.lag_low95_s()[i]);
    add(std::isfinite(half)
            ? fmt::format("force lags{} {:+.3g} ± {:.2g} ms", axis, 1e3 * e.lag_s()[i], 1e3 * half)
            : fmt::format("force lags{} {:+.3g} ms", axis, 1e3 * e.lag_s()[i]));
  }
  if (e.independent_units() > 0) add(fmt::format("{} independent units", e.independent_units()));
  if (!text.empty()) text += "\n";
  for (const v1::ModelParameter& parameter : e.parameters())
    text += fmt::format("  {} {:.4g} {} (95 %: {:.4g} to {:.4g})\n", parameter.name(), parameter.value(),
                        parameter.unit(), parameter.low95(), parameter.high95());
  if (!e.prior().empty()) text += "  combined with the prior " + e.prior() + "\n";
  if (!e.compared_models().empty()) text += "  models compared: " + e.compared_models() + "\n";
  return text;
}

}  // namespace

json as_json(const std::vector<study::LoadedPosture>& postures) {
  json all = json::array();
  for (const study::LoadedPosture& posture : postures) {
    json sets = json::array();
    for (const study::LoadedSet& set : posture.sets) sets.push_back(loaded_set(set));
    all.push_back({{"posture", posture.posture},
                   {"run", posture.posture_index + 1},
                   {"method", posture.method},
                   {"sigma_unloaded_N", pair(posture.sigma_unloaded)},
                   {"sets", sets}});
  }
  return all;
}

std::string as_text(const v1::Estimate& e, const Truth& truth) {
  const unsigned axes = e.axes();
  std::string text = e.posture();
  const auto& place = e.posture_m();
  const bool is_place_known = place[0] != 0.0 || place[1] != 0.0;  // no hand is in its own shoulder
  if (axes == 2 && is_place_known)
    text += fmt::format("{}({:.3f}, {:.3f}) m", text.empty() ? "" : " ", place[0], place[1]);
  if (e.set_number() != 0) text += fmt::format(", set {}", e.set_number());
  if (std::hypot(e.bias_N()[0], e.bias_N()[1]) > 0.0) {
    text += fmt::format(", bias ({:+.2f}, {:+.2f}) N", e.bias_N()[0], e.bias_N()[1]);
  }
  if (!e.instruction().empty()) text += ", " + e.instruction();
  if (!text.empty()) text += "; ";
  text += fmt::format("{}, {} model; {} trials, {} rejected; {}\n", e.method(), e.model(), e.trials_used(),
                      e.trials_rejected(), v1::status_name(e.status()));
  for (const auto& reason : e.reasons()) text += "  " + reason + "\n";
  if (e.status() == v1::ESTIMATE_UNDETERMINED) return text;

  const auto units = units_of(e);
  const auto known = truth ? truth(e) : std::nullopt;
  text += matrix_text("M", units.mass, e.mass_kg(), axes, known ? &known->mass : nullptr);
  text += matrix_text("B", units.damping, e.damping_Ns_per_m(), axes, known ? &known->damping : nullptr);
  text += matrix_text("K", units.stiffness, e.stiffness_N_per_m(), axes, known ? &known->stiffness : nullptr);
  const auto& x0 = e.spring_centre_m();
  text += axes == 2
              ? fmt::format("  spring centre ({:+.2f} ± {:.2f}, {:+.2f} ± {:.2f}) mm", 1e3 * x0.value()[0],
                            1e3 * x0.standard_error()[0], 1e3 * x0.value()[1], 1e3 * x0.standard_error()[1])
              : fmt::format("  spring centre {:+.4g} ± {:.2g} {}", x0.value()[0], x0.standard_error()[0],
                            e.displacement_unit());
  text += axes == 2 ? fmt::format("; fitting error {:.3f}, {:.3f} N", e.sigma_N()[0], e.sigma_N()[1])
                    : fmt::format("; fitting error {:.3g} {}", e.sigma_N()[0], e.force_unit());
  if (e.condition_number() > 0.0) text += fmt::format("; condition number {:.0f}", e.condition_number());
  return text + "\n" + fit_text(e);
}

}  // namespace tonus::cli
