// The part of Ingest that makes things durable, and the certificates of trials.

#include <utility>

#include "services/archive/ingest.hpp"

namespace tonus::archive {
namespace {

/// Certified trials that are remembered for late repetitions of their samples.
constexpr std::size_t kClosedTrials = 64;

}  // namespace

void Ingest::certify(store::TrialRecord& trial) const {
  const auto stream = streams_.find(trial.stream);
  const auto tally = tallies_.find(trial.trial);
  store::Certificate& certificate = trial.certificate;
  certificate = {};
  certificate.expected = trial.range().count();
  certificate.received = stream == streams_.end() ? 0 : stream->second.received().count_in(trial.range());
  certificate.missing = certificate.expected - certificate.received;
  if (tally != tallies_.end()) {
    certificate.resent = tally->second.counts.resent;
    certificate.duplicated = tally->second.counts.duplicated;
  }
  trial.is_certified = certificate.missing == 0;
  trial.certified_ns = trial.is_certified ? clock_.utc_ns() : 0;
}

Result<void> Ingest::fill_batch() {
  // What follows from the items that wait is made anew for each try.
  batch_.streams.clear();
  batch_.tallies.clear();
  batch_.trials.clear();
  batch_.certificates.clear();
  for (const auto& [key, stream] : streams_) {
    if (!stream.is_changed && !stream.has_let_go) continue;
    const std::uint64_t origin = stream.samples.let_go.ranges().empty()
                                     ? stream.origin
                                     : stream.taken_care_of().first_missing(stream.origin);
    batch_.streams.push_back({key, origin, stream.samples.received, stream.resent, stream.duplicated,
                              stream.auxiliary_values, stream.auxiliary.received});
  }
  for (const auto& [id, tally] : tallies_) {
    if (tally.is_changed) batch_.tallies.push_back(tally.counts);
  }
  std::vector<store::TrialRecord> waiting;
  for (const auto& [id, pending] : pending_) {
    waiting.push_back(pending.record);
    certify(waiting.back());
    if (waiting.back().is_certified || !pending.is_stored) batch_.trials.push_back(waiting.back());
  }
  for (const store::TrialRecord& trial : batch_.trials) certificates_.note_change(trial.session);
  TONUS_TRY_ASSIGN(batch_.certificates, certificates_.make(store_, waiting, session_, clock_.utc_ns()));
  return {};
}

void Ingest::commit(Clock::TimePoint now, Decisions& decisions) {
  auto filled = fill_batch();
  if (auto committed = filled ? store_.commit(batch_) : filled; !committed) {
    failure_ = committed.error().message;
    retry_at_ = now + options_.retry_interval;
    return;
  }
  failure_.clear();
  retry_at_ = now;
  idle_committed_ = now;
  for (auto& [key, stream] : streams_) {
    const bool has_let_go = std::exchange(stream.has_let_go, false);
    if (!std::exchange(stream.is_changed, false) && !has_let_go) continue;
    const std::uint64_t before = stream.durable.first_missing(stream.origin);
    stream.durable = stream.taken_care_of();
    stream.owes_receipt |= stream.durable.first_missing(stream.origin) > before;
  }
  for (auto& [id, tally] : tallies_) tally.is_changed = false;
  for (const store::TrialRecord& trial : batch_.trials) {
    pending_[trial.trial].is_stored = true;
    if (!trial.is_certified) continue;
    decisions.trial_receipts.push_back(receipt_of(trial));
    pending_.erase(trial.trial);
    tallies_.erase(trial.trial);
    closed_.push_back(trial.trial);
    if (closed_.size() > kClosedTrials) closed_.pop_front();
  }
  certificates_.note_committed(batch_.certificates);
  decisions.session_receipts.insert(decisions.session_receipts.end(), batch_.certificates.begin(),
                                    batch_.certificates.end());
  batch_ = {};
  waiting_bytes_ = 0;
}

Result<void> Ingest::finish() {
  Decisions unsent;
  put_held_back(Clock::TimePoint::max());
  if (commit_due() != Clock::TimePoint::max()) commit(clock_.now(), unsent);
  if (failure_.empty()) return {};
  return fail(ErrorCode::kIo, failure_);
}

}  // namespace tonus::archive
