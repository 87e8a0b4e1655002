#include "services/archive/ingest.hpp"

#include <algorithm>
#include <set>
#include <spdlog/fmt/fmt.h>
#include <utility>

namespace tonus::archive {
namespace {

/// Gaps of a stream that are looked at in one step; the rest wait until these are closed.
constexpr std::size_t kGapsAtOnce = 64;

/// Trials under way whose counts are kept; more is nonsense from the wire.
constexpr std::size_t kMostTallies = 1024;

/// Between two receipts of one rig's streams, which replace each other on the bus.
constexpr Clock::Duration kReceiptSpacing = std::chrono::milliseconds(20);

/// What a plan's start may be ahead of this machine's clock: what clocks of a laboratory differ by.
constexpr std::uint64_t kClockDifferenceNs = 60'000'000'000;

/// No session began before; ISO 8601.
constexpr std::string_view kEarliestStart = "2020-01-01T00:00:00";

/// "2026-03-01T10:00:00" with or without what follows, and not before kEarliestStart.
bool is_plausible_start(std::string_view start) {
  constexpr std::string_view kForm = "dddd-dd-ddTdd:dd:dd";
  if (start.size() < kForm.size()) return false;
  for (std::size_t i = 0; i < kForm.size(); ++i) {
    const bool is_digit = start[i] >= '0' && start[i] <= '9';
    if (kForm[i] == 'd' ? !is_digit : start[i] != kForm[i]) return false;
  }
  return start >= kEarliestStart;
}

}  // namespace

Ingest::Ingest(store::Store& store, const Clock& clock, const Options& options)
    : store_(store), clock_(clock), options_(options) {}

Result<void> Ingest::recover() {
  TONUS_TRY_ASSIGN(const auto sessions, store_.sessions());
  for (const store::SessionRecord& session : sessions) learn_of(session);

  TONUS_TRY_ASSIGN(auto streams, store_.streams());
  for (store::StreamRecord& record : streams) {
    Stream& stream = stream_of(record.key);
    stream.origin = record.origin;
    stream.seen_end = std::max(record.origin, record.coverage.end());
    stream.auxiliary_values = record.auxiliary_values;
    stream.durable = record.whole();
    stream.samples.received = stream.samples.known = std::move(record.coverage);
    stream.auxiliary.received = stream.auxiliary.known = std::move(record.auxiliary_coverage);
    stream.resent = record.resent;
    stream.duplicated = record.duplicated;
    stream.origin_claimed = clock_.now();
    stream.owes_receipt = true;
  }
  TONUS_TRY_ASSIGN(const auto tallies, store_.tallies());
  for (const store::TrialTally& tally : tallies) tallies_[tally.trial].counts = tally;

  TONUS_TRY_ASSIGN(const auto uncertified, store_.uncertified_trials());
  for (const store::TrialRecord& trial : uncertified) {
    pending_[trial.trial] = {trial, true, false, 0, clock_.now()};
    (void)stream_of(trial.stream);
  }
  TONUS_TRY_ASSIGN(const auto trials, store_.trials(session_.session));
  for (const store::TrialRecord& trial : trials) {
    if (trial.is_certified) owed_.push_back(receipt_of(trial));
  }
  TONUS_TRY_ASSIGN(const auto certificates, store_.session_certificates());
  for (const store::SessionCertificate& certificate : certificates) {
    certificates_.restore(certificate);
    if (certificate.session == session_.session) owed_sessions_.push_back(certificate);
  }
  const bool has_ended = std::any_of(certificates.begin(), certificates.end(),
                                     [this](const auto& c) { return c.session == session_.session; });
  if (session_.session != kNoId && !has_ended) going_on_[session_.session] = clock_.now();
  TONUS_TRY_ASSIGN(const auto newest, store_.newest_messages());
  for (const store::MessageDigest& digest : newest)
    newest_[{digest.topic, digest.key}] = {digest.checksum, digest.bytes};
  return {};
}

Ingest::Stream& Ingest::stream_of(const store::StreamKey& key) {
  const auto [place, is_new] = streams_.try_emplace(key);
  if (!is_new) return place->second;
  place->second.gaps = GapWatch(options_.gaps);
  if (const auto described = auxiliary_values_.find(key.rig); described != auxiliary_values_.end())
    place->second.auxiliary_values = described->second;
  return place->second;
}

void Ingest::hear_of(const store::StreamKey& key) {
  const bool is_new_epoch = !streams_.contains(key);
  const Clock::TimePoint now = clock_.now();
  const bool was_there = is_there(key.rig, now);
  heard_rigs_[key.rig] = now;
  if (was_there && !is_new_epoch) return;
  // The rig is back and can answer.
  for (auto& [other, stream] : streams_) {
    if (other.rig == key.rig) stream.gaps.start_anew();
  }
}

bool Ingest::is_there(const Id& rig, Clock::TimePoint now) const {
  const auto heard = heard_rigs_.find(rig);
  return heard != heard_rigs_.end() && now - heard->second < options_.rig_silence;
}

void Ingest::hold(std::size_t bytes) {
  if (batch_.is_empty()) waiting_since_ = clock_.now();
  waiting_bytes_ += bytes;
}

void Ingest::take(store::Block block) {
  hear_of(block.stream);
  Stream& stream = stream_of(block.stream);
  if (!block.is_auxiliary) stream.seen_end = std::max(stream.seen_end, block.range().end);
  if (waiting_bytes_ + block.payload->size() > options_.backlog_bytes) {
    ++refused_blocks_;
    return;
  }
  const bool is_let_go_later =
      block.trial == kNoId && is_idle(clock_.now()) && clock_.now() >= stream.keep_until;
  const auto coverage = is_let_go_later ? &Part::known : &Part::received;
  const auto whole = [&] { return block.is_resent ? stream.whole(coverage).count_in(block.range()) : 0; };
  const std::uint64_t whole_before = whole();
  const std::uint64_t fresh = (stream.part_of(block).*coverage).add(block.range());
  const std::uint64_t resent = whole() - whole_before;
  const std::uint64_t duplicated = block.is_auxiliary ? 0 : block.count - fresh;
  stream.resent += resent;
  stream.duplicated += duplicated;
  stream.is_changed |= !is_let_go_later;
  count_for_trial(block, resent, duplicated);
  if (fresh == 0) {
    // A rig that sends again what is here has not got its receipt.
    const bool is_long_ago = clock_.now() >= stream.receipt_given + options_.receipt_interval;
    stream.owes_receipt |= block.is_resent && is_long_ago;
    return;
  }
  samples_ += block.is_auxiliary ? 0 : block.count;
  sample_bytes_ += block.payload->size();
  if (!is_let_go_later) return keep(stream, std::move(block));
  stream.ring_bytes += block.payload->size();
  stream.ring.push_back({clock_.now(), std::move(block)});
}

Result<void> Ingest::take_auxiliary(store::Block block, std::uint32_t values_per_sample) {
  const auto stream = streams_.find(block.stream);
  const auto described = auxiliary_values_.find(block.stream.rig);
  std::uint32_t expected = described == auxiliary_values_.end() ? 0 : described->second;
  if (stream != streams_.end()) expected = stream->second.auxiliary_values;
  if (values_per_sample != expected || expected == 0) {
    return fail(ErrorCode::kInvalidArgument,
                fmt::format("rig/auxiliary: {} values with each sample are not allowed; the rig describes {}",
                            values_per_sample, expected));
  }
  take(std::move(block));
  return {};
}

void Ingest::note_auxiliary(const Id& rig, std::uint32_t values_per_sample) {
  auxiliary_values_[rig] = values_per_sample;
  const auto is_of_rig = [&](const auto& stream) { return stream.first.rig == rig; };
  const auto newest = std::find_if(streams_.rbegin(), streams_.rend(), is_of_rig);
  if (newest == streams_.rend() || !newest->second.durable.ranges().empty()) return;
  if (std::exchange(newest->second.auxiliary_values, values_per_sample) == values_per_sample) return;
  newest->second.is_changed = true;
  hold(0);
}

void Ingest::keep(Stream& stream, store::Block block) {
  stream.part_of(block).received.add(block.range());
  stream.part_of(block).known.add(block.range());
  stream.is_changed = true;
  hold(block.payload->size());
  batch_.blocks.push_back(std::move(block));
}

void Ingest::count_for_trial(const store::Block& block, std::uint64_t resent, std::uint64_t duplicated) {
  const bool is_plain = !block.is_resent && duplicated == 0;
  if (block.trial == kNoId || is_plain) return;
  if (std::find(closed_.begin(), closed_.end(), block.trial) != closed_.end()) return;
  if (!tallies_.contains(block.trial) && tallies_.size() >= kMostTallies) return;
  Tally& tally = tallies_[block.trial];
  tally.counts.trial = block.trial;
  tally.counts.resent += resent;
  tally.counts.duplicated += duplicated;
  tally.is_changed = true;
}

void Ingest::take(store::Message message, bool is_state) {
  const std::pair<std::uint32_t, std::uint64_t> digest{message.checksum, message.payload->size()};
  if (const auto session = going_on_.find(message.session); session != going_on_.end())
    session->second = clock_.now();
  if (is_state) {
    auto& newest = newest_[{message.topic, message.key}];
    if (newest == digest) {
      const auto idle = idle_states_.find({message.topic, message.key});
      if (idle != idle_states_.end()) idle->second.message.reset();
      return;
    }
    if (hold_back(message)) return;
    newest = digest;
  }
  put(std::move(message));
}

void Ingest::put(store::Message message) {
  // Blocks can be requested again and messages cannot: these may wait in twice the room.
  if (waiting_bytes_ + message.payload->size() > 2 * options_.backlog_bytes) {
    ++lost_messages_;
    return;
  }
  if (!sessions_.contains(message.session)) message.session = session_.session;
  hold(message.payload->size());
  batch_.messages.push_back(std::move(message));
}

void Ingest::learn_of(const store::SessionRecord& session) {
  sessions_.insert(session.session);
  if (!is_plausible_start(session.started_at)) return;
  if (session.started_at > iso8601(clock_.utc_ns() + kClockDifferenceNs)) return;
  if (session.started_at >= session_.started_at) session_ = session;
}

void Ingest::note_plan(const store::SessionRecord& plan) {
  put_held_back(Clock::TimePoint::max());
  learn_of(plan);
  if (!certificates_.knows_end(plan.session)) going_on_[plan.session] = clock_.now();
  hold(0);
  std::erase_if(batch_.sessions,
                [&plan](const store::SessionRecord& waiting) { return waiting.session == plan.session; });
  batch_.sessions.push_back(plan);
}

void Ingest::note_rig(const RigReport& report) {
  hear_of(report.stream);
  Stream& stream = stream_of(report.stream);
  stream.reported_next = report.next_sequence;
  follow_claim(stream, report);
  note_fault(stream, report.is_faulted);
  const std::uint64_t durable = stream.durable.first_missing(stream.origin);
  const bool misses_receipt = report.received_through < durable;
  if (misses_receipt && clock_.now() >= stream.receipt_given + options_.receipt_interval)
    stream.owes_receipt = true;
}

void Ingest::follow_claim(Stream& stream, const RigReport& report) {
  // The rig may have freed what a receipt covers. Where it was not ours, another archive has those samples.
  if (report.received_through > stream.known().first_missing(stream.origin)) {
    stream.origin = report.received_through;
    stream.origin_claimed = clock_.now();
    stream.is_changed = true;
  } else if (report.received_through < stream.origin) {
    stream.origin = report.received_through;
    stream.is_changed = true;
  }
}

Clock::TimePoint Ingest::receipt_due(const Stream& stream, Clock::TimePoint now) const {
  if (stream.origin == 0) return now;
  const bool has_stored = stream.durable.first_missing(stream.origin) > stream.origin;
  return has_stored ? stream.origin_claimed + options_.claim_stands : Clock::TimePoint::max();
}

void Ingest::note_outcome(const store::TrialRecord& outcome) {
  if (pending_.contains(outcome.trial)) return;
  if (const auto known = store_.find_trial(outcome.trial);
      known && known->has_value() && (*known)->is_certified) {
    owed_.push_back(receipt_of(**known));
    return;
  }
  pending_[outcome.trial] = {outcome, false, false, 0, clock_.now()};
  if (outcome.has_samples) (void)stream_of(outcome.stream);
}

std::uint64_t Ingest::frontier_of(const store::StreamKey& key, const Stream& stream) const {
  std::uint64_t frontier = std::max({stream.origin, stream.seen_end, stream.reported_next});
  for (const auto& [id, pending] : pending_) {
    if (pending.record.stream == key && !pending.is_given_up)
      frontier = std::max(frontier, pending.record.range().end);
  }
  return frontier;
}

std::vector<store::SequenceRange> Ingest::missing_of(const store::StreamKey& key,
                                                     const Stream& stream) const {
  store::Coverage wanted;
  wanted.add({stream.origin, frontier_of(key, stream)});
  for (const auto& [id, pending] : pending_)
    if (pending.record.stream == key && !pending.is_given_up) wanted.add(pending.record.range());
  const store::Coverage known = stream.known();
  std::vector<store::SequenceRange> missing;
  for (const store::SequenceRange& range : wanted.ranges()) {
    const auto gaps = known.missing(range, kGapsAtOnce - missing.size());
    missing.insert(missing.end(), gaps.begin(), gaps.end());
    if (missing.size() >= kGapsAtOnce) break;
  }
  return missing;
}

void Ingest::note_session_end(const Id& session, std::uint32_t end) {
  going_on_.erase(session);
  if (certificates_.note_end(session, end)) hold(0);
}

bool Ingest::is_whole(const store::TrialRecord& trial) const {
  if (!trial.has_samples) return true;
  const auto stream = streams_.find(trial.stream);
  return stream != streams_.end() && stream->second.received().covers(trial.range());
}

bool Ingest::has_whole_trial() const {
  return std::any_of(pending_.begin(), pending_.end(),
                     [this](const auto& trial) { return is_whole(trial.second.record); });
}

Clock::TimePoint Ingest::commit_due() const {
  const bool has_unstored =
      std::any_of(pending_.begin(), pending_.end(), [](const auto& t) { return !t.second.is_stored; });
  const bool is_waiting = !batch_.is_empty() || has_unstored;
  const bool has_let_go =
      std::any_of(streams_.begin(), streams_.end(), [](const auto& s) { return s.second.has_let_go; });
  const Clock::TimePoint idle_due = has_let_go
                                        ? std::max(idle_committed_ + options_.idle.commit_interval, retry_at_)
                                        : Clock::TimePoint::max();
  if (has_whole_trial() || certificates_.is_due() || waiting_bytes_ >= options_.commit_bytes)
    return retry_at_;
  if (!is_waiting) return idle_due;
  return std::min(idle_due, std::max(waiting_since_ + options_.commit_interval, retry_at_));
}

Decisions Ingest::step() {
  const Clock::TimePoint now = clock_.now();
  Decisions decisions;
  decisions.trial_receipts = std::exchange(owed_, {});
  decisions.session_receipts = std::exchange(owed_sessions_, {});
  let_go(now, decisions);
  if (commit_due() <= now) commit(now, decisions);
  give_up_trials(now, decisions);
  give_stream_receipts(now, decisions);
  ask_for_missing(now, decisions);
  decisions.due = std::min(decisions.due, commit_due());
  return decisions;
}

void Ingest::give_up_trials(Clock::TimePoint now, Decisions& decisions) {
  for (auto& [id, pending] : pending_) {
    const auto stream = streams_.find(pending.record.stream);
    const std::uint64_t received =
        stream == streams_.end() ? 0 : stream->second.received().count_in(pending.record.range());
    const bool is_new = received != std::exchange(pending.received, received);
    if (is_new || !failure_.empty() || !is_there(pending.record.stream.rig, now))
      pending.unchanged_since = now;
    if (pending.is_given_up || !pending.is_stored) continue;
    const Clock::TimePoint give_up_at = pending.unchanged_since + options_.give_up;
    if (now < give_up_at) {
      decisions.due = std::min(decisions.due, give_up_at);
      continue;
    }
    pending.is_given_up = true;
    store::TrialRecord trial = pending.record;
    certify(trial);
    decisions.trial_receipts.push_back(receipt_of(trial));
  }
}

void Ingest::give_stream_receipts(Clock::TimePoint now, Decisions& decisions) {
  std::set<Id> served;
  for (auto& [key, stream] : streams_) {
    if (!stream.owes_receipt) continue;
    if (const Clock::TimePoint due = receipt_due(stream, now); due > now) {
      decisions.due = std::min(decisions.due, due);
      continue;
    }
    if (!served.insert(key.rig).second) {
      decisions.due = std::min(decisions.due, now + kReceiptSpacing);
      continue;
    }
    stream.owes_receipt = false;
    stream.receipt_given = now;
    const store::SequenceRange known{stream.origin, frontier_of(key, stream)};
    const std::uint64_t received = stream.durable.count_in(known);
    decisions.stream_receipts.push_back(
        {key,
         session_.session,
         stream.origin,
         stream.durable.first_missing(stream.origin),
         {known.count(), received, stream.resent, stream.duplicated, known.count() - received}});
  }
}

void Ingest::ask_for_missing(Clock::TimePoint now, Decisions& decisions) {
  // The store takes nothing now: there is no use in requesting more.
  if (!failure_.empty()) return;
  for (auto& [key, stream] : streams_) {
    if (!heard_rigs_.contains(key.rig)) continue;
    for (const store::SequenceRange& range : stream.gaps.ask(missing_of(key, stream), now))
      decisions.resends.push_back({key, range});
    decisions.due = std::min(decisions.due, stream.gaps.due());
  }
}

TrialReceipt Ingest::receipt_of(const store::TrialRecord& trial) {
  return {trial.trial, trial.session, trial.stream, trial.range().end, trial.certificate};
}

IngestStatus Ingest::status() const {
  IngestStatus status;
  status.failure = failure_;
  status.waiting_items = batch_.blocks.size() + batch_.messages.size();
  status.waiting_bytes = waiting_bytes_;
  status.refused_blocks = refused_blocks_;
  status.lost_messages = lost_messages_;
  status.samples = samples_;
  status.sample_bytes = sample_bytes_;
  for (const auto& [key, stream] : streams_) {
    const store::SequenceRange known{stream.origin, frontier_of(key, stream)};
    status.missing_samples += known.count() - stream.known().count_in(known);
  }
  return status;
}

}  // namespace tonus::archive
