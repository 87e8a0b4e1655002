#pragma once

#include <filesystem>
#include <memory>
#include <string>

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
  [[nodiscard]] Capabilities capabilities() const noexcept override { return {true, true, has_own_clock_}; }
  [[nodiscard]] const RigGeometry& geometry() const noexcept override { return geometry_; }
  DriverStatus read(Reading& reading) noexcept override;
  DriverStatus write(const Eigen::Vector2d& torque) noexcept override;
  void begin_trial(const TrialNotice& notice) noexcept override;

 private:
  struct Close {
    void operator()(void* handle) const noexcept;
  };
  using Handle = std::unique_ptr<void, Close>;

  Library(Handle handle, const tonus_driver_v1_table& table, void* rig, std::string name)
      : handle_(std::move(handle)), table_(table), rig_(rig), name_(std::move(name)) {}

  const Handle handle_;
  const tonus_driver_v1_table table_;
  void* const rig_;
  const std::string name_;
  RigGeometry geometry_;
  bool has_own_clock_ = false;
  bool is_configured_ = false;
  bool is_active_ = false;
  bool has_stamp_ = false;
  std::int64_t last_ns_ = 0;
};

}  // namespace tonus::drivers
