#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "services/contract/names.hpp"
#include "services/core/clock.hpp"
#include "services/core/id.hpp"
#include "services/core/id_source.hpp"
#include "services/core/result.hpp"
#include "services/protocol/rig_facts.hpp"
#include "services/scheduler/ledger.hpp"
#include "services/scheduler/records.hpp"

#include <idl/archive.h>
#include <idl/estimate.h>
#include <idl/rig.h>
#include <idl/session.h>
#include <idl/trial.h>

namespace tonus::scheduler {

using Message = std::variant<v1::SessionPlan, v1::SessionState, v1::SessionReply, v1::SessionCue,
                             v1::TrialCommand, v1::RigCommand, v1::TrialReview, v1::SessionNote>;

/// What an input brings about, in this order: `urgent` is sent at once, `records` are made durable, then
/// `messages` are sent. If the records cannot be made durable, nothing more may be sent, by this machine or
/// any message after.
struct Effects {
  std::vector<Message> urgent;
  std::vector<Record> records;
  std::vector<Message> messages;
};

/// Waiting times, by the host's clock.
struct Patience {
  std::chrono::milliseconds answer{
      2000};  ///< Beyond a trial's expected duration before its command is repeated.
  std::chrono::milliseconds refusal{500};     ///< Before a refused trial is tried again.
  std::chrono::milliseconds rig_reply{1000};  ///< For the rig to be armed, before it is asked again.
  std::chrono::milliseconds stillness{
      1050};  ///< After the arming; the rig itself refuses in the first second.
  std::chrono::milliseconds abort_repeat{500};  ///< Between two requests to the rig to abort.
  std::chrono::milliseconds estimate{10000};    ///< For an estimate from all trials of its condition.
  std::chrono::milliseconds receipt{30000};     ///< At the end, for the receipts of rejected trials.
  std::chrono::milliseconds rig_silence{2000};  ///< After which the rig's clock is not known any more.
  int resends = 2;                              ///< Repeats of a command before the wait shows in the phase.
  int refusals = 3;                             ///< In a row without a hold, before the operator is asked.
  int abort_repeats = 10;                       ///< Before a session ends without the rig's confirmation.
};

/// One session after the other, as one explicit state machine: PREPARING, READY, RUNNING, PAUSING, PAUSED,
/// WAITING, COMPLETING, then COMPLETED, ABORTED or FAILED. Every input returns what has to be done; the state
/// is published on every change. Pure but for the injected clock; for one thread.
///
/// A trial: the command is recorded, then sent. It counts once a valid verdict and a receipt without missing
/// samples are both in, and is queued again at a random place of its set if the rig did not complete it, the
/// verdict is not valid, or samples are missing for good. A command that brings no answer is repeated: the
/// rig knows a trial by its id, does not run it twice, and publishes its outcome anew. The next trial is
/// chosen only after the last is recorded as settled, so a scheduler that dies anywhere and is restored goes
/// on with what comes next.
///
/// With `stop_when` each trial of a condition, from the fewest on, is followed by a look at the condition's
/// estimate, which is recorded with what was decided; the next trial's direction and drive follow from the
/// records alone.
///
/// WAITING is left by itself when what is missing comes back, or, where it is for the operator, by
/// SESSION_RESUME.
///
/// The rig runs a session's trials only while it is armed for it. It is armed after an operator's START or
/// RESUME, never by itself: a restart of the rig agent or of this program, a hold of the rig and a rig that
/// has disarmed itself each need a RESUME first, and a hold an operator's clear before that. A rig that moves
/// nothing real may state that it goes on unattended.
class SessionMachine {
 public:
  SessionMachine(const Clock& clock, std::string software_version, Patience patience = {},
                 IdSource new_id = random_id);

  /// Takes a journal's records up again. Call once, before any input. kDataLoss where they do not fit
  /// together.
  [[nodiscard]] Result<Effects> restore(const std::vector<Record>& records);

  [[nodiscard]] Effects on_command(const v1::SessionCommand& command);
  [[nodiscard]] Effects on_outcome(const v1::TrialOutcome& outcome);
  [[nodiscard]] Effects on_verdict(const v1::TrialVerdict& verdict);
  [[nodiscard]] Effects on_receipt(const v1::ArchiveReceipt& receipt);
  [[nodiscard]] Effects on_estimate(const v1::Estimate& estimate);
  [[nodiscard]] Effects on_rig_description(const v1::RigDescription& description);
  [[nodiscard]] Effects on_rig_state(const v1::RigState& state);
  [[nodiscard]] Effects on_rig_reply(const v1::RigReply& reply);
  /// `missing` names what is not there of rig, identification and archive; empty: complete.
  [[nodiscard]] Effects on_roster(const std::string& missing);
  [[nodiscard]] Effects on_tick();

