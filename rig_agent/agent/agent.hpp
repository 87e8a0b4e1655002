#pragma once

#include <deque>
#include <memory>
#include <optional>
#include <set>
#include <vector>

#include "rig_agent/agent/hold_latch.hpp"
#include "rig_agent/agent/lease.hpp"
#include "rig_agent/agent/publisher.hpp"
#include "rig_agent/agent/recorded_trials.hpp"
#include "rig_agent/agent/spool.hpp"
#include "rig_agent/agent/stop_requests.hpp"
#include "rig_agent/agent/trial_log.hpp"
#include "rig_agent/agent/wire.hpp"
#include "rig_agent/control/rig_loop.hpp"
#include "services/bus/bus.hpp"
#include "services/bus/typed.hpp"
#include "services/core/clock.hpp"

#include <idl/archive.h>
#include <idl/rig.h>
#include <idl/trial.h>

namespace tonus::rig {

/// Ends of the agent on the bus, apart from the samples.
struct AgentEndpoints {
  bus::TypedReader<v1::TrialCommand> trial_commands;
  bus::TypedReader<v1::RigCommand> rig_commands;
  bus::TypedReader<v1::ArchiveReceipt> receipts;
  bus::TypedReader<v1::ArchiveResend> resends;
  bus::TypedWriter<v1::TrialOutcome> outcomes;
  bus::TypedWriter<v1::RigReply> replies;
  bus::TypedWriter<v1::RigDescription> description;
  bus::TypedWriter<v1::RigState> state;

  [[nodiscard]] static Result<AgentEndpoints> create(bus::Bus& bus,
                                                     const std::shared_ptr<bus::Notifier>& notifier);
};

struct AgentOptions {
  RigNames names;
  std::uint64_t epoch = 0;
  bool is_paced = true;  ///< false: the agent itself steps the loop, as fast as its samples are taken.
  /// Frees the rig by itself after anything but an emergency stop. For drivers that move nothing real.
  bool resumes_unattended = false;
  /// Nothing moves for so long after the rig was armed; a clock that is simulated at full speed does not
  /// wait.
  Clock::Duration stillness = std::chrono::seconds(1);
  /// Longest time without a cycle of a paced loop; then the driver is disabled from this thread.
  Clock::Duration longest_cycle = std::chrono::milliseconds(100);
};

/// What the agent works with; all of it outlives the agent.
struct AgentParts {
  control::RigLoop& loop;
  drivers::Driver& driver;             ///< The loop's; of it only what may be called from any thread.
  RecordedTrials* recorded = nullptr;  ///< Of a replayed dataset.
  Publisher& publisher;
  Spool& spool;
  TrialLog& log;
  HoldLatch& latch;
  Lease& lease;
  StopRequests& stops;
};

/// Everything of the rig that is not realtime: takes commands from the bus, starts trials in the loop, spools
/// and publishes what the loop measured, reports how trials ended, and sends again what somebody misses.
///
/// The rig is free, armed for a session, in a trial, or held. A trial is begun only while the rig is armed
/// for its session, that is after a scheduler's request that follows an operator's start or resume, and goes
/// on only while that scheduler is heard. A fault, a stop and the loss of the scheduler hold the rig: on
/// disk, until an operator clears the hold. Clearing arms nothing.
///
/// A trial is run at most once: its id is looked up in the log first, and an outcome that is known, also a
/// refusal, is published again instead. A trial that an earlier run of the agent left unfinished is reported
/// as TRIAL_BROKEN_OFF at the start, and samples that nobody has receipted are sent again until somebody
/// does.
///
/// One thread calls step(). The loop runs in a thread of its own if it is paced; else step() advances it
/// while a trial runs, and for two seconds after a stop, an abort or a clear: between trials the simulated
/// clock stands still.
class Agent {
 public:
  Agent(const AgentOptions& options, const AgentParts& parts, AgentEndpoints endpoints, const Clock& clock);

  /// Publishes the description and what earlier runs left. Call once, before the first step().
  void start(const v1::RigDescription& description);

  /// Handles all there is; returns when to call again at the latest.
  Clock::TimePoint step();

  /// Empty when a trial could be begun now and its samples have a reader, else why not.
  [[nodiscard]] std::string why_not_ready() const;
  [[nodiscard]] std::string activity() const;

  /// Holds the rig: for what only the program sees, as another agent of the same name.
  void hold(const std::string& because, bool needs_operator);
  /// Replies that were left out because their reader did not take them.
  [[nodiscard]] std::uint64_t replies_dropped() const { return replies_dropped_; }

