#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>

#include "rig_agent/control/sample_record.hpp"
#include "rig_agent/control/servo.hpp"
#include "rig_agent/control/trial_program.hpp"
#include "rig_agent/drivers/driver.hpp"

namespace tonus::control {

/// What one cycle gives the trial machine.
struct CycleInput {
  HandleEstimate handle;      ///< In R.
  bool takes_sample = false;  ///< A sample is taken in this cycle; phases of the protocol begin only in such.
  std::uint64_t sequence = 0;  ///< That sample's number, or the next one's.
  std::int64_t acquisition_ns = 0;
  drivers::RowMark mark = drivers::RowMark::kNone;
};

/// The phases of one trial, and the reference of each (trial_program.hpp). Time is counted in cycles, so that
/// a program runs alike at every speed; the onset falls on the cycle of a sample. Starts, phases and the end
/// of a trial happen in cycles that take a sample; a fault or an abort acts at once.
///
/// The machine knows neither clock nor queue nor driver. All methods are REALTIME.
class TrialMachine {
 public:
  TrialMachine(const ServoGains& gains, double period, bool actuates);

  /// Starts a trial; the caller has made sure that none is running and that the cycle takes a sample.
  void start(const TrialProgram& program, const CycleInput& input) noexcept;

  /// One cycle: the reference for it. After it, finished() says whether a trial ended in this cycle.
  Reference advance(const CycleInput& input) noexcept;

  /// Ends a running trial and goes to kSafe; without a trial, only goes there.
  Reference fail(FaultBits faults) noexcept;
  /// From kSafe to kIdle.
  void recover() noexcept;
  /// Ends the running trial; the handle floats.
  void abort() noexcept { end(TrialOutcome::kAborted, 0); }
  /// Ends a trial whose recording gives no row.
  void miss_recording() noexcept { end(TrialOutcome::kNoRecording, 0); }

  [[nodiscard]] Phase phase() const noexcept { return phase_; }
  [[nodiscard]] bool is_running() const noexcept { return phase_ != Phase::kIdle && phase_ != Phase::kSafe; }
  [[nodiscard]] bool is_onset() const noexcept { return is_onset_; }
  [[nodiscard]] bool is_at_rest() const noexcept { return is_at_rest_; }
  [[nodiscard]] std::uint64_t trial() const noexcept { return is_running() ? program_.number : 0; }
  [[nodiscard]] const std::array<double, 2>& commanded() const noexcept { return commanded_; }  ///< m in S.
  [[nodiscard]] const std::array<double, 2>& bias() const noexcept { return bias_; }            ///< N in S.
  [[nodiscard]] const ShoulderPose& shoulder() const noexcept { return program_.shoulder; }

  /// The onset is shown at the driver's digital output in the cycle of this sample.
  void mark(std::uint64_t sequence) noexcept {
    result_.is_onset_marked = true;
    result_.mark_sequence = sequence;
  }

  /// True once after a trial ended, with what happened.
  bool take_result(TrialResult& result) noexcept;
  /// The loop tells which sample it took, so that a result can name the last one. The last row of a recorded
  /// segment ends its trial here.
  void sampled(std::uint64_t sequence, std::int64_t acquisition_ns) noexcept;

 private:
  void enter(Phase phase) noexcept;
  void end(TrialOutcome outcome, FaultBits faults) noexcept;
  void begin_perturbation(const CycleInput& input) noexcept;
  void begin_return(const CycleInput& input) noexcept;
  void step_phase(const CycleInput& input) noexcept;
  void step_recording(const CycleInput& input) noexcept;
  void count_calm(bool is_calm) noexcept { calm_cycles_ = is_calm ? calm_cycles_ + 1 : 0; }
  [[nodiscard]] Reference reference() noexcept;
  [[nodiscard]] Reference lead(double duration) const noexcept;
  [[nodiscard]] Reference exert(double share_of_bias, ServoMode mode) noexcept;
  [[nodiscard]] bool is_contraction() const noexcept { return program_.kind == TrialKind::kContraction; }
  [[nodiscard]] bool has_bias() const noexcept { return !is_contraction() && !program_.bias.isZero(0.0); }
  [[nodiscard]] Reference hold_still() const noexcept;
  [[nodiscard]] double elapsed() const noexcept { return static_cast<double>(cycles_in_phase_) * period_; }
  [[nodiscard]] bool has_lasted(double duration) const noexcept { return spans(cycles_in_phase_, duration); }
  [[nodiscard]] bool spans(std::uint64_t cycles, double duration) const noexcept;

  const ServoGains gains_;
  const double period_;
  const bool actuates_;
  const double force_filter_;  // Share of the new value in one cycle.

  TrialProgram program_;
  Phase phase_ = Phase::kIdle;
  std::uint64_t cycles_in_phase_ = 0;
  std::uint64_t calm_cycles_ = 0;  // Without a break: at rest on target, or bias within its threshold.
  Eigen::Matrix2d shoulder_to_robot_ = Eigen::Matrix2d::Identity();
  Eigen::Vector2d target_ = Eigen::Vector2d::Zero();      // Posture, m in R.
  Eigen::Vector2d path_start_ = Eigen::Vector2d::Zero();  // Of the minimum-jerk way, m in R.
  Eigen::Vector2d path_end_ = Eigen::Vector2d::Zero();
  Eigen::Vector2d onset_position_ = Eigen::Vector2d::Zero();
  Eigen::Vector2d filtered_force_ = Eigen::Vector2d::Zero();  // N in R.
  std::array<double, 2> commanded_{};
  std::array<double, 2> bias_{};
  bool is_onset_ = false;
  bool is_at_rest_ = false;
  bool is_last_row_ = false;

  TrialResult result_;
  bool has_result_ = false;
  std::uint64_t last_sequence_ = 0;
  std::int64_t last_ns_ = 0;
};

}  // namespace tonus::control
