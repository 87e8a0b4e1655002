#pragma once

#include <Eigen/Core>
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "rig_agent/control/auxiliary_collector.hpp"
#include "rig_agent/control/fault.hpp"
#include "rig_agent/control/flight_recorder.hpp"
#include "rig_agent/control/pulse.hpp"
#include "rig_agent/control/safety_limits.hpp"
#include "rig_agent/control/safety_monitor.hpp"
#include "rig_agent/control/sample_record.hpp"
#include "rig_agent/control/seqlock.hpp"
#include "rig_agent/control/servo.hpp"
#include "rig_agent/control/servo_gains.hpp"
#include "rig_agent/control/spsc_queue.hpp"
#include "rig_agent/control/trial_machine.hpp"
#include "rig_agent/control/trial_program.hpp"
#include "rig_agent/drivers/driver.hpp"
#include "services/core/result.hpp"
#include "services/mechanics/two_link_dynamics.hpp"

namespace tonus::control {

/// Constants of one run of the loop; validated by RigLoop::create().
struct LoopConfig {
  double rate = 1000.0;         ///< Hz, up to 4000.
  unsigned sample_divider = 5;  ///< A sample is taken in every n-th cycle: 200 Hz by default.
  SafetyLimits limits;
  ServoGains gains;
  ManipulandumModel model;
  std::size_t sample_capacity = 8192;  ///< Samples that may wait for the publishing thread.
};

/// What an operator or the agent asks of the loop.
enum class CommandKind : std::uint8_t {
  kStartTrial,
  kAbort,        ///< Ends the running trial; the handle floats.
  kClearFaults,  ///< Back from the safe state, when every cause is gone and the handle is at rest.
};

struct Command {
  std::uint64_t request = 0;  ///< Echoed in the reply.
  CommandKind kind = CommandKind::kAbort;
  TrialProgram program;  ///< Of kStartTrial: see validate() in validation.hpp, which the sender calls first.
};

/// The loop's answer, given in the cycle in which the command took effect or was refused.
enum class CommandResult : std::uint8_t {
  kDone,
  kBusy,            ///< A trial is running.
  kFaultLatched,    ///< In the safe state; clear the faults first.
  kCauseRemains,    ///< A fault's cause is still there; nothing was cleared.
  kNothingRunning,  ///< No trial to abort, no fault to clear.
};

struct CommandReply {
  std::uint64_t request = 0;
  CommandResult result = CommandResult::kDone;
  FaultBits remaining = 0;  ///< Of kCauseRemains: which; all that are latched while the handle still moves.
};

/// What the loop is doing, as of its last sample; a consistent set.
struct LoopState {
  std::uint64_t cycle = 0;          ///< Cycles since the start.
  std::uint64_t next_sequence = 0;  ///< Samples taken since the start.
  std::uint64_t trial = 0;          ///< Running trial, 0 if none.
  std::int64_t acquisition_ns = 0;
  Phase phase = Phase::kIdle;
  FaultBits faults = 0;               ///< Latched.
  std::uint64_t missed_periods = 0;   ///< Since the start.
  std::uint64_t samples_dropped = 0;  ///< Because the sample queue was full.
  std::uint64_t answers_dropped = 0;  ///< Replies and results, because nobody took them.
  std::array<double, 2> position{};   ///< p_SE, m.
  std::array<double, 2> force{};      ///< On the arm, N in S.
};

/// The realtime loop over one driver: read, convert, check, trial machine, control law, limit, write, record.
///
/// Threads: step() belongs to one thread, the loop's. The other methods may be called from one other thread
/// while it runs, emergency_stop() and keep_alive() from any thread and from a signal handler. step() and
/// what it calls allocate nothing, lock nothing and call nothing of the system but through the driver.
class RigLoop {
 public:
  /// Commands that may wait for the loop; as many answers find room, so that none is lost while no more are
  /// asked.
  static constexpr std::size_t kCommandCapacity = 16;

  /// The driver must be active, configured for the period 1/rate, and outlive the loop. Refuses a config that
  /// validate() refuses.
  [[nodiscard]] static Result<std::unique_ptr<RigLoop>> create(drivers::Driver& driver,
                                                               const LoopConfig& config);

  /// REALTIME. One cycle. `now_ns` is the clock by which the command time-out counts (steady clock; with a
  /// driver that has its own clock, whatever the caller wants to count by); `missed_periods` as the pacer
  /// reports it. False when there was nothing to do (a recording between its segments).
  bool step(std::int64_t now_ns, unsigned missed_periods = 0) noexcept;

