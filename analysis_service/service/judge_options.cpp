#include "analysis_service/service/judge_options.hpp"

#include <CLI/CLI.hpp>

namespace tonus::identification {
namespace {

constexpr const char* kPosture = "posture";
constexpr const char* kReaching = "reaching";

}  // namespace

void JudgeOptions::add_to(CLI::App& app) {
  app.add_option("--trial-limits", preset_,
                 "what trials are judged by: posture (a hand at rest) or reaching (a hand that moves)")
      ->check(CLI::IsMember({kPosture, kReaching}))
      ->capture_default_str();
  const auto add = [&](const char* name, std::optional<double>& limit, const char* what) {
    app.add_option(name, limit, what)->check(CLI::PositiveNumber);
  };
  add("--start-limit", choice_.start_offset,
      "of the hand from its place before the onset, m, of a rotary rig rad (posture: 0.005 m)");
  add("--excursion-limit", choice_.excursion, "of the hand's way from the rest, m or rad (posture: 0.015 m)");
  add("--rest-speed-limit", choice_.rest_speed,
      "of the hand before the onset, m/s or rad/s (posture: 0.02 m/s)");
  add("--rest-force-limit", choice_.rest_force,
      "of the force before the onset, unloaded, N or N m (posture: 1 N)");
  add("--end-speed-limit", choice_.end_speed,
      "of the hand at the end of the perturbation, m/s or rad/s (posture: 0.025 m/s)");
}

JudgeChoice JudgeOptions::choice() const {
  JudgeChoice choice = choice_;
  choice.is_reaching = preset_ == kReaching;
  return choice;
}

}  // namespace tonus::identification
