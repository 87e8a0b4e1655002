#include "tests/fault/driver/faulty_driver.hpp"

#include <algorithm>
#include <cmath>

namespace tonus::testing {

using drivers::DriverStatus;

const char* name_of(DeviceFault fault) {
  switch (fault) {
    case DeviceFault::kReadingFrozen:
      return "reading frozen";
    case DeviceFault::kEncoderFrozen:
      return "encoder frozen";
    case DeviceFault::kEncoderDead:
      return "encoder dead";
    case DeviceFault::kEncoderReversed:
      return "encoder reversed";
    case DeviceFault::kEncoderNoisy:
      return "encoder noisy";
    case DeviceFault::kEncoderJumping:
      return "encoder jumping";
    case DeviceFault::kForceFrozen:
      return "force frozen";
    case DeviceFault::kForceDead:
      return "force dead";
    case DeviceFault::kForceReversed:
      return "force reversed";
    case DeviceFault::kForceNoisy:
      return "force noisy";
    case DeviceFault::kForceJumping:
      return "force jumping";
    case DeviceFault::kNotFinite:
      return "not finite";
    case DeviceFault::kDisconnected:
      return "disconnected";
    case DeviceFault::kWriteFails:
      return "write fails";
    case DeviceFault::kSlow:
      return "slow";
  }
  return "unknown";
}

DriverStatus FaultyDriver::read(drivers::Reading& reading) noexcept {
  const DriverStatus status = rig_.read(reading);
  if (status != DriverStatus::kOk) return status;
  last_ = reading;
  if (!is_faulty_) return status;
  if (fault_ == DeviceFault::kDisconnected) return DriverStatus::kDisconnected;
  corrupt(reading);
  return status;
}

void FaultyDriver::corrupt(drivers::Reading& reading) noexcept {
  auto& count = reading.raw.encoder_count[axis_];
  auto& volts = reading.raw.force_V[axis_];
  const double count_at_begin = at_begin_.raw.encoder_count[axis_];
  const bool is_up = (++cycles_ / 50) % 2 == 0;
  switch (fault_) {
    case DeviceFault::kReadingFrozen:
      reading = at_begin_;
      break;
    case DeviceFault::kEncoderFrozen:
      count = count_at_begin;
      break;
    case DeviceFault::kEncoderDead:
      count = 0.0;
      break;
    case DeviceFault::kEncoderReversed:
      count = 2.0 * count_at_begin - count;
      break;
    case DeviceFault::kEncoderNoisy:
      count = std::round(count + 60.0 * size_ * noise());
      break;
    case DeviceFault::kEncoderJumping:
      if (is_up) count = std::round(count + 400.0 * size_);
      break;
    case DeviceFault::kForceFrozen:
      volts = at_begin_.raw.force_V[axis_];
      break;
    case DeviceFault::kForceDead:
      reading.raw.force_V = {};
      break;
    case DeviceFault::kForceReversed:
      volts = -volts;
      break;
    case DeviceFault::kForceNoisy:
      volts = std::clamp(volts + 15.0 * size_ * noise(), -10.0, 10.0);
      break;
    case DeviceFault::kForceJumping:
      if (is_up) volts = std::clamp(volts + 20.0 * size_, -10.0, 10.0);
      break;
    case DeviceFault::kNotFinite:
      (size_ > 0.5 ? count : volts) =
          size_ > 0.25 && size_ < 0.75 ? std::numeric_limits<double>::infinity() : std::nan("");
      break;
    case DeviceFault::kDisconnected:
    case DeviceFault::kWriteFails:
    case DeviceFault::kSlow:
      break;
  }
}

DriverStatus FaultyDriver::write(const Eigen::Vector2d& torque) noexcept {
  const bool fails = is_faulty_ && fault_ == DeviceFault::kWriteFails;
  if (!fails) torque_ = torque;
  if (is_disabled_) torque_.setZero();
  DriverStatus status = rig_.write(torque_);
  // While a cycle takes longer, its torque stays.
  for (unsigned i = 0; i < missed_periods(); ++i) status = rig_.write(torque_);
  return fails ? DriverStatus::kFailed : status;
}

}  // namespace tonus::testing