 private:
  struct RunningTrial {
    v1::TrialCommand command;
    std::uint64_t number = 0;
  };
  struct PendingReply {
    std::uint64_t request = 0;               ///< To the loop; 0: none, it waits for another's.
    std::optional<v1::RigReply> reply = {};  ///< None: the agent asks the loop for itself.
    bool is_emergency_stop = false;          ///< Answered when the loop shows the fault.
    bool is_start = false;                   ///< Of a trial.
    std::uint32_t clears_hold = 0;           ///< Number of the hold that ends if the loop clears its faults.
  };

  /// Why no trial may be begun, whoever reads its samples: a fault, or a disk that does not keep what
  /// happens. Empty: one may.
  [[nodiscard]] std::string why_no_trial() const;
  /// Keeps the reason of a write that failed: no trial is begun until the log could be written anew.
  void note_logged(const Result<void>& logged);
  void repair_log_if_due();
  void report_broken(const BrokenTrial& broken);
  void end_trial(const v1::TrialOutcome& outcome);

  // agent.cpp: trials, samples, and what is published
  void take_trial_commands();
  void begin(const v1::TrialCommand& command);
  void refuse(const v1::TrialCommand& command, const std::string& why);

  // agent_requests.cpp: what is asked of the rig, and what holds it
  void take_rig_commands();
  [[nodiscard]] bool has_too_many_pending() const;
  void carry_out(const v1::RigCommand& command);
  void stop(PendingReply pending, const std::string& requested_by);
  void clear_fault(const v1::RigCommand& command, PendingReply pending);
  void arm(const v1::RigCommand& command, PendingReply pending);
  void post(control::CommandKind kind, PendingReply pending);
  /// Why `session` may not arm the rig; empty: it may.
  [[nodiscard]] std::string why_not_armed(const v1::RigCommand& command) const;
  /// The latch alone: for what the loop has stopped at already.
  void latch(const std::string& because, bool needs_operator);
  void watch_hold();
  void watch_lease();
  void watch_cycles();
  /// An order to clear the hold in force is with the loop.
  [[nodiscard]] bool is_being_cleared() const;
  [[nodiscard]] Result<void> clear_latch(std::uint32_t hold);
  void answer_clears(std::uint32_t hold, const Result<void>& cleared);
  [[nodiscard]] v1::RigMode mode() const;
  [[nodiscard]] bool is_emergency_stopped() const;
  void take_receipts();
  void take_resends();
  void resend_left_behind();
  /// Where the loop is not paced: a fraction of a trial, so that it sees what it was told.
  void advance_simulated_clock();
  void collect_replies();
  void answer(PendingReply& pending, bool is_done, const std::string& message);
  void send_reply(const v1::RigReply& reply);
  void collect_samples();
  void collect_results();
  [[nodiscard]] v1::TrialOutcome outcome_of(const v1::TrialCommand& command, std::uint64_t epoch,
                                            v1::TrialEnd end) const;
  void publish_outcome(const v1::TrialOutcome& outcome);
  void publish_state_if_due();

  AgentOptions options_;
  control::RigLoop& loop_;
  drivers::Driver& driver_;
  RecordedTrials* recorded_;
  Publisher& publisher_;
  Spool& spool_;
  TrialLog& log_;
  HoldLatch& latch_;
  Lease& lease_;
  StopRequests& stops_;
  AgentEndpoints endpoints_;
  const Clock& clock_;

  std::vector<float> auxiliary_;  // of the sample at hand
  std::optional<RunningTrial> running_;
  std::vector<PendingReply> pending_replies_;
  std::deque<v1::RigReply> answered_;  // the last ones, for requests that are repeated
  std::uint64_t replies_dropped_ = 0;
  control::FaultBits noted_faults_ = 0;  // in the latch's reason
  Clock::TimePoint lease_heard_;         // last time that the loop was told of
  Clock::TimePoint unattended_due_;
  std::uint64_t cycle_ = 0;  // as last seen
  Clock::TimePoint cycle_at_;
  bool stands_still_ = false;
  std::uint64_t last_number_ = 0;
  std::uint64_t last_request_ = 0;
  std::uint64_t received_through_ = 0;
  std::uint64_t receipts_refused_ = 0;
  std::set<Id> unlogged_;  // ended trials whose outcome the log does not have yet: nobody is told
  std::string log_error_;  // empty: the log holds everything that it was given
  Clock::TimePoint log_repair_due_;
  std::optional<v1::RigState> published_state_;
  Clock::TimePoint state_due_;
  Clock::TimePoint left_behind_due_;
};

}  // namespace tonus::rig
