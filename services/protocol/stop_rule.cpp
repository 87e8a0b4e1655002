#include "services/protocol/stop_rule.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <spdlog/fmt/fmt.h>
#include <vector>

namespace tonus::protocol {
namespace {

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

struct Goal {
  const char* what;
  double width;
  double goal;
};

std::vector<Goal> goals_of(const StopWhen& rule, const Look& look) {
  std::vector<Goal> goals{{"stiffness", look.stiffness, rule.stiffness}};
  if (rule.mass) goals.push_back({"mass", look.mass, *rule.mass});
  if (rule.damping) goals.push_back({"damping", look.damping, *rule.damping});
  return goals;
}

/// The goal that takes most trials.
Goal farthest(const StopWhen& rule, const Look& look) {
  const auto goals = goals_of(rule, look);
  return *std::max_element(goals.begin(), goals.end(),
                           [](const Goal& a, const Goal& b) { return a.width / a.goal < b.width / b.goal; });
}

std::string width_text(const Goal& goal) {
  return fmt::format("half-width of {} {:.2g} %, goal {:.2g} %", goal.what, 100.0 * goal.width,
                     100.0 * goal.goal);
}

/// No estimate showed a force that M, B and K do not describe.
bool are_linear(std::span<const Look> looks) {
  return std::all_of(looks.begin(), looks.end(),
                     [](const Look& look) { return look.is_linear || !std::isfinite(look.stiffness); });
}

}  // namespace

bool is_narrow(const StopWhen& rule, const Look& look) {
  const auto goals = goals_of(rule, look);
  return look.is_ok &&
         std::all_of(goals.begin(), goals.end(), [](const Goal& goal) { return goal.width <= goal.goal; });
}

Ruling ruling_on(const StopWhen& rule, std::span<const Look> looks) {
  Ruling ruling{LookEnd::kGoesOn, kUnknown, {}};
  if (looks.empty()) return ruling;
  const Look& look = looks.back();
  const Goal goal = farthest(rule, look);
  const bool is_known = std::isfinite(goal.width);
  const double ratio = goal.width / goal.goal;
  if (is_known) ruling.needed = static_cast<double>(look.trials) * ratio * ratio;
  const std::size_t row = rule.looks_in_a_row;
  const bool is_reached =
      looks.size() >= row && std::all_of(looks.end() - static_cast<std::ptrdiff_t>(row), looks.end(),
                                         [&](const Look& one) { return is_narrow(rule, one); });
  if (is_reached) {
    ruling.end = LookEnd::kReached;
    ruling.because = fmt::format("{} trials: {}", look.trials, width_text(goal));
    return ruling;
  }
  const bool is_over = look.trials >= static_cast<std::size_t>(rule.trials_most);
  if (is_over) ruling.end = LookEnd::kOutOfTrials;
  const std::string most = fmt::format("{} trials, the most allowed", rule.trials_most);
  if (!is_known) {
    if (is_over) ruling.because = most + ": there is no estimate with intervals";
  } else if (is_over && ratio <= 1.0) {
    ruling.because =
        fmt::format("{}: {}, {}", most, width_text(goal),
                    look.is_ok ? "but not by enough looks in a row" : "but the estimate is not ok");
  } else if (is_over) {
    ruling.because = fmt::format("{}: {}, which takes about {:.0f} trials", most, width_text(goal),
                                 std::ceil(ruling.needed));
  } else if (ruling.needed > rule.trials_most) {
    ruling.because = fmt::format("{} after {} trials, which takes about {:.0f}, more than the {} allowed",
                                 width_text(goal), look.trials, std::ceil(ruling.needed), rule.trials_most);
  }
  return ruling;
}

Drive next_drive(const StopWhen& rule, const Drive& own, const Drive& now, std::size_t trials,
                 std::span<const Look> looks) {
  if (looks.empty()) return now;
  if (!are_linear(looks)) return {own.amplitude, now.rise_time};
  if (!looks.back().is_ok || trials < static_cast<std::size_t>(rule.trials_least)) return now;
  return {std::min(std::max(now.amplitude, rule.amplitude_most), kAmplitudeStep * now.amplitude),
          now.rise_time};
}

Drive drive_after(const StopWhen& rule, const Drive& own, const Drive& now, std::span<const Look> looks) {
  if (looks.empty() || !are_linear(looks)) return own;
  if (!looks.back().is_ok) return now;
  return {std::min(std::max(now.amplitude, rule.amplitude_most), kAmplitudeStep * now.amplitude),
          std::max(std::min(now.rise_time, rule.rise_least), kRiseStep * now.rise_time)};
}

}  // namespace tonus::protocol
