#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>

#include "rig_agent/control/instruction_name.hpp"
#include "services/core/result.hpp"
#include "services/mechanics/auxiliary_channel.hpp"
#include "services/mechanics/rig_geometry.hpp"

namespace tonus::drivers {

/// What one realtime call of a driver came to. No data is normal for a recording between its segments; for a
/// driver that actuates, anything but kOk in a running loop is a fault.
enum class DriverStatus : std::uint8_t {
  kOk,            ///< Done.
  kNoData,        ///< Nothing to give in this cycle; the output is untouched.
  kDisconnected,  ///< A sensor or the card does not answer.
  kFailed,        ///< The device refused; the driver stays in its state and may be tried again.
};

/// What a recording says about one of its own rows. Hardware always says kNone.
enum class RowMark : std::uint8_t {
  kNone,
  kOnset,  ///< This row is the onset of the recorded perturbation.
  kLast,   ///< This row is the last of its segment.
};

/// One cycle's input.
struct Reading {
  RawSample raw;
  bool is_emergency_stop_pressed = false;
  RowMark mark = RowMark::kNone;
  std::array<double, 2> recorded_command{};  ///< Of a recording, m in S; not finite: not known.
};

/// Told to the driver in the cycle in which a trial starts: where the subject's shoulder now stands, where
/// the hand is to be (m, in S), and for a recording which of its segments to play.
struct TrialNotice {
  ShoulderPose shoulder;
  Eigen::Vector2d posture = Eigen::Vector2d::Zero();
  std::uint32_t segment = 0;
  control::InstructionName instruction{};  ///< What the subject is told; a real one reads it on his page.
  bool is_contraction = false;             ///< The handle is to be held while the subject contracts.
};

/// What kind of device stands behind the interface; constant after configure().
struct Capabilities {
  bool actuates = true;  ///< false: write() is accepted and has no effect, the loop only acquires.
  bool has_force_sensor = true;
  /// true: time is the driver's own and advances by one period per cycle however fast it is called.
  bool has_own_clock = false;
  /// The driver's own statement: whatever it is told, nobody can be moved.
  bool moves_nothing_real = false;
  /// disable() can drop the torque, whatever this program's other threads do.
  bool can_disable = false;
  /// s without a write after which the device itself drops the torque; 0: it does not.
  double own_watchdog = 0.0;
  /// set_onset() moves a digital output that other recorders can see.
  bool marks_onset = false;
};

/// A rig's hardware, as the realtime loop sees it. The loop never asks which driver it has.
///
///     unconfigured --configure--> inactive --activate--> active --deactivate--> inactive
///
/// - unconfigured: geometry() is meaningless, read() and write() give kFailed.
/// - inactive: geometry() and capabilities() are final, the motors are without torque, read() and write()
/// give
///   kFailed. configure() may be called again.
/// - active: one read() and then one write() every period. acquisition_ns increases from read to read,
///   on one clock, which goes on where it was when the driver is activated again. Torque stays as last
///   written until the next write; deactivate() sets it to zero.
/// - A call that the state does not allow fails and changes nothing. deactivate() is allowed in every state.
///
/// Torques are in N m at the joints, counter-clockwise positive, beyond the motors' limit clipped by the
/// device. Threads: configure, activate, deactivate from one thread while no other thread is in read or
/// write. Methods marked REALTIME allocate nothing, take no lock, do not throw, and return within a small
/// part of the period.
class Driver {
 public:
  virtual ~Driver() = default;
  Driver() = default;
  Driver(const Driver&) = delete;
  Driver& operator=(const Driver&) = delete;

  /// Takes the period of the loop, s. Reserves everything that the active state needs.
  virtual Result<void> configure(double period) = 0;
  virtual Result<void> activate() = 0;
  virtual void deactivate() noexcept = 0;

  [[nodiscard]] virtual Capabilities capabilities() const noexcept = 0;
  [[nodiscard]] virtual const RigGeometry& geometry() const noexcept = 0;
  /// What the device measures beside force and motion. Final after configure().
  [[nodiscard]] virtual std::span<const AuxiliaryChannel> auxiliary_channels() const noexcept { return {}; }

  /// REALTIME. Fills the reading when kOk, leaves it alone otherwise.
  virtual DriverStatus read(Reading& reading) noexcept = 0;
  /// REALTIME. Joint torques (N m) for the period that begins. A value that is not finite gives kFailed and
  /// zero torque.
  virtual DriverStatus write(const Eigen::Vector2d& torque) noexcept = 0;
  /// REALTIME. Called between read and write of the cycle in which a trial starts. Hardware has nothing to
  /// do.
  virtual void begin_trial(const TrialNotice& /*notice*/) noexcept {}
  /// REALTIME. Once a cycle after write(), with a level that alternates: for a circuit that takes the enable
  /// away when the line stands still.
  virtual void heartbeat(bool /*level*/) noexcept {}
  /// REALTIME. True in the cycle in which a perturbation begins, false when it is over: for other recorders.
  /// False: there is no output, or the device has not taken it.
  virtual bool set_onset(bool /*is_on*/) noexcept { return false; }
  /// REALTIME. Once a cycle after write(), where there are auxiliary channels and the read() was kOk: for
  /// each channel in turn the newest counts[i] values up to that read, in the order of time. `values` comes
  /// with NaN in every place; what was not measured is left so.
  virtual void read_auxiliary(std::span<const std::uint32_t> /*counts*/,
                              std::span<float> /*values*/) noexcept {}

  /// Drops the torque by a way of its own and keeps it down until the next activate(). From any thread, also
  /// while another one hangs in read() or write(). False: it cannot, or the device has not confirmed it.
  virtual bool disable() noexcept { return false; }
};

}  // namespace tonus::drivers
