#pragma once

#include <functional>
#include <memory>
#include <utility>

#include "rig_agent/drivers/driver.hpp"

namespace tonus::drivers {

/// Another driver whose geometry is corrected by what a calibration found; all else is that driver's.
class Calibrated final : public Driver {
 public:
  using Correction = std::function<RigGeometry(const RigGeometry&)>;

  Calibrated(std::unique_ptr<Driver> driver, Correction correction)
      : driver_(std::move(driver)), correction_(std::move(correction)) {}

  Result<void> configure(double period) override {
    auto configured = driver_->configure(period);
    if (configured) geometry_ = correction_(driver_->geometry());
    return configured;
  }
  Result<void> activate() override { return driver_->activate(); }
  void deactivate() noexcept override { driver_->deactivate(); }
  [[nodiscard]] Capabilities capabilities() const noexcept override { return driver_->capabilities(); }
  [[nodiscard]] const RigGeometry& geometry() const noexcept override { return geometry_; }
  DriverStatus read(Reading& reading) noexcept override { return driver_->read(reading); }
  DriverStatus write(const Eigen::Vector2d& torque) noexcept override { return driver_->write(torque); }
  void begin_trial(const TrialNotice& notice) noexcept override { driver_->begin_trial(notice); }
  void heartbeat(bool level) noexcept override { driver_->heartbeat(level); }
  bool set_onset(bool is_on) noexcept override { return driver_->set_onset(is_on); }
  [[nodiscard]] std::span<const AuxiliaryChannel> auxiliary_channels() const noexcept override {
    return driver_->auxiliary_channels();
  }
  void read_auxiliary(std::span<const std::uint32_t> counts, std::span<float> values) noexcept override {
    driver_->read_auxiliary(counts, values);
  }
  bool disable() noexcept override { return driver_->disable(); }

 private:
  const std::unique_ptr<Driver> driver_;
  const Correction correction_;
  RigGeometry geometry_;
};

}  // namespace tonus::drivers
