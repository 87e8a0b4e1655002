#pragma once

#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "services/core/clock.hpp"
#include "services/scheduler/session_machine.hpp"

namespace tonus::scheduler::testing {

/// A protocol of 2 postures, 2 sets, 2 directions: 8 trials. `extra` goes before the first table.
[[nodiscard]] std::string small_protocol(const std::string& extra = "");
/// One posture; set one without bias, then along +major and -minor; 2 directions: 6 trials.
[[nodiscard]] std::string small_loaded_protocol();

[[nodiscard]] v1::RigDescription description_of_rig();

/// What becomes of a trial in the lab.
struct Fate {
  v1::TrialEnd end = v1::TRIAL_COMPLETED;
  std::string detail = {};
  bool is_valid = true;
  v1::VerdictReason reason = v1::REASON_OFF_TARGET;  ///< Where it is not valid.
  std::uint64_t missing_samples = 0;
  bool has_outcome = true;  ///< False: that message is never sent.
  bool has_verdict = true;
  bool has_receipt = true;
};

/// A scheduler's peers, scripted: a rig that runs each trial id once and publishes a known one's outcome
/// anew, an identification and an archive that answer every outcome. What they have published they also give
/// to a late reader.
class Lab {
 public:
  using Script = std::function<Fate(const v1::TrialProgram&)>;

  explicit Lab(Script script = [](const v1::TrialProgram&) { return Fate{}; }) : script_(std::move(script)) {}

  /// The peers of another lab as they are now, and a scheduler that has not begun.
  Lab(const Lab& peers, std::vector<Record> kept)
      : records(std::move(kept)), runs(peers.runs), script_(peers.script_), published_(peers.published_) {}

  /// A new scheduler, without memory. The peers and the records stay.
  void restart_machine();
  [[nodiscard]] SessionMachine& machine() { return *machine_; }
  [[nodiscard]] ManualClock& clock() { return clock_; }

  /// Describes the rig, completes the roster.
  void connect();
  /// Gives the machine an input's effects: keeps records and messages, lets the peers answer commands.
  void take(Effects effects);
  /// Keeps the records of the effects but loses the messages: a scheduler killed between the two.
  void take_records_only(const Effects& effects);
  /// Hands the oldest of the peers' messages to the machine; false if there is none.
  bool step();
  /// Steps until nothing is left to do.
  void run();
  /// Steps until `done`, at most 10000 times; false if nothing is left to do before.
  bool run_until(const std::function<bool()>& done);
  /// Like run, but where nothing is left the clock goes on to the machine's next deadline, until the session
  /// ends.
  bool run_to_end();

  /// Rejects attempt `attempt` by hand.
  void reject(std::uint32_t attempt, const std::string& request_name, const std::string& text = "coughed");
  void note(const std::string& text, const std::string& request_name, const std::string& kind = "note",
            std::uint32_t attempt = 0);
  void command(v1::SessionRequest request, const std::string& request_name, const std::string& protocol = "");
  void tick(std::chrono::milliseconds duration);
  [[nodiscard]] v1::SessionPhase phase() const { return machine_->state().phase(); }
  [[nodiscard]] const LedgerState& ledger() const { return machine_->ledger().state(); }
  [[nodiscard]] const v1::SessionReply* reply_to(const std::string& request_name) const;

  void set_script(Script script) { script_ = std::move(script); }
  void post(std::function<Effects(SessionMachine&)> input) { inputs_.push_back(std::move(input)); }
  void give_rig_state(v1::RigMode mode, std::uint64_t epoch = 1, std::int64_t clock_ns = 0,
                      const std::string& fault = "");

  static const Id kSession;

  std::vector<Record> records;
  std::vector<std::vector<Record>> frames;
  std::vector<v1::SessionState> states;
  std::vector<v1::SessionReply> replies;
  std::vector<v1::SessionCue> cues;
  std::vector<v1::SessionPlan> plans;
  std::vector<v1::TrialReview> reviews;
  std::vector<v1::SessionNote> notes;
  std::vector<v1::TrialCommand> trial_commands;
  std::vector<v1::RigCommand> rig_commands;
  std::map<Id, int> runs;  ///< How often the rig ran each trial id.
  bool rig_answers_aborts = true;
  bool has_rig_state = false;           ///< True: connect() leaves it to the test.
  bool is_attended = false;             ///< True: the rig waits for its operator after a restart or a hold.
  std::vector<v1::RigCommand> armings;  ///< To arm and disarm; the others are rig_commands.
  bool is_mute = false;                 ///< The peers do not answer.
  /// Asked before the effects are taken; true loses this process (see take()).
  std::function<bool(const Effects&)> kills;
  bool was_killed = false;

 private:
  struct Published {
    v1::TrialOutcome outcome;
    v1::TrialVerdict verdict;
    v1::ArchiveReceipt receipt;
    Fate fate;
  };
  void receive(const Message& message);
  void run_trial(const v1::TrialCommand& command);
  void publish(const Published& published, bool is_late);

  Script script_;
  ManualClock clock_;
  std::unique_ptr<SessionMachine> machine_ = std::make_unique<SessionMachine>(clock_, "test");
  std::deque<std::function<Effects(SessionMachine&)>> inputs_;
  std::deque<v1::RigReply> armed_;
  std::map<Id, Published> published_;
};

/// Planned trials that a journal's records count, with how often each.
[[nodiscard]] std::map<std::uint32_t, int> counted_trials(const std::vector<Record>& records);

}  // namespace tonus::scheduler::testing
