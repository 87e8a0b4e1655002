#include "rig_agent/drivers/simulated.hpp"

#include <algorithm>
#include <spdlog/fmt/fmt.h>

namespace tonus::drivers {

Simulated::Simulated(const simulation::Profile& profile)
    : profile_(profile), geometry_(simulation::rig_geometry(profile)) {}

Result<void> Simulated::configure(double period) {
  if (is_active_)
    return fail(ErrorCode::kUnavailable,
                "simulated: configure() while active is not allowed; expected an inactive driver");
  if (!(period >= 1e-5 && period <= 0.02)) {
    return fail(ErrorCode::kInvalidArgument,
                fmt::format("simulated: period: {} s is not allowed; expected 0.00001 s to 0.02 s", period));
  }
  TONUS_TRY(simulation::validate_auxiliary(profile_.auxiliary));
  plant_ = std::make_unique<simulation::Plant>(profile_, period);
  return {};
}

Result<void> Simulated::activate() {
  if (!plant_) return fail(ErrorCode::kUnavailable, "simulated: activate() before configure()");
  is_active_ = true;
  is_disabled_.store(false, std::memory_order_relaxed);
  return {};
}

void Simulated::deactivate() noexcept {
  is_active_ = false;
  torque_.setZero();
}

DriverStatus Simulated::read(Reading& reading) noexcept {
  if (!is_active_) return DriverStatus::kFailed;
  if (disturbance_.is_disconnected) return DriverStatus::kDisconnected;
  reading = Reading{};
  reading.raw = plant_->measure();
  reading.is_emergency_stop_pressed = disturbance_.is_emergency_stop_pressed;
  const double clip = geometry_.force_saturation_V;
  for (std::size_t i = 0; i < 2; ++i) {
    reading.raw.encoder_count[i] += disturbance_.encoder_offset[i];
    reading.raw.force_V[i] = std::clamp(reading.raw.force_V[i] + disturbance_.force_offset_V[i], -clip, clip);
  }
  return DriverStatus::kOk;
}

DriverStatus Simulated::write(const Eigen::Vector2d& torque) noexcept {
  if (!is_active_) return DriverStatus::kFailed;
  const bool is_good = torque.allFinite() && !is_disabled_.load(std::memory_order_relaxed);
  torque_ = is_good ? torque : Eigen::Vector2d::Zero();
  plant_->step(torque_);
  return is_good ? DriverStatus::kOk : DriverStatus::kFailed;
}

void Simulated::read_auxiliary(std::span<const std::uint32_t> counts, std::span<float> values) noexcept {
  if (is_active_) plant_->measure_auxiliary(counts, values);
}

bool Simulated::set_onset(bool is_on) noexcept {
  if (is_active_) plant_->show_onset(is_on);
  return is_active_;
}

// A subject who stays seated goes on with the motion of the trial before.
void Simulated::begin_trial(const TrialNotice& notice) noexcept {
  if (!is_active_) return;
  const bool is_same = is_seated_ && notice.posture == seat_.posture &&
                       notice.shoulder.angle == seat_.shoulder.angle &&
                       notice.shoulder.origin == seat_.shoulder.origin;
  if (!is_same) plant_->seat(notice.shoulder, notice.posture);
  plant_->begin_trial(simulation::instruction_named(notice.instruction.c_str()), notice.is_contraction);
  seat_ = notice;
  is_seated_ = true;
}

}  // namespace tonus::drivers