  /// False when the command queue is full. The reply comes through next_reply().
  [[nodiscard]] bool post(const Command& command) noexcept { return commands_.try_push(command); }
  bool next_reply(CommandReply& reply) noexcept { return replies_.try_pop(reply); }
  /// `auxiliary` gets the values that go with the sample (AuxiliaryCollector); as long as
  /// auxiliary_values(), or empty where nobody wants them.
  bool next_sample(SampleRecord& sample, std::span<float> auxiliary = {}) noexcept {
    return samples_.try_pop(sample, auxiliary);
  }
  /// The result of a trial comes after its last sample is in the queue of samples.
  bool next_result(TrialResult& result) noexcept { return results_.try_pop(result); }

  void emergency_stop() noexcept { emergency_stop_.store(true, std::memory_order_relaxed); }
  /// To the safe state with Fault::kHeld, by the next cycle. From any thread.
  void hold() noexcept { hold_.store(true, std::memory_order_relaxed); }
  /// What a watchdog looks at; null: there is none. Before the first step(). The loop counts its cycles
  /// there, and goes to the safe state when the watchdog has dropped the torque.
  void set_pulse(Pulse* pulse) noexcept { pulse_ = pulse; }
  /// Somebody who may command is there. Without it, a running trial ends after SafetyLimits::command_timeout.
  void keep_alive() noexcept { keep_alive_.fetch_add(1, std::memory_order_relaxed); }

  [[nodiscard]] LoopState state() const noexcept { return state_.load(); }
  [[nodiscard]] std::size_t samples_waiting() const noexcept { return samples_.size(); }
  /// Values of the auxiliary channels with each sample.
  [[nodiscard]] std::size_t auxiliary_values() const noexcept { return samples_.row(); }
  [[nodiscard]] std::size_t sample_capacity() const noexcept { return samples_.capacity(); }
  /// Frozen by the first fault; recording goes on once the record has been read and no fault is latched.
  [[nodiscard]] const FlightRecorder& flight_recorder() const noexcept { return recorder_; }
  void set_flight_record_read(std::uint32_t number) noexcept { recorder_.set_read(number); }
  [[nodiscard]] const LoopConfig& config() const noexcept { return config_; }
  [[nodiscard]] double period() const noexcept { return period_; }

 private:
  RigLoop(drivers::Driver& driver, const LoopConfig& config);

  [[nodiscard]] Surroundings surroundings(std::int64_t now_ns, unsigned missed_periods) noexcept;
  [[nodiscard]] CycleInput convert(drivers::DriverStatus status, const drivers::Reading& reading) noexcept;
  [[nodiscard]] Eigen::Vector2d control(const Reference& reference) noexcept;
  bool wait_for_recording(const Surroundings& around) noexcept;

  void check_handle(const drivers::Reading& reading, CycleInput& input) noexcept;
  void write(const Eigen::Vector2d& torque) noexcept;
  void show_onset() noexcept;
  void take_commands(const CycleInput& input, bool may_start) noexcept;
  [[nodiscard]] CommandReply carry_out(const Command& command, const CycleInput& input) noexcept;
  [[nodiscard]] CommandReply clear_faults(std::uint64_t request) noexcept;

  void take_sample(const drivers::Reading& reading, const CycleInput& input) noexcept;
  void record_cycle(const drivers::Reading& reading, const Reference& reference,
                    const Eigen::Vector2d& torque, const Surroundings& around) noexcept;
  void publish(const CycleInput& input) noexcept;

  drivers::Driver& driver_;
  const RigGeometry geometry_;
  const LoopConfig config_;
  const double period_;
  const bool actuates_;
  const bool keeps_its_own_time_;

  SafetyMonitor monitor_;
  Servo servo_;
  TrialMachine trial_;
  FlightRecorder recorder_;
  AuxiliaryCollector auxiliary_;

  SpscQueue<Command> commands_;
  Command next_command_;  // Taken from the queue, and waiting for a sample if it has_next_command_.
  bool has_next_command_ = false;
  SpscQueue<CommandReply> replies_;
  SpscQueue<SampleRecord> samples_;
  SpscQueue<TrialResult> results_;
  Seqlock<LoopState> state_;
  std::atomic<bool> emergency_stop_{false};
  std::atomic<bool> hold_{false};
  Pulse* pulse_ = nullptr;
  bool is_onset_shown_ = false;
  std::atomic<std::uint64_t> keep_alive_{0};

  std::uint64_t cycle_ = 0;
  std::uint64_t sequence_ = 0;
  std::uint64_t missed_periods_ = 0;
  bool missed_since_sample_ = false;
  EndpointSample last_endpoint_;  // Of the last sample, in S.
};

}  // namespace tonus::control
