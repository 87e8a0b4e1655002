#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <string_view>
#include <toml++/toml.h>
#include <vector>

#include "rig_agent/calibration/fit.hpp"
#include "services/core/result.hpp"
#include "services/mechanics/rig_geometry.hpp"

namespace tonus::calibration {

/// Who did a step of the calibration, and when.
struct Signature {
  std::string at;  ///< ISO 8601.
  std::string by;
};

/// The rig at rest, over some time.
struct RestReading {
  std::array<double, 2> encoder_count{};  ///< Mean.
  Eigen::Vector2d volts = Eigen::Vector2d::Zero();
  Eigen::Vector2d volts_deviation = Eigen::Vector2d::Zero();  ///< Standard deviation of one sample.
  std::size_t samples = 0;
};

/// A reading under known weights.
struct LoadReading {
  Eigen::Vector2d load = Eigen::Vector2d::Zero();  ///< N, pull on the handle, in R.
  Eigen::Vector2d volts = Eigen::Vector2d::Zero();
  double sensor_angle = 0.0;  ///< rad, of the sensor's x axis in R.

  /// What the sensor felt: the handle holds the weight with the opposite force.
  [[nodiscard]] KnownForce known_force() const;
};

/// A check of a known spring.
struct SpringCheck {
  SpringFit fit;
  std::size_t steps = 0;
  double measured = 0.0;  ///< N/m, along the direction or the mean of all.
  double nominal = 0.0;   ///< N/m.
  std::string direction;  ///< "12.5 deg", or "all".

  [[nodiscard]] double deviation_percent() const { return 100.0 * (measured / nominal - 1.0); }
};

/// A rig's calibration: the steps with their readings, and the constants that are in force. A file of TOML in
/// the rig's folder; the agent publishes its text with the rig's description. Each step replaces the one of
/// its kind before.
class Calibration {
 public:
  static constexpr std::size_t kMostLoads = 10;
  static constexpr std::size_t kLongestName = 32;  ///< Of a signature, bytes.

  explicit Calibration(std::string driver) : driver_(std::move(driver)) {}

  /// An absent file is an empty calibration. Refuses one of another driver, and values that are none.
  [[nodiscard]] static Result<Calibration> load(const std::filesystem::path& file, const std::string& driver);
  [[nodiscard]] static Result<Calibration> parse(std::string_view text, const std::string& source,
                                                 const std::string& driver);
  [[nodiscard]] Result<void> save(const std::filesystem::path& file) const;
  [[nodiscard]] std::string text() const;  ///< Empty where no step was done.

  /// Offset of the force sensor at no load.
  void set_tare(const RestReading& reading, const Signature& signature);
  /// Zero counts, from the handle at a known place (m in R).
  void set_zero(const RestReading& reading, const Eigen::Vector2d& place, const std::array<double, 2>& zero,
                const Signature& signature);
  /// Refuses more than kMostLoads: the text goes into a message.
  [[nodiscard]] Result<void> add_load(const LoadReading& reading, const Signature& signature);
  void forget_loads();
  [[nodiscard]] std::vector<LoadReading> loads() const;
  /// Matrix and offset, from the loads.
  void set_force(const ForceFit& fit, const Signature& signature);
  void set_spring(const SpringCheck& check, const Signature& signature);

  /// A driver's geometry with the constants that are in force here.
  [[nodiscard]] RigGeometry applied_to(const RigGeometry& geometry) const;

  [[nodiscard]] std::string at() const;  ///< Of the newest step; empty where none was done.
  [[nodiscard]] std::string by() const;

 private:
  [[nodiscard]] Result<void> check(const std::string& source) const;
  toml::table& step(std::string_view name, const Signature& signature);
  toml::table& in_force();

  std::string driver_;
  toml::table document_;
};

}  // namespace tonus::calibration
