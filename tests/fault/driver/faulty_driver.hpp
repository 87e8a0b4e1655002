#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <random>
#include <string>

#include "rig_agent/drivers/simulated.hpp"

namespace tonus::testing {

/// What may be wrong with a device. Each begins at one moment and stays.
enum class DeviceFault : std::uint8_t {
  kReadingFrozen,    ///< The same reading again and again, its stamp too.
  kEncoderFrozen,    ///< One joint's count stays.
  kEncoderDead,      ///< One joint's count is zero.
  kEncoderReversed,  ///< One joint counts the other way.
  kEncoderNoisy,     ///< One joint's count is off by up to `size` times 60 counts, at random.
  kEncoderJumping,   ///< One joint's count jumps by `size` times 400 counts, to and fro.
  kForceFrozen,      ///< One channel's volts stay.
  kForceDead,        ///< Both channels are at 0 V.
  kForceReversed,    ///< One channel has the other sign.
  kForceNoisy,       ///< One channel is off by up to `size` times 15 V, at random.
  kForceJumping,     ///< One channel jumps by `size` times 20 V, to and fro.
  kNotFinite,        ///< A value is NaN or infinite.
  kDisconnected,     ///< read() says so.
  kWriteFails,       ///< write() says so; the torque stays as it was until the device is disabled.
  kSlow              ///< Every cycle takes three periods.
};
inline constexpr int kDeviceFaults = 15;

[[nodiscard]] const char* name_of(DeviceFault fault);

/// A simulated rig whose device is faulty from begin() on.
class FaultyDriver final : public drivers::Driver {
 public:
  explicit FaultyDriver(const simulation::Profile& profile, std::uint64_t seed)
      : rig_(profile), random_(seed) {}

  void begin(DeviceFault fault, std::size_t axis, double size) {
    fault_ = fault;
    axis_ = axis;
    size_ = size;
    is_faulty_ = true;
    at_begin_ = last_;
  }
  /// Periods that the present cycle takes beyond its own.
  [[nodiscard]] unsigned missed_periods() const { return is_faulty_ && fault_ == DeviceFault::kSlow ? 2 : 0; }
  [[nodiscard]] const simulation::Plant& plant() const { return rig_.plant(); }
  [[nodiscard]] const Eigen::Vector2d& torque() const { return torque_; }  ///< At the motors now, N m.

  Result<void> configure(double period) override { return rig_.configure(period); }
  Result<void> activate() override { return rig_.activate(); }
  void deactivate() noexcept override { rig_.deactivate(); }
  [[nodiscard]] drivers::Capabilities capabilities() const noexcept override { return rig_.capabilities(); }
  [[nodiscard]] const RigGeometry& geometry() const noexcept override { return rig_.geometry(); }
  void begin_trial(const drivers::TrialNotice& notice) noexcept override { rig_.begin_trial(notice); }
  drivers::DriverStatus read(drivers::Reading& reading) noexcept override;
  drivers::DriverStatus write(const Eigen::Vector2d& torque) noexcept override;
  bool disable() noexcept override {
    is_disabled_ = true;
    return true;
  }

 private:
  void corrupt(drivers::Reading& reading) noexcept;
  [[nodiscard]] double noise() noexcept { return std::uniform_real_distribution<>(-1.0, 1.0)(random_); }

  drivers::Simulated rig_;
  std::mt19937_64 random_;
  bool is_faulty_ = false;
  bool is_disabled_ = false;
  DeviceFault fault_ = DeviceFault::kReadingFrozen;
  std::size_t axis_ = 0;
  double size_ = 1.0;
  std::uint64_t cycles_ = 0;
  drivers::Reading last_;
  drivers::Reading at_begin_;
  Eigen::Vector2d torque_ = Eigen::Vector2d::Zero();
};

}  // namespace tonus::testing
