#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <optional>
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
  bool is_faulted = false;             ///< A fault, or held.
};

/// "Every sample of the stream from `first` to below `through` is durable."
struct StreamReceipt {
  store::StreamKey stream;
  Id session{};
  std::uint64_t first = 0;  ///< The first sample that it speaks of: the stream's origin.
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
/// A message belongs to the session that it names, where that one has a plan, else to the newest plan's. A
/// plan whose start cannot be (no time, before 2020, more than a minute ahead of this clock) is kept and
/// becomes nobody's newest. How far a stream reaches by the word of others (the rig's state, outcomes) is
/// what the newest such word says: a false one is forgotten with the next true one, or when its trial is
/// given up.
///
/// Completeness. A stream is expected to be whole from its origin (0, or where another archive's receipts
/// end) to the largest number that a block, a pending outcome or the rig's newest state speaks of; so is
/// every pending trial, wherever the origin is. What is missing is requested as GapWatch says, once the rig
/// has been heard from. A trial that stays incomplete for `give_up` while its rig is present and sends
/// nothing of it gets a receipt that says how many samples are missing; should they come all the same, it
/// gets a complete one.
///
/// Auxiliary channels. Where the rig describes some, a sample counts as received when both it and the
/// auxiliary values of its time are here; receipts, certificates and requests speak of such samples. How far
/// a stream reaches is never taken from auxiliary values alone.
///
/// A session that has ended gets its certificate, the sums over its trials, with the commit that takes its
/// end, and a new one with each later commit that changes one of its trials.
///
/// Idle. With `idle.ring`, samples outside of trials that come while no session goes on wait in memory for so
/// long and are then let go: they count as taken care of, so that the rig frees them, and are not stored.
/// What precedes and follows a fault is stored, and so are all samples while a session goes on: from its plan
/// to its end, or until nothing has been heard of it for `session_silence`. What belongs to a trial is always
/// stored. States that name no session are stored once in `idle.state_interval` at most, the newest of them
/// also at the begin of a session and at a fault. How far samples were let go is stored as the origin; after
/// a crash the rig is asked once more for what is not known to have been let go.
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
    struct Idle {
      Clock::Duration ring{};  ///< 0: every sample is stored.
      std::size_t ring_bytes = std::size_t{32} << 20U;
      Clock::Duration before_fault = std::chrono::seconds(10);
      Clock::Duration after_fault = std::chrono::seconds(5);
      Clock::Duration commit_interval = std::chrono::seconds(10);
      Clock::Duration state_interval = std::chrono::seconds(60);
      Clock::Duration session_silence = std::chrono::hours(1);
    };
    Idle idle;
  };

  Ingest(store::Store& store, const Clock& clock, const Options& options);
  Ingest(store::Store& store, const Clock& clock) : Ingest(store, clock, Options{}) {}

  /// Resumes from what the store holds. Call once, before anything is taken. The next step() repeats the
  /// receipts of the newest session's trials and of every rig's stream.
  [[nodiscard]] Result<void> recover();

  /// Of samples.
  void take(store::Block block);

  /// Of auxiliary values, so many with each sample. kInvalidArgument, and nothing follows from it: that is
  /// not what the rig describes.
  [[nodiscard]] Result<void> take_auxiliary(store::Block block, std::uint32_t values_per_sample);

  /// Stores the message. With `is_state` (the last value of its key, which late joiners are given again) a
  /// repetition of the newest one of its key is left out. `session` is what the message names, or none.
  void take(store::Message message, bool is_state);

  /// What messages say that matters here; the messages themselves are taken separately.
  void note_outcome(const store::TrialRecord& outcome);
  void note_rig(const RigReport& report);
  void note_plan(const store::SessionRecord& plan);

  /// So many values of auxiliary channels come with each sample of the rig (0: none): of the streams that
  /// begin from now on, and of the newest one if nothing of it is durable yet. What an earlier stream brings
  /// is what was described then.
  void note_auxiliary(const Id& rig, std::uint32_t values_per_sample);
  void note_session_end(const Id& session, std::uint32_t end);

  /// Does what is due.
  [[nodiscard]] Decisions step();

  /// Stores what waits, for an orderly end; receipts for it are given after the next start. The store's
  /// error.
  [[nodiscard]] Result<void> finish();

  [[nodiscard]] IngestStatus status() const;

 private:
  struct Held {
    Clock::TimePoint taken;
    store::Block block;
  };
  /// Which numbers have come, of samples or of auxiliary values.
  struct Part {
    store::Coverage received;  ///< Durable or waiting.
    store::Coverage let_go;    ///< Not stored, and not to be: idle.
    store::Coverage known;     ///< Both, and what is in the ring.
  };
  struct Stream {
    std::uint64_t origin = 0;
    std::uint64_t seen_end = 0;          ///< One more than the largest number of a block of samples.
    std::uint64_t reported_next = 0;     ///< By the rig's newest state.
    std::uint32_t auxiliary_values = 0;  ///< With each sample; 0: none.
    Part samples;
    Part auxiliary;
    store::Coverage durable;  ///< Taken care of, as of the last commit.
    std::deque<Held> ring;    ///< Idle samples, oldest first.
    std::size_t ring_bytes = 0;
    bool has_let_go = false;  ///< Since the last commit.
    bool is_faulted = false;
    Clock::TimePoint keep_until;  ///< After a fault.

    [[nodiscard]] Part& part_of(const store::Block& block) {
      return block.is_auxiliary ? auxiliary : samples;
    }
    /// Whole: the numbers that both parts have, or the samples alone where no auxiliary values come.
    [[nodiscard]] store::Coverage whole(store::Coverage Part::*coverage) const;
    [[nodiscard]] store::Coverage received() const { return whole(&Part::received); }
    [[nodiscard]] store::Coverage known() const { return whole(&Part::known); }
    /// Received or let go.
    [[nodiscard]] store::Coverage taken_care_of() const;
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
  [[nodiscard]] std::uint64_t frontier_of(const store::StreamKey& key, const Stream& stream) const;
  [[nodiscard]] std::vector<store::SequenceRange> missing_of(const store::StreamKey& key,
                                                             const Stream& stream) const;
  void hear_of(const store::StreamKey& key);
  void count_for_trial(const store::Block& block, std::uint64_t resent, std::uint64_t duplicated);
  void hold(std::size_t bytes);
  void learn_of(const store::SessionRecord& session);
  [[nodiscard]] bool is_idle(Clock::TimePoint now) const;
  void keep(Stream& stream, store::Block block);
  void note_fault(Stream& stream, bool is_faulted);
  void let_go(Clock::TimePoint now, Decisions& decisions);
  void put(store::Message message);
  [[nodiscard]] bool hold_back(store::Message& message);
  void put_held_back(Clock::TimePoint stored_before);
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
  std::map<Id, Clock::TimePoint> heard_rigs_;     ///< Since this program's start; when last.
  std::map<Id, std::uint32_t> auxiliary_values_;  ///< By the rigs' descriptions.
  std::map<Id, Tally> tallies_;
  std::map<Id, PendingTrial> pending_;  ///< Outcomes without certificate.
  std::deque<Id> closed_;               ///< Trials certified last: late repetitions no longer count for them.
  std::map<std::pair<std::string, Id>, std::pair<std::uint32_t, std::uint64_t>>
      newest_;  ///< Checksum and bytes.
  SessionCertificates certificates_;
  std::vector<TrialReceipt> owed_;  ///< Receipts to repeat.
  std::vector<store::SessionCertificate> owed_sessions_;
  store::SessionRecord session_;             ///< The newest plan's.
  std::set<Id> sessions_;                    ///< That have a plan.
  std::map<Id, Clock::TimePoint> going_on_;  ///< Sessions without an end, and when last heard of.

  using TopicKey = std::pair<std::string, Id>;
  struct HeldBack {
    Clock::TimePoint stored;  ///< The one before it.
    std::optional<store::Message> message;
  };
  std::map<TopicKey, HeldBack> idle_states_;
  Clock::TimePoint idle_committed_;

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
