#pragma once

#include <Eigen/Core>
#include <array>
#include <atomic>
#include <memory>

#include "rig_agent/drivers/driver.hpp"
#include "services/simulation/plant.hpp"
#include "services/simulation/profile.hpp"

namespace tonus::drivers {

/// A rig that is computed: simulation::Plant with encoders and force sensor. Its clock is its own, begins at
/// 0 and advances by one period with every write(). begin_trial() seats the subject at the new shoulder pose.
/// Auxiliary channels are the subject's muscles and the onset's digital output, by the names of
/// simulation::auxiliary_sources().
/// Deterministic: the same profile and the same writes give the same readings, to the bit.
class Simulated final : public Driver {
 public:
  explicit Simulated(const simulation::Profile& profile);

  Result<void> configure(double period) override;
  Result<void> activate() override;
  void deactivate() noexcept override;
  [[nodiscard]] Capabilities capabilities() const noexcept override {
    return {.actuates = true,
            .has_own_clock = true,
            .moves_nothing_real = true,
            .can_disable = true,
            .marks_onset = true};
  }
  [[nodiscard]] const RigGeometry& geometry() const noexcept override { return geometry_; }
  [[nodiscard]] std::span<const AuxiliaryChannel> auxiliary_channels() const noexcept override {
    return profile_.auxiliary;
  }
  void read_auxiliary(std::span<const std::uint32_t> counts, std::span<float> values) noexcept override;
  /// A lamp that the subject sees: he contracts when it goes on in a contraction.
  bool set_onset(bool is_on) noexcept override;
  DriverStatus read(Reading& reading) noexcept override;
  DriverStatus write(const Eigen::Vector2d& torque) noexcept override;
  void begin_trial(const TrialNotice& notice) noexcept override;
  bool disable() noexcept override {
    is_disabled_.store(true, std::memory_order_relaxed);
    return true;
  }

  /// For faults on purpose: what the next readings show instead of the plant. Zero by default. Same thread as
  /// read().
  struct Disturbance {
    bool is_disconnected = false;
    bool is_emergency_stop_pressed = false;
    std::array<double, 2> encoder_offset{};  ///< Counts.
    std::array<double, 2> force_offset_V{};  ///< V, before clipping.
  };
  void disturb(const Disturbance& disturbance) noexcept { disturbance_ = disturbance; }

  /// What is true behind the sensors; from configure() on.
  [[nodiscard]] const simulation::Plant& plant() const noexcept { return *plant_; }

 private:
  const simulation::Profile profile_;
  const RigGeometry geometry_;
  std::unique_ptr<simulation::Plant> plant_;
  Disturbance disturbance_;
  Eigen::Vector2d torque_ = Eigen::Vector2d::Zero();  // As last written, N m.
  TrialNotice seat_;                                  // Of the last trial.
  bool is_seated_ = false;
  bool is_active_ = false;
  std::atomic<bool> is_disabled_{false};  // A sign by itself: it orders nothing else.
};

}  // namespace tonus::drivers
