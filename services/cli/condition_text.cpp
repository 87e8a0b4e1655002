#include "services/cli/condition_text.hpp"

#include <cmath>
#include <nlohmann/json.hpp>
#include <spdlog/fmt/fmt.h>

namespace tonus::cli {

std::string condition_text(const v1::ConditionProgress& condition) {
  std::string text = condition.posture();
  if (condition.set_number() != 0) text += fmt::format(" set {}", condition.set_number());
  if (!condition.instruction().empty()) text += fmt::format(", {}", condition.instruction());
  const bool is_led = condition.precision_goal() > 0.0;
  text += is_led ? fmt::format(": {} trials, at most {}", condition.counted(), condition.planned())
                 : fmt::format(": {} of {} trials", condition.counted(), condition.planned());
  if (condition.is_finished() && is_led) return text + "; finished: " + condition.finished_because();
  if (std::isfinite(condition.precision())) {
    text += fmt::format("; half-width of stiffness {:.2g} %", 100.0 * condition.precision());
    if (is_led) text += fmt::format(", goal {:.2g} %", 100.0 * condition.precision_goal());
  }
  if (condition.is_finished()) text += "; finished: " + condition.finished_because();
  return text;
}

nlohmann::json condition_json(const v1::ConditionProgress& condition) {
  nlohmann::json precision;
  if (std::isfinite(condition.precision())) precision = condition.precision();
  return {{"posture", condition.posture()},
          {"set", condition.set_number()},
          {"instruction", condition.instruction()},
          {"counted", condition.counted()},
          {"planned", condition.planned()},
          {"precision", precision},
          {"precision_goal", condition.precision_goal()},
          {"is_finished", condition.is_finished()},
          {"finished_because", condition.finished_because()}};
}

}  // namespace tonus::cli
