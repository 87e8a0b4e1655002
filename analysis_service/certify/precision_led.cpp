#include "analysis_service/certify/precision_led.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "analysis_service/impedance/refined_identification.hpp"
#include "services/protocol/directions.hpp"

namespace tonus::certify {
namespace {

constexpr int kDirections = 8;

double width_of(const impedance::AxisMatrix& low, const impedance::AxisMatrix& high,
                const impedance::AxisMatrix& value) {
  if (value.size() == 0) return std::numeric_limits<double>::quiet_NaN();
  return 0.5 * (high - low).cwiseAbs().maxCoeff() / value.cwiseAbs().maxCoeff();
}

bool is_of_linearity(impedance::FitTest test) {
  using impedance::FitTest;
  return test == FitTest::kBands || test == FitTest::kReflex || test == FitTest::kHardening ||
         test == FitTest::kFriction || test == FitTest::kPosition;
}

impedance::Options options_of(const LedDesign& led) {
  impedance::Options options;
  options.method = led.method;
  options.window = led.design.window;
  options.has_trace = false;
  return options;
}

}  // namespace

protocol::Look look_at(const impedance::Estimate& estimate, std::size_t trials) {
  protocol::Look look;
  look.trials = trials;
  look.stiffness = width_of(estimate.low.K, estimate.high.K, estimate.value.K);
  look.mass = width_of(estimate.low.M, estimate.high.M, estimate.value.M);
  look.damping = width_of(estimate.low.B, estimate.high.B, estimate.value.B);
  look.is_ok = estimate.status == impedance::Status::kOk;
  look.is_linear =
      estimate.status != impedance::Status::kUndetermined &&
      std::none_of(estimate.checks.begin(), estimate.checks.end(), [](const impedance::FitCheck& check) {
        return !check.is_passed && is_of_linearity(check.test);
      });
  return look;
}

LedCondition simulate_led(const Truth& truth, const LedDesign& led, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  const protocol::Drive own{led.design.amplitude, led.design.rise};
  const auto& rule = led.rule;
  protocol::Drive drive = own;
  if (led.starts_at_limits)
    drive = {std::max(own.amplitude, rule.amplitude_most), std::min(own.rise_time, rule.rise_least)};
  LedCondition condition;
  condition.least_entropy = std::numeric_limits<double>::infinity();
  std::vector<impedance::Trial> trials;
  std::vector<protocol::Look> looks;
  std::vector<int> counts(kDirections, 0);
  std::size_t at_drive = 0;
  while (condition.end == protocol::LookEnd::kGoesOn) {
    const auto number = static_cast<std::uint32_t>(trials.size() + 1);
    const auto chances = protocol::direction_chances(counts, rule.entropy);
    const double bits = protocol::entropy_of(chances);
    condition.entropy += bits;
    condition.least_entropy = std::min(condition.least_entropy, bits);
    protocol::Draws draws(seed, number);
    const std::size_t direction = protocol::draw_by(chances, draws);
    ++counts[direction];
    Design design = led.design;
    design.amplitude = drive.amplitude;
    design.rise = drive.rise_time;
    trials.push_back(simulate_trial(truth, design, led.setting,
                                    target_of(design, static_cast<int>(direction)), number, random));
    ++at_drive;
    condition.drive = drive;
    if (trials.size() < static_cast<std::size_t>(rule.trials_least)) continue;
    auto estimate = impedance::identify(trials, options_of(led));
    if (estimate) {
      impedance::widen_by_process(trials, options_of(led), *estimate);
      condition.estimate = std::move(*estimate);
    }
    looks.push_back(look_at(condition.estimate, trials.size()));
    condition.end = protocol::ruling_on(rule, looks).end;
    const protocol::Drive next = protocol::next_drive(rule, own, drive, at_drive, looks);
    if (next.amplitude != drive.amplitude) at_drive = 0;
    drive = next;
  }
  condition.trials = trials.size();
  condition.look = looks.back();
  condition.entropy /= static_cast<double>(trials.size());
  return condition;
}

}  // namespace tonus::certify