  /// When on_tick() has something to do next, if nothing else happens.
  [[nodiscard]] std::optional<Clock::TimePoint> next_deadline() const;

  /// True from a session's start to its end.
  [[nodiscard]] bool is_active() const { return ledger_.has_session() && !ledger_.state().ended; }
  /// As last published; of the last session once it has ended.
  [[nodiscard]] const v1::SessionState& state() const { return published_; }
  [[nodiscard]] const Ledger& ledger() const { return ledger_; }
  /// What the rig is to be told while it is armed for the session, without a number; none: it is not.
  [[nodiscard]] std::optional<v1::RigLease> lease() const;

 private:
  /// What an operator's RESUME acknowledges.
  enum class Asks : std::uint8_t {
    kNobody,
    kLimit,
    kPosture,
    kAxes,
    kAxesMissing,
    kArming,
    kRefusal,
    kStuck
  };
  /// Why no trial is commanded now.
  struct Hold {
    v1::SessionPhase phase = v1::SESSION_WAITING;
    std::string waiting_for;
    Asks asks = Asks::kNobody;
  };

  /// An estimate of a condition's trials.
  struct Seen {
    const v1::Estimate* estimate = nullptr;  ///< nullptr: none has come.
    std::size_t left_out = 0;                ///< Trials that count and are not in it.
  };

  // session_machine.cpp: the course of the session (the inputs: session_inputs.cpp)
  void advance();
  void advance_abort();
  void settle_in_flight();
  void watch_in_flight();
  [[nodiscard]] std::optional<Hold> find_hold();
  [[nodiscard]] std::optional<Hold> hold_for_rig();
  [[nodiscard]] std::optional<Hold> hold_for_arming();
  [[nodiscard]] std::optional<Hold> hold_for_block();
  [[nodiscard]] std::optional<Hold> hold_for_axes(const protocol::Block& block);
  [[nodiscard]] Hold service_hold(const std::string& what) const;
  [[nodiscard]] Hold paused() const;

  // session_looks.cpp: precision-led conditions, and how far conditions are
  /// Of a precision-led protocol, for a person.
  [[nodiscard]] std::string name_of(std::uint32_t condition) const;
  /// The condition whose newest trial has not been followed by a look; none: there is none.
  [[nodiscard]] std::optional<std::uint32_t> condition_to_look_at() const;
  /// Of the trials that count, the newest among them, that which leaves fewest out.
  [[nodiscard]] Seen estimate_of(std::uint32_t condition) const;
  [[nodiscard]] std::optional<Hold> hold_for_look();
  [[nodiscard]] Hold hold_for_estimate(std::uint32_t condition) const;
  void look(std::uint32_t condition, const v1::Estimate* estimate);
  [[nodiscard]] std::size_t trials_at(std::uint32_t condition, const protocol::Drive& drive) const;
  void steer_next(std::uint32_t condition, v1::TrialProgram& program) const;
  [[nodiscard]] v1::ConditionProgress progress_of(std::uint32_t condition) const;
  [[nodiscard]] double precision_of(std::uint32_t condition) const;
  [[nodiscard]] std::uint32_t left_in(std::uint32_t condition) const;
  [[nodiscard]] std::uint32_t expected_left_in(std::uint32_t condition) const;
  /// Where goals were not reached, to follow how many trials were counted; empty: all were, or there are
  /// none.
  [[nodiscard]] std::string goals_missed() const;
  void describe_conditions(v1::SessionState& state) const;
  void command_next();
  void send_in_flight();
  void repeat_in_flight();
  [[nodiscard]] bool is_in_flight(const Id& id) const {
    return ledger_.state().in_flight && id == flight_id_;
  }
  void reject(const std::string& reason, bool can_repeat);
  void end(v1::SessionPhase phase, const std::string& message);
  [[nodiscard]] double outcome_duration() const;
  [[nodiscard]] std::string missing_of_in_flight() const;
  [[nodiscard]] bool runs_on_rig() const;

