#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "services/archive/gap_watch.hpp"
#include "services/archive/session_certificates.hpp"
#include "services/core/clock.hpp"
#include "services/store/store.hpp"

namespace tonus::archive {

/// What a rig says of its stream.
struct RigReport {
  store::StreamKey stream;
  std::uint64_t next_sequence = 0;     ///< Number that its next sample will get.
  std::uint64_t received_through = 0;  ///< It knows receipts for every sample below this number.
};

/// "Every sample of the stream below `through` is durable."
struct StreamReceipt {
  store::StreamKey stream;
  Id session{};
  std::uint64_t through = 0;
  store::Certificate counts;  ///< Of the whole stream so far.
};

/// "Every sample of the trial is durable", or, with missing samples in the certificate, "those are lost".
struct TrialReceipt {
  Id trial{};
  Id session{};
  store::StreamKey stream;
  std::uint64_t through = 0;  ///< One more than the trial's last sample.
  store::Certificate certificate;
};

struct ResendRequest {
  store::StreamKey stream;
  store::SequenceRange range;
};

/// What has to be sent now.
struct Decisions {
  std::vector<TrialReceipt> trial_receipts;
  std::vector<StreamReceipt> stream_receipts;
  std::vector<store::SessionCertificate> session_receipts;
  std::vector<ResendRequest> resends;
  Clock::TimePoint due =
      Clock::TimePoint::max();  ///< When step() must be called again, if nothing comes before.
};

/// How the archive is doing.
struct IngestStatus {
  std::string failure;              ///< Why the store does not take data; empty: it does.
  std::uint64_t waiting_items = 0;  ///< Blocks and messages that are not durable yet.
  std::uint64_t waiting_bytes = 0;
  std::uint64_t refused_blocks = 0;   ///< No room while the store failed; they are requested again.
  std::uint64_t lost_messages = 0;    ///< No room; they cannot be requested again.
  std::uint64_t missing_samples = 0;  ///< Known to exist, and not received.
  std::uint64_t samples = 0;          ///< Taken since the program's start, and the bytes of their messages.
  std::uint64_t sample_bytes = 0;
};

/// The archive's rules, without bus, thread, file or clock of its own: what is stored together, when it is
/// made durable, which receipts may be given, what has to be requested again.
///
/// Durability. Everything taken waits in memory and goes into the store in one step: as soon as a finished
/// trial is whole, else `commit_interval` after the oldest item came, else when `commit_bytes` wait. A
/// receipt is given only after the step that made durable what it speaks of. If the store fails, everything
/// stays in memory, no receipt is given, and the step is tried again; beyond `backlog_bytes` blocks are
/// refused, to be requested later.
///
/// Trust. Nothing that a message says makes a receipt: a receipt covers what this archive stores, from the
/// stream's origin on, and there is none while nothing is stored there. The origin follows a rig's word that
/// it has receipts of another archive (its samples may be gone); such a word is withdrawn by any later one of
/// the same rig that knows of fewer receipts, and no receipt is given until it has stood for `claim_stands`.
/// A message belongs to the session that it names, where that one has a plan, else to the newest plan's; a
/// plan that starts later than tomorrow is kept and becomes nobody's newest.
///
/// Completeness. A stream is expected to be whole from its origin (0, or where another archive's receipts
/// end) to the largest number that anybody spoke of: a block, an outcome, or the rig's state. What is missing
/// in it is requested as GapWatch says, once the rig has been heard from. A trial that stays incomplete for
/// `give_up` while its rig is present and sends nothing of it gets a receipt that says how many samples are
/// missing; should they come all the same, it gets a complete one.
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
    Clock::Duration rig_silence = std::chrono::seconds(2);   ///< After which a rig counts as gone.
    Clock::Duration claim_stands = std::chrono::seconds(3);  ///< See "Trust" above.
    GapWatch::Options gaps;
  };

  Ingest(store::Store& store, const Clock& clock, const Options& options);
  Ingest(store::Store& store, const Clock& clock) : Ingest(store, clock, Options{}) {}

  /// Resumes from what the store holds. Call once, before anything is taken. The next step() repeats the
  /// receipts of the newest session's trials and of every rig's stream.
  [[nodiscard]] Result<void> recover();

  void take(store::Block block);

  /// Stores the message. With `is_state` (the last value of its key, which late joiners are given again) a
  /// repetition of the newest one of its key is left out. `session` is what the message names, or none.
  void take(store::Message message, bool is_state);

  /// What messages say that matters here; the messages themselves are taken separately.
  void note_outcome(const store::TrialRecord& outcome);
  void note_rig(const RigReport& report);
  void note_plan(const store::SessionRecord& plan);
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
    store::Coverage received;    ///< Durable or waiting.
    store::Coverage durable;
    std::uint64_t resent = 0;
    std::uint64_t duplicated = 0;
    bool is_changed = false;  ///< Differs from what the store has.
    bool owes_receipt = false;
    Clock::TimePoint receipt_given;
    Clock::TimePoint origin_claimed;  ///< When a rig's word moved the origin.
    GapWatch gaps;
  };
  struct Tally {
    store::TrialTally counts;
    bool is_changed = false;
  };
  struct PendingTrial {
    store::TrialRecord record;
    bool is_stored = false;
    bool is_given_up = false;
    std::uint64_t received = 0;        ///< Of its samples, when last looked at.
    Clock::TimePoint unchanged_since;  ///< That number, with its rig there.
  };

  Stream& stream_of(const store::StreamKey& key);
  void hear_of(const store::StreamKey& key);
  void count_for_trial(const store::Block& block, std::uint64_t fresh);
  void hold(std::size_t bytes);
  void learn_of(const store::SessionRecord& session);
  void follow_claim(Stream& stream, const RigReport& report);
  [[nodiscard]] Clock::TimePoint receipt_due(const Stream& stream, Clock::TimePoint now) const;
  [[nodiscard]] bool is_whole(const store::TrialRecord& trial) const;
  [[nodiscard]] bool has_whole_trial() const;
  void commit(Clock::TimePoint now, Decisions& decisions);
  void certify(store::TrialRecord& trial) const;
  [[nodiscard]] Result<void> fill_batch();
  void give_up_trials(Clock::TimePoint now, Decisions& decisions);
  [[nodiscard]] bool is_there(const Id& rig, Clock::TimePoint now) const;
  void give_stream_receipts(Clock::TimePoint now, Decisions& decisions);
  void ask_for_missing(Clock::TimePoint now, Decisions& decisions);
  [[nodiscard]] Clock::TimePoint commit_due() const;
  [[nodiscard]] static TrialReceipt receipt_of(const store::TrialRecord& trial);

  store::Store& store_;
  const Clock& clock_;
  Options options_;

  std::map<store::StreamKey, Stream> streams_;
  std::map<Id, Clock::TimePoint> heard_rigs_;  ///< Since this program's start; when last.
  std::map<Id, Tally> tallies_;
  std::map<Id, PendingTrial> pending_;  ///< Outcomes without certificate.
  std::deque<Id> closed_;               ///< Trials certified last: late repetitions no longer count for them.
  std::map<std::pair<std::string, Id>, std::pair<std::uint32_t, std::uint64_t>>
      newest_;  ///< Checksum and bytes.
  SessionCertificates certificates_;
  std::vector<TrialReceipt> owed_;  ///< Receipts to repeat.
  std::vector<store::SessionCertificate> owed_sessions_;
  store::SessionRecord session_;  ///< The newest plan's.
  std::set<Id> sessions_;         ///< That have a plan.

  store::Batch batch_;
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
