#include "services/simulation/misconduct.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace tonus::simulation {

void Misconduct::begin_trial() noexcept {
  ++trial_;
  time_ = 0.0;
  moved_at_ = -1.0;
  pushes_ = is_chosen(effect_.pushes_early);
  drifts_ = is_chosen(effect_.drifts_off);
  lets_go_ = is_chosen(effect_.lets_go);
  tenses_ = is_chosen(effect_.tenses);
}

Misconduct::Act Misconduct::begin_period(double hand_speed) noexcept {
  Act act;
  const double since = time_ - effect_.after;
  time_ += period_;
  if (since < 0.0) return act;
  if (pushes_) {
    const double phase = 2.0 * std::numbers::pi * since / effect_.push_period;
    act.force = effect_.push * std::sin(phase) * Eigen::Vector2d::UnitX();
  }
  if (drifts_) {
    const double share = 0.5 - 0.5 * std::cos(std::numbers::pi * std::min(1.0, since / effect_.drift_time));
    act.offset = share * effect_.drift * Eigen::Vector2d::UnitY();
  }
  if (tenses_) act.tension = effect_.tension;
  if (lets_go_) {
    if (moved_at_ < 0.0 && hand_speed > effect_.grip_speed) moved_at_ = time_;
    act.is_holding = moved_at_ < 0.0 || time_ < moved_at_ + effect_.grip_latency;
  }
  return act;
}

bool Misconduct::is_chosen(const std::vector<std::uint64_t>& trials) const noexcept {
  return effect_.is_on && std::find(trials.begin(), trials.end(), trial_) != trials.end();
}

}  // namespace tonus::simulation
