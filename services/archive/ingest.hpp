#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <string>
#include <vector>

#include "services/archive/gap_watch.hpp"
#include "services/archive/store.hpp"
#include "services/core/clock.hpp"

namespace tonus::archive {

/// What a rig says of its stream.
struct RigReport {
  StreamKey stream;
  std::uint64_t next_sequence = 0;     ///< Number that its next sample will get.
  std::uint64_t received_through = 0;  ///< It knows receipts for every sample below this number.
};

/// "Every sample of the stream below `through` is durable."
struct StreamReceipt {
  StreamKey stream;
  Id session{};
  std::uint64_t through = 0;
  Certificate counts;  ///< Of the whole stream so far.
};

/// "Every sample of the trial is durable", or, with missing samples in the certificate, "those will not come
/// any more".
struct TrialReceipt {
  Id trial{};
  Id session{};
  StreamKey stream;
  std::uint64_t through = 0;  ///< One more than the trial's last sample.
  Certificate certificate;
};

struct ResendRequest {
  StreamKey stream;
  SequenceRange range;
};

/// What is to be sent now.
struct Decisions {
  std::vector<TrialReceipt> trial_receipts;
  std::vector<StreamReceipt> stream_receipts;
  std::vector<SessionCertificate> session_receipts;
  std::vector<ResendRequest> resends;
  Clock::TimePoint due =
      Clock::TimePoint::max();  ///< When step() must be called again, if nothing comes before.
};

/// How the archive is doing.
struct IngestStatus {
  std::string failure;              ///< Why the store does not take data; empty: it does.
  std::uint64_t waiting_items = 0;  ///< Blocks and messages that are not durable yet.
  std::uint64_t waiting_bytes = 0;
  std::uint64_t refused_blocks = 0;   ///< For want of room while the store failed; they are asked for again.
  std::uint64_t lost_messages = 0;    ///< For want of room; nobody can send them again.
  std::uint64_t missing_samples = 0;  ///< Known to exist and not here.
  std::uint64_t samples = 0;          ///< Taken since the program's start, and the bytes of their messages.
  std::uint64_t sample_bytes = 0;
};

/// The archive's rules, without bus, thread, file or clock of its own: what is stored together, when it is
/// made durable, which receipts may be given, what has to be asked for again.
///
/// Durability. Everything taken waits in memory and goes into the store in one step: as soon as a finished
/// trial is whole, else `commit_interval` after the oldest item came, else when `commit_bytes` wait. A
/// receipt is given only after the step that made durable what it speaks of. If the store fails, everything
/// stays in memory, no receipt is given, and the step is tried again; beyond `backlog_bytes` blocks are
/// refused, to be asked for later.
///
/// Completeness. A stream is expected to be whole from its origin (0, or where another archive's receipts end
/// when this one first sees the stream) to the largest number that anybody spoke of: a block, an outcome, or
/// the rig's state. What is missing in it is asked for as GapWatch says, once the rig has been heard of. A
/// trial that stays incomplete for `give_up` while its rig is there, with nothing of it coming, gets a
/// receipt that says how many samples are missing; should they come all the same, it gets its whole one.
///
/// A session that has ended gets its certificate, the sums over its trials, with the commit that takes its
/// end, and a new one with each later commit that changes one of its trials.
///
/// For one thread. Time is the injected clock's; no call waits except for the store.
class Ingest {
 public:
  struct Options {
    Clock::Duration commit_interval = std::chrono::milliseconds(200);
    std::size_t commit_bytes = std::size_t{4} << 20U;
    std::size_t backlog_bytes = std::size_t{64} << 20U;
    Clock::Duration retry_interval = std::chrono::milliseconds(500);  ///< Between tries of a failing store.
    Clock::Duration receipt_interval =
        std::chrono::milliseconds(500);  ///< Before a lost receipt is given again.
    Clock::Duration give_up = std::chrono::seconds(10);
    Clock::Duration rig_silence = std::chrono::seconds(2);  ///< After which a rig counts as gone.
    GapWatch::Options gaps;
  };

  Ingest(Store& store, const Clock& clock, const Options& options);
  Ingest(Store& store, const Clock& clock) : Ingest(store, clock, Options{}) {}

