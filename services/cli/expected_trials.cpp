#include "services/cli/expected_trials.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <numbers>
#include <spdlog/fmt/fmt.h>

#include "analysis_service/certify/precision_led.hpp"
#include "services/core/parallel.hpp"
#include "services/protocol/estimate_look.hpp"
#include "services/simulation/true_impedance.hpp"

namespace tonus::cli {
namespace {

constexpr std::size_t kDraws = 16;
constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

certify::Setting setting_of(const simulation::Profile& profile) {
  certify::Setting setting;
  setting.name = "profile";
  const auto& sensors = profile.sensors;
  setting.sensors.force_noise = std::hypot(sensors.force_noise, sensors.force_resolution / std::sqrt(12.0));
  setting.sensors.displacement_noise = 0.0;
  setting.sensors.encoder_step = 2.0 * std::numbers::pi / sensors.encoder_counts_per_rev;
  const auto& subject = profile.subject;
  if (subject.drift.is_on) {
    setting.disturbance.drift = subject.drift.force;
    setting.disturbance.drift_time = subject.drift.time_constant;
  }
  if (subject.tremor.is_on) {
    setting.disturbance.tremor = subject.tremor.force;
    setting.disturbance.tremor_frequency = subject.tremor.frequency;
    setting.disturbance.tremor_bandwidth = subject.tremor.bandwidth;
  }
  return setting;
}

const std::string& instruction_of(const protocol::Protocol& protocol,
                                  const protocol::PlannedCondition& condition) {
  return protocol.instructions[condition.instruction_index].name;
}

certify::Truth truth_of(const protocol::Protocol& protocol, const protocol::PlannedCondition& condition,
                        const simulation::Profile& profile, std::mt19937_64& random) {
  certify::Truth truth = certify::draw_truth(0, random);
  const auto arm =
      simulation::true_impedance(profile.subject, protocol.postures[condition.posture_index].position,
                                 simulation::instruction_named(instruction_of(protocol, condition)));
  truth.arm.M = arm.mass;
  truth.arm.B = arm.damping;
  truth.arm.K = arm.stiffness;
  return truth;
}

/// What the rule needs in all: two looks in a row, within its limits.
double trials_by(const protocol::StopWhen& rule, double needed) {
  const double later = static_cast<double>(rule.looks_in_a_row - 1);
  return std::clamp(std::max(std::ceil(needed), static_cast<double>(rule.trials_least)) + later,
                    static_cast<double>(rule.trials_least), static_cast<double>(rule.trials_most));
}

/// Amplitude that most trials of the session had, m.
double amplitude_of(const store::Session& session, std::uint32_t posture_index) {
  double amplitude = 0.0;
  for (const auto& trial : session.trials) {
    if (!trial.outcome) continue;
    const auto& program = trial.outcome->value.program();
    if (program.posture_index() == posture_index) amplitude = std::max(amplitude, program.amplitude_m());
  }
  return amplitude;
}

}  // namespace

ExpectedTrials expected_by_simulation(const protocol::Protocol& protocol, const protocol::Plan& plan,
                                      const simulation::Profile& profile, std::uint64_t seed) {
  certify::LedDesign led;
  led.setting = setting_of(profile);
  led.rule = *protocol.stop_when;
  led.design.amplitude = protocol.perturbation.amplitude;
  led.design.rise = protocol.perturbation.rise_time;
  if (const auto method = impedance::method_named(led.rule.method)) led.method = *method;
  ExpectedTrials expected{
      fmt::format("{} simulated conditions each, of the profile's subject", kDraws), {}, {}};
  for (std::size_t c = 0; c < plan.conditions.size(); ++c) {
    std::vector<certify::LedCondition> runs(kDraws);
    for_each_in_parallel(kDraws, [&](std::size_t i) {
      std::mt19937_64 random(seed * 1'000'003 + c * kDraws + i);
      runs[i] = certify::simulate_led(truth_of(protocol, plan.conditions[c], profile, random), led, random());
    });
    double trials = 0.0;
    double reached = 0.0;
    for (const auto& run : runs) {
      trials += static_cast<double>(run.trials) / kDraws;
      reached += run.end == protocol::LookEnd::kReached ? 1.0 / kDraws : 0.0;
    }
    expected.trials.push_back(trials);
    expected.reached.push_back(reached);
  }
  return expected;
}

ExpectedTrials expected_from(const protocol::Protocol& protocol, const protocol::Plan& plan,
                             const store::Session& session) {
  const auto& rule = *protocol.stop_when;
  ExpectedTrials expected{
      fmt::format("session {} of {}", to_hex(session.record.session).substr(0, 8), session.record.subject),
      {},
      {}};
  for (const auto& condition : plan.conditions) {
    double needed = kUnknown;
    for (const v1::Estimate& estimate : store::newest_estimates(session)) {
      const bool is_this = estimate.posture() == plan.postures[condition.posture_index].name() &&
                           estimate.method() == rule.method && estimate.model() == "linear" &&
                           estimate.instruction() == instruction_of(protocol, condition);
      if (!is_this) continue;
      const double there = amplitude_of(session, estimate.posture_index());
      const double finer = there > 0.0 ? there / protocol.perturbation.amplitude : 1.0;
      const std::vector looks{protocol::look_at(estimate)};
      needed = protocol::ruling_on(rule, looks).needed * finer * finer;
    }
    expected.trials.push_back(std::isfinite(needed) ? trials_by(rule, needed) : kUnknown);
    expected.reached.push_back(!std::isfinite(needed) ? kUnknown : needed < rule.trials_most ? 1.0 : 0.0);
  }
  return expected;
}

std::string to_text(const ExpectedTrials& expected, const protocol::Protocol& protocol,
                    const protocol::Plan& plan) {
  double seconds = 0.0;
  double trials = 0.0;
  std::string text = fmt::format("\nexpected with stop_when, from {}\n", expected.from);
  auto out = std::back_inserter(text);
  fmt::format_to(out, "{:<14} {:<14} {:>4} {:>8} {:>6} {:>8}\n", "posture", "instruction", "set", "trials",
                 "most", "reached");
  for (std::size_t c = 0; c < plan.conditions.size(); ++c) {
    const auto& condition = plan.conditions[c];
    const bool is_known = std::isfinite(expected.trials[c]);
    const double taken = is_known ? expected.trials[c] : condition.trials;
    double all = 0.0;
    for (const auto& trial : plan.trials) {
      if (plan.blocks[trial.block].condition == c) all += trial.duration;
    }
    seconds += all * taken / condition.trials;
    trials += taken;
    const std::string& instruction = instruction_of(protocol, condition);
    fmt::format_to(out, "{:<14} {:<14} {:>4} {:>8} {:>6} {:>8}\n",
                   plan.postures[condition.posture_index].name(), instruction.empty() ? "-" : instruction,
                   condition.set_number, is_known ? fmt::format("{:.1f}", expected.trials[c]) : "n/a",
                   condition.trials, is_known ? fmt::format("{:.0f} %", 100.0 * expected.reached[c]) : "n/a");
  }
  fmt::format_to(out, "about {:.0f} trials and {:.1f} min; not known counts as the most\n", trials,
                 seconds / 60.0);
  return text;
}

}  // namespace tonus::cli
