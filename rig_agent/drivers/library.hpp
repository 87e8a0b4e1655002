#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "rig_agent/drivers/driver.hpp"
#include "rig_agent/drivers/tonus_driver.h"

namespace tonus::drivers {

/// A driver out of a shared library with the C entry point of tonus_driver.h. What can be promised for any
/// library is promised here: calls out of state fail without reaching it, a torque that is not finite becomes
/// zero torque and kFailed, a stamp that does not increase is kFailed.
class Library final : public Driver {
 public:
  /// Loads the library and creates its rig. kNotFound: no such file; kInvalidArgument: not a driver, of
  /// another version, or it refuses its options. The message names the file.
  [[nodiscard]] static Result<std::unique_ptr<Library>> load(const std::filesystem::path& file,
                                                             const std::string& options);
  ~Library() override;

  Result<void> configure(double period) override;
  Result<void> activate() override;
  void deactivate() noexcept override;
  [[nodiscard]] Capabilities capabilities() const noexcept override {
    return {.has_own_clock = has_own_clock_,
            .moves_nothing_real = safety_.moves_nothing_real != 0,
            .can_disable = extra_.disable != nullptr,
            .own_watchdog = 1e-3 * safety_.watchdog_ms,
            .marks_onset = extra_.set_onset != nullptr};
  }
  [[nodiscard]] const RigGeometry& geometry() const noexcept override { return geometry_; }
  DriverStatus read(Reading& reading) noexcept override;
  DriverStatus write(const Eigen::Vector2d& torque) noexcept override;
  void begin_trial(const TrialNotice& notice) noexcept override;
  void heartbeat(bool level) noexcept override;
  bool set_onset(bool is_on) noexcept override;
  [[nodiscard]] std::span<const AuxiliaryChannel> auxiliary_channels() const noexcept override {
    return auxiliary_;
  }
  void read_auxiliary(std::span<const std::uint32_t> counts, std::span<float> values) noexcept override;

  /// What the rig's file says of the library's channels, by name, in place of what the library says: type,
  /// unit and scale, which depend on what is connected. Before configure(), which refuses a name that the
  /// library does not have, and another rate than its own.
  void state_auxiliary(std::vector<AuxiliaryChannel> channels) { stated_ = std::move(channels); }
  bool disable() noexcept override;

  /// The library's disable() for a process that uses nothing else of it; the library stays loaded. The errors
  /// of load(), and kInvalidArgument where it is of version 1.
  [[nodiscard]] static Result<std::function<int(const char*)>> load_disable(
      const std::filesystem::path& file);

 private:
  struct Close {
    void operator()(void* handle) const noexcept;
  };
  using Handle = std::unique_ptr<void, Close>;

  struct Tables {
    Handle handle;
    tonus_driver_v1_table base;
    tonus_driver_v2_table extra;  ///< All null in version 1.
  };
  [[nodiscard]] static Result<Tables> open(const std::filesystem::path& file);

  [[nodiscard]] Result<void> describe_auxiliary();

  Library(Tables tables, void* rig, std::string name, std::string options)
      : handle_(std::move(tables.handle)),
        table_(tables.base),
        extra_(tables.extra),
        rig_(rig),
        name_(std::move(name)),
        options_(std::move(options)) {}

  const Handle handle_;
  const tonus_driver_v1_table table_;
  const tonus_driver_v2_table extra_;
  void* const rig_;
  const std::string name_;
  const std::string options_;
  tonus_driver_safety safety_{};
  RigGeometry geometry_;
  std::vector<AuxiliaryChannel> stated_;
  std::vector<AuxiliaryChannel> auxiliary_;
  bool has_own_clock_ = false;
  bool is_configured_ = false;
  bool is_active_ = false;
  bool has_stamp_ = false;
  std::int64_t last_ns_ = 0;
};

}  // namespace tonus::drivers
