#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "rig_agent/drivers/comedi_config.hpp"
#include "rig_agent/drivers/driver.hpp"

struct comedi_t_struct;

namespace tonus::drivers {

/// A data acquisition card through Debian's libcomedi: encoders on counters, the force sensor on analogue
/// inputs, motor torques on analogue outputs, the emergency stop on a digital input, auxiliary channels on
/// further analogue inputs, one value a cycle at most. An auxiliary input that fails gives no value.
///
/// Counters wrap; the driver unwraps them, so that a joint may be anywhere as long as it moves by less than
/// half of the counter's range in a cycle. Volts are linear between the ends of the channel's range. Torque
/// beyond what the range can say is clipped. inactive and destruction leave 0 V on the outputs. Stamps are
/// CLOCK_MONOTONIC, taken before the channels are read, one after the other. A call that fails in read() is
/// kDisconnected. Each realtime call is a system call of Comedi a channel.
class Comedi final : public Driver {
 public:
  /// The geometry is that of the rig's profile: the card does not know it.
  /// Nor what the auxiliary channels measure: each of them has an input of its name in the wiring.
  Comedi(const ComediConfig& config, const RigGeometry& geometry,
         std::vector<AuxiliaryChannel> auxiliary = {});
  ~Comedi() override;

  /// Opens the card and checks that every channel is there. kUnavailable: no such device, or not permitted.
  Result<void> configure(double period) override;
  Result<void> activate() override;
  void deactivate() noexcept override;
  [[nodiscard]] Capabilities capabilities() const noexcept override {
    return {.can_disable = true, .marks_onset = config_.onset.has_value()};
  }
  [[nodiscard]] const RigGeometry& geometry() const noexcept override { return geometry_; }
  DriverStatus read(Reading& reading) noexcept override;
  DriverStatus write(const Eigen::Vector2d& torque) noexcept override;
  void heartbeat(bool level) noexcept override;
  bool set_onset(bool is_on) noexcept override;
  [[nodiscard]] std::span<const AuxiliaryChannel> auxiliary_channels() const noexcept override {
    return auxiliary_;
  }
  void read_auxiliary(std::span<const std::uint32_t> counts, std::span<float> values) noexcept override;
  bool disable() noexcept override { return disable(config_); }

  /// Opens the card by itself, takes the enable away where there is one, and writes 0 V to the motors. True:
  /// the card has taken all of it. From any thread or process.
  [[nodiscard]] static bool disable(const ComediConfig& config) noexcept;

 private:
  struct Close {
    void operator()(comedi_t_struct* card) const noexcept;
  };
  /// An analogue channel's numbers: 0 is `low` V, `largest` is `high` V.
  struct Scale {
    double low = 0.0;
    double high = 0.0;
    std::uint32_t largest = 0;
  };
  struct Counter {
    std::uint32_t largest = 0;
    std::uint32_t last = 0;
    std::int64_t count = 0;
    bool has_last = false;
  };

  [[nodiscard]] Error refuse(const char* what, const ComediChannel& channel) const;
  [[nodiscard]] Result<void> check(const char* what, const ComediChannel& channel, int type) const;
  [[nodiscard]] Result<Scale> scale_of(const char* what, const ComediChannel& channel) const;
  [[nodiscard]] Result<void> set_up_counter(const ComediChannel& channel, std::uint32_t largest) const;
  [[nodiscard]] Result<void> set_up_channels();
  [[nodiscard]] Result<void> set_up_auxiliary(double period);
  [[nodiscard]] bool write_line(const std::optional<ComediChannel>& line, bool is_high) noexcept;
  [[nodiscard]] bool read_counter(std::size_t i, double& count) noexcept;
  [[nodiscard]] bool read_volts(const ComediChannel& channel, const Scale& scale, double& volts) noexcept;
  [[nodiscard]] bool write_volts(std::size_t i, double volts) noexcept;

  const ComediConfig config_;
  const std::vector<AuxiliaryChannel> auxiliary_;
  RigGeometry geometry_;
  std::unique_ptr<comedi_t_struct, Close> card_;
  std::array<Counter, 2> counters_;
  std::array<Scale, 2> inputs_;
  std::array<Scale, 2> outputs_;
  struct Input {
    ComediChannel channel;
    Scale scale;
  };
  std::vector<Input> auxiliary_inputs_;  // one for each of auxiliary_
  bool is_configured_ = false;
  bool is_active_ = false;
  std::int64_t last_ns_ = 0;
};

}  // namespace tonus::drivers