  /// Takes up what the store holds. Call once, before anything is taken. The next step() gives the receipts
  /// of the newest session's trials and of every rig's stream once more.
  [[nodiscard]] Result<void> recover();

  void take(Block block);

  /// Stores the message. With `is_state` (last value of its key, given again to who comes late) a repetition
  /// of the newest one of its key is left out. `session` is filled in here.
  void take(Message message, bool is_state);

  /// What messages say that matters here; the messages themselves are taken separately.
  void note_outcome(const TrialRecord& outcome);
  void note_rig(const RigReport& report);
  void note_plan(const SessionRecord& plan);
  void note_session_end(const Id& session, std::uint32_t end);

  /// Does what is due.
  [[nodiscard]] Decisions step();

  /// Stores what waits, for an orderly end; receipts for it are given after the next start. The store's
  /// error.
  [[nodiscard]] Result<void> finish();

  [[nodiscard]] IngestStatus status() const;

 private:
  struct Stream {
    std::uint64_t origin = 0;
    std::uint64_t frontier = 0;  ///< One more than the largest number that is known to exist.
    Coverage received;           ///< Durable or waiting.
    Coverage durable;
    std::uint64_t resent = 0;
    std::uint64_t duplicated = 0;
    bool is_changed = false;  ///< Differs from what the store has.
    bool owes_receipt = false;
    Clock::TimePoint receipt_given;
    GapWatch gaps;
  };
  struct Tally {
    TrialTally counts;
    bool is_changed = false;
  };
  struct PendingTrial {
    TrialRecord record;
    bool is_stored = false;
    bool is_given_up = false;
    std::uint64_t received = 0;        ///< Of its samples, when last looked at.
    Clock::TimePoint unchanged_since;  ///< That number, with its rig there.
  };

  struct EndedSession {
    std::uint32_t end = 0;  ///< v1::SessionPhase
    bool is_certified = false;
  };

  Stream& stream_of(const StreamKey& key);
  void hear_of(const StreamKey& key);
  void count_for_trial(const Block& block, std::uint64_t fresh);
  void hold(std::size_t bytes);
  [[nodiscard]] bool is_whole(const TrialRecord& trial) const;
  [[nodiscard]] bool has_whole_trial() const;
  void commit(Clock::TimePoint now, Decisions& decisions);
  void certify(TrialRecord& trial) const;
  [[nodiscard]] bool has_uncertified_end() const;
  [[nodiscard]] Result<void> fill_batch();
  [[nodiscard]] Result<SessionCertificate> certify(const Id& session, std::uint32_t end) const;
  void give_up_trials(Clock::TimePoint now, Decisions& decisions);
  [[nodiscard]] bool is_there(const Id& rig, Clock::TimePoint now) const;
  void give_stream_receipts(Clock::TimePoint now, Decisions& decisions);
  void ask_for_missing(Clock::TimePoint now, Decisions& decisions);
  [[nodiscard]] Clock::TimePoint commit_due() const;
  [[nodiscard]] static TrialReceipt receipt_of(const TrialRecord& trial);

  Store& store_;
  const Clock& clock_;
  Options options_;

  std::map<StreamKey, Stream> streams_;
  std::map<Id, Clock::TimePoint> heard_rigs_;  ///< Since this program's start; when last.
  std::map<Id, Tally> tallies_;
  std::map<Id, PendingTrial> pending_;  ///< Outcomes without certificate.
  std::deque<Id> closed_;               ///< Trials certified last: late repetitions count for them no more.
  std::map<std::pair<std::string, Id>, std::pair<std::uint32_t, std::uint64_t>>
      newest_;  ///< Checksum and bytes.
  std::map<Id, EndedSession> ended_;
  std::vector<TrialReceipt> owed_;  ///< Receipts to be given again.
  std::vector<SessionCertificate> owed_sessions_;
  SessionRecord session_;  ///< The newest plan's.

  Batch batch_;
  std::size_t waiting_bytes_ = 0;
  Clock::TimePoint waiting_since_;
  Clock::TimePoint retry_at_;
  std::string failure_;
  std::uint64_t refused_blocks_ = 0;
  std::uint64_t lost_messages_ = 0;
  std::uint64_t samples_ = 0;
  std::uint64_t sample_bytes_ = 0;
};

}  // namespace tonus::archive
