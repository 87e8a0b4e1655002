#include "analysis_service/identification/trial_assembler.hpp"

#include <algorithm>
#include <limits>
#include <utility>

namespace tonus::identification {
namespace {

bool overlap(const SequenceRange& a, const SequenceRange& b) { return a.first < b.end && b.first < a.end; }

/// A range that can be assembled: not empty, its onset inside, and no longer than the buffer.
bool is_sound(const TrialReport& report, std::size_t most_rows) {
  const SequenceRange& range = report.range;
  return report.end != TrialEnd::kRefused && !range.is_empty() && range.count() <= most_rows;
}

std::uint64_t rows_in(const std::vector<SequenceRange>& ranges) {
  std::uint64_t rows = 0;
  for (const auto& range : ranges) rows += range.count();
  return rows;
}

}  // namespace

void TrialAssembler::add(const RowBlock& block) {
  if (block.rows.empty()) return;
  if (done_.contains(block.trial)) {
    counts_.repeated += block.rows.size();
    return;
  }
  if (block.trial == kNoId && !is_wanted(block)) {
    counts_.outside += block.rows.size();
    return;
  }
  const StreamKey stream{block.rig, block.epoch};
  if (rows_held_ + block.rows.size() > limits_.rows &&
      !make_room(block.rows.size(), stream, block.first_sequence)) {
    counts_.refused += block.rows.size();
    return;
  }
  const std::size_t added = streams_[stream].add(block.first_sequence, block.rows);
  rows_held_ += added;
  counts_.rows += added;
  counts_.repeated += block.rows.size() - added;
}

void TrialAssembler::add(const TrialReport& report, Clock::TimePoint now) {
  const Id& trial = report.plan.trial;
  if (done_.contains(trial) || waiting_.contains(trial)) return;
  if (waiting_.size() >= limits_.trials_waiting) forget_oldest_foreign();
  if (waiting_.size() >= limits_.trials_waiting) {
    ++counts_.reports_dropped;
    return;
  }
  Waiting& waiting = waiting_[trial];
  waiting.report = report;
  waiting.due = now + limits_.first_wait;
}

TrialAssembler::Progress TrialAssembler::advance(Clock::TimePoint now, bool is_rig_listening) {
  Progress progress;
  const auto take_out = [&](WaitingTrials::iterator trial) { progress.finished.push_back(finish(trial)); };

  for (auto trial = waiting_.begin(); trial != waiting_.end();) {
    const auto current = trial++;
    if (is_settled(current->second, now)) take_out(current);
  }

  std::vector<WaitingTrials::iterator> asked;
  std::vector<WaitingTrials::iterator> candidates;
  for (auto trial = waiting_.begin(); trial != waiting_.end(); ++trial) {
    if (!may_be_asked_for(trial->second) || trial->second.due > now) continue;
    (trial->second.is_asked_for ? asked : candidates).push_back(trial);
  }
  const auto newer = [](const auto& a, const auto& b) {
    return a->second.report.plan.attempt > b->second.report.plan.attempt;
  };
  std::sort(candidates.begin(), candidates.end(), newer);
  candidates.resize(std::min(candidates.size(), free_slots()));
  asked.insert(asked.end(), candidates.begin(), candidates.end());

  for (const auto trial : asked) {
    if (!is_rig_listening) {
      trial->second.due = now + limits_.first_retry;
    } else if (!ask(trial->second, now, progress.requests)) {
      take_out(trial);
    }
  }
  std::sort(progress.finished.begin(), progress.finished.end(),
            [](const auto& a, const auto& b) { return a.report.plan.attempt < b.report.plan.attempt; });
  return progress;
}

bool TrialAssembler::ask(Waiting& waiting, Clock::TimePoint now, std::vector<ResendRequest>& requests) {
  const TrialReport& report = waiting.report;
  const std::vector<SequenceRange> missing = gaps(report);
  const std::uint64_t missing_rows = rows_in(missing);
  const bool is_coming = waiting.is_asked_for && missing_rows < waiting.missing;
  waiting.missing = missing_rows;
  if (is_coming) {  // more may be under way: another look before another request
    waiting.fruitless = 0;
    waiting.due = now + limits_.first_retry;
    return true;
  }
  if (waiting.fruitless >= limits_.resends) return false;

  const std::size_t ranges = std::min(missing.size(), limits_.ranges_a_request);
  for (std::size_t i = 0; i < ranges; ++i) {
    requests.push_back({report.plan.rig, report.plan.trial, report.epoch, missing[i]});
  }
  const auto longest = limits_.longest_retry;
  auto retry = limits_.first_retry;
  for (int i = 0; i < waiting.fruitless && retry < longest; ++i) retry *= 2;
  waiting.due = now + std::min(retry, longest);
  waiting.is_asked_for = true;
  ++waiting.fruitless;
  ++waiting.requests;
  return true;
}

MeasuredTrial TrialAssembler::finish(WaitingTrials::iterator trial) {
  const Waiting& waiting = trial->second;
  MeasuredTrial measured;
  measured.report = waiting.report;
  measured.resend_requests = waiting.requests;
  if (is_sound(waiting.report, limits_.rows)) {
    measured.missing_rows = rows_in(gaps(waiting.report));
    RowStore& rows = streams_[{waiting.report.plan.rig, waiting.report.epoch}];
    measured.rows = rows.copy(waiting.report.range);
    rows_held_ -= rows.rows();
    rows.erase(waiting.report.range);
    rows_held_ += rows.rows();
    if (rows.rows() == 0) streams_.erase({waiting.report.plan.rig, waiting.report.epoch});
  }
  done_.insert(trial->first);
  done_order_.push_back(trial->first);
  if (done_order_.size() > limits_.trials_remembered) {
    done_.erase(done_order_.front());
    done_order_.pop_front();
  }
  waiting_.erase(trial);
  return measured;
}

Clock::TimePoint TrialAssembler::next_due() const {
  const bool has_slot = free_slots() > 0;
  Clock::TimePoint due = Clock::TimePoint::max();
  for (const auto& [id, waiting] : waiting_) {
    const bool has_end = waiting.report.end != TrialEnd::kCompleted;
    if (has_end || (may_be_asked_for(waiting) && (waiting.is_asked_for || has_slot))) {
      due = std::min(due, waiting.due);
    }
  }
  return due;
}

std::span<const Row> TrialAssembler::rows_from(const Id& rig, std::uint64_t epoch,
                                               std::uint64_t sequence) const {
  const auto stream = streams_.find({rig, epoch});
  if (stream == streams_.end()) return {};
  return stream->second.from(sequence);
}

std::vector<const TrialReport*> TrialAssembler::waiting() const {
  std::vector<const TrialReport*> reports;
  for (const auto& [id, waiting] : waiting_) {
    if (is_current(waiting)) reports.push_back(&waiting.report);
  }
  return reports;
}

bool TrialAssembler::may_be_asked_for(const Waiting& waiting) const {
  return session_ != kNoId && is_current(waiting) && waiting.report.end == TrialEnd::kCompleted;
}

bool TrialAssembler::is_settled(const Waiting& waiting, Clock::TimePoint now) const {
  const TrialReport& report = waiting.report;
  if (!is_sound(report, limits_.rows)) return true;
  if (report.end != TrialEnd::kCompleted && now >= waiting.due) return true;
  const auto stream = streams_.find({report.plan.rig, report.epoch});
  return stream != streams_.end() && stream->second.holds(report.range);
}

bool TrialAssembler::is_wanted(const RowBlock& block) const {
  const SequenceRange range{block.first_sequence, block.first_sequence + block.rows.size()};
  return is_claimed({block.rig, block.epoch}, range);
}

bool TrialAssembler::is_claimed(const StreamKey& stream, const SequenceRange& run) const {
  return std::any_of(waiting_.begin(), waiting_.end(), [&](const auto& entry) {
    const TrialReport& report = entry.second.report;
    return is_current(entry.second) && StreamKey{report.plan.rig, report.epoch} == stream &&
           overlap(report.range, run);
  });
}

std::size_t TrialAssembler::free_slots() const {
  const auto taken =
      static_cast<std::size_t>(std::count_if(waiting_.begin(), waiting_.end(), [&](const auto& entry) {
        return entry.second.is_asked_for && may_be_asked_for(entry.second);
      }));
  return limits_.trials_asked_for - std::min(taken, limits_.trials_asked_for);
}

std::vector<SequenceRange> TrialAssembler::gaps(const TrialReport& report) const {
  const auto stream = streams_.find({report.plan.rig, report.epoch});
  if (stream == streams_.end()) return {report.range};
  return stream->second.missing(report.range);
}

/// Gives up rows that no report of the session has claimed, the oldest first, but not the run that the new
/// rows continue.
bool TrialAssembler::make_room(std::size_t rows, const StreamKey& stream, std::uint64_t first_sequence) {
  for (auto& [key, store] : streams_) {
    for (const SequenceRange& run : store.runs()) {
      if (rows_held_ + rows <= limits_.rows) return true;
      const bool is_continued = key == stream && run.end == first_sequence;
      if (is_continued || is_claimed(key, run)) continue;
      store.erase(run);
      rows_held_ -= run.count();
      counts_.evicted += run.count();
    }
  }
  return rows_held_ + rows <= limits_.rows;
}

void TrialAssembler::forget_oldest_foreign() {
  auto oldest = waiting_.end();
  for (auto trial = waiting_.begin(); trial != waiting_.end(); ++trial) {
    if (is_current(trial->second)) continue;
    if (oldest == waiting_.end() || trial->second.due < oldest->second.due) oldest = trial;
  }
  if (oldest == waiting_.end()) return;
  waiting_.erase(oldest);
  ++counts_.reports_dropped;
}

}  // namespace tonus::identification