  // session_requests.cpp: what operators ask
  void start(const v1::SessionCommand& command);
  void pause(const v1::SessionCommand& command);
  void resume(const v1::SessionCommand& command);
  void abort(const v1::SessionCommand& command);
  void acknowledge(const v1::SessionCommand& command);

  // session_reviews.cpp: what operators say of trials and sessions
  void review(const v1::SessionCommand& command);
  void take_note(const v1::SessionCommand& command);
  [[nodiscard]] std::string why_not_reviewed(std::uint32_t attempt) const;
  [[nodiscard]] std::optional<std::uint32_t> attempt_of(const Id& trial) const;
  [[nodiscard]] std::optional<std::int64_t> rig_clock_ns() const;
  [[nodiscard]] bool uses_rejected_trial(const v1::Estimate& estimate) const;
  void publish(const record::Reviewed& reviewed);
  void publish(const record::Noted& noted);

  // session_arming.cpp: the rig's arming
  void authorise();
  void withdraw(const std::string& why);
  void request_arming();
  void note_arming(const v1::RigReply& reply);
  void note_rig_mode(const v1::RigState& state);
  [[nodiscard]] bool is_armed() const { return armed_epoch_.has_value(); }
  [[nodiscard]] bool is_held() const { return rig_state_ && rig_state_->mode() == v1::RIG_HELD; }
  /// What an operator has to do about a held rig.
  [[nodiscard]] std::string clear_then_resume() const;
  void answer(const Id& request_id, bool is_done, const std::string& message);
  void answer_pending(v1::SessionRequest request, bool is_done, const std::string& message);
  void reply(const Id& session_id, const Id& request_id, bool is_done, const std::string& message);
  void send_abort();
  [[nodiscard]] Id abort_id() const;

  // session_messages.cpp: what is published
  void decide(Record record);
  void begin_session();
  void publish_plan();
  void publish_cue(const protocol::Block& block);
  void publish_state();
  [[nodiscard]] Effects finish();
  [[nodiscard]] v1::SessionState described() const;
  [[nodiscard]] std::string where_it_stands() const;

  const Clock& clock_;
  const std::string software_version_;
  const Patience patience_;
  const IdSource new_id_;

  Ledger ledger_;
  Effects effects_;
  std::vector<Message> replies_;          // follow the state that they speak of
  std::deque<record::Answered> refused_;  // answers to requests that belong to no session

  // What is known of the others; not of the session.
  std::optional<protocol::RigFacts> facts_;
  std::string facts_problem_ = "rig: has not described itself";
  std::optional<v1::RigState> rig_state_;
  Clock::TimePoint rig_heard_at_;
  bool resumes_unattended_ = false;  // the rig, which moves nothing real then
  std::string roster_missing_ = "services: nothing is known yet";

  // Of the session, lost with the process and found again.
  v1::SessionPhase phase_ = v1::SESSION_PREPARING;
  std::optional<Hold> hold_;
  std::string message_;
  v1::SessionState published_;
  bool has_published_ = false;
  std::optional<std::pair<std::uint32_t, std::uint32_t>> cued_;  // posture, instruction
  std::map<Id, v1::Estimate> estimates_;
  std::optional<Clock::TimePoint> axes_due_;  // the axes are waited for since before this, less the patience

  std::optional<Clock::TimePoint> look_due_;  // when a condition goes on without its estimate

  Id flight_id_ = kNoId;
  std::optional<v1::TrialOutcome> outcome_;
  std::optional<v1::TrialVerdict> verdict_;
  std::optional<v1::ArchiveReceipt> receipt_;
  Clock::TimePoint resend_at_;
  int resends_ = 0;

  bool accepts_doubtful_axes_ = false;  // at the posture that comes next
  int refusals_ = 0;
  std::string refusal_;
  Clock::TimePoint retry_at_;

  bool may_arm_ = false;   // an operator has said go since whatever withdrew it
  std::string withdrawn_;  // why not, for the operator
  std::optional<std::uint64_t> armed_epoch_;
  std::int64_t armed_at_rig_ns_ = 0;  // rig's clock: states of no later time say nothing of the arming
  Id arm_id_ = kNoId;
  std::optional<Clock::TimePoint> arm_again_at_;  // a request runs, or was refused
  std::string arm_refusal_;
  Clock::TimePoint moves_at_;
  std::optional<Clock::TimePoint> abort_at_;  // next repeat
  int abort_repeats_ = 0;
  std::optional<Clock::TimePoint> complete_until_;
};

}  // namespace tonus::scheduler
