#include "analysis_service/identification/identification_core.hpp"

#include <algorithm>
#include <spdlog/fmt/fmt.h>
#include <utility>

namespace tonus::identification {
namespace {

using Seconds = std::chrono::duration<double>;

/// What is saved up of the time of live estimates, so that one that was slow does not delay the next.
constexpr Seconds kLiveBudget{0.05};

}  // namespace

IdentificationCore::IdentificationCore(const CoreSettings& settings)
    : settings_(settings),
      assembler_(settings.assembler),
      book_(settings.book),
      live_(settings.live),
      live_budget_(kLiveBudget) {}

void IdentificationCore::set_rig(const Id& rig, const RigGeometry& geometry, double sample_rate,
                                 bool is_rotary, std::vector<AuxiliaryChannel> channels) {
  rigs_[rig] = {geometry, sample_rate, is_rotary, std::move(channels)};
}

void IdentificationCore::set_session(const Id& session, const muscles::MuscleSettings& muscles) {
  muscle_judge_.begin(muscles);
  if (session != session_) rejected_.clear();
  session_ = session;
  assembler_.set_session(session);
  book_.keep_only(session);
  live_.keep_only(session);
}

void IdentificationCore::set_needed(const std::vector<impedance::Method>& methods, bool is_precision_led) {
  book_.set_precision_led(is_precision_led);
  std::vector<impedance::Options> further;
  for (const impedance::Method method : methods) {
    further.push_back(settings_.live);
    further.back().method = method;
    further.back().model = impedance::Model::kLinear;
    further.back().has_trace = true;
  }
  book_.set_further(std::move(further));
}

void IdentificationCore::reject(const Id& trial, std::uint32_t attempt) {
  if (trial != trial_id(session_, attempt) || !rejected_.insert(attempt).second) return;
  book_.withdraw(session_, attempt);
  live_.withdraw(session_, attempt);
  muscle_judge_.withdraw(trial);
  for (Settled& settled : settled_) {
    if (settled.trial.report.plan.trial == trial) settled.is_kept = false;
  }
}

void IdentificationCore::add(const RowBlock& block) {
  assembler_.add(block);
  if (expected_ && block.trial == expected_->trial && block.trial != kNoId && !live_.follows(block.trial)) {
    if (const Rig* rig = rig_of(*expected_)) {
      settle_live();
      live_.start(*expected_, rig->geometry, rig->sample_rate, block.epoch, block.first_sequence);
      expected_.reset();
    }
  }
  follow();
}

void IdentificationCore::follow() {
  const auto next = live_.next();
  if (!next) return;
  const auto rows = assembler_.rows_from(next->rig, next->epoch, next->sequence);
  if (rows.empty()) return;
  live_.push(rows);
  has_live_news_ = true;
}

IdentificationCore::Output IdentificationCore::advance(Clock::TimePoint now, bool is_rig_listening) {
  Output output;
  settle_held(now, is_rig_listening, output);
  auto progress = assembler_.advance(now, is_rig_listening);
  output.requests.insert(output.requests.end(), progress.requests.begin(), progress.requests.end());
  for (MeasuredTrial& trial : progress.finished) {
    if (must_wait(trial) && held_.size() < settings_.trials_without_rig) {
      const auto due = now + wait_of(trial);
      held_.push_back({std::move(trial), due, now + settings_.auxiliary_retry});
    } else {
      settle(std::move(trial), output);
    }
  }
  if (!output.verdicts.empty()) return output;
  settle_live();
  output.remarks = std::exchange(remarks_, {});
  if (const auto condition = next_condition()) output.estimates = book_.identify(*condition);
  return output;
}

std::vector<SequenceRange> IdentificationCore::missing_auxiliary(const MeasuredTrial& trial) const {
  const Rig* rig = rig_of(trial.report.plan);
  const bool has_auxiliary = rig != nullptr && !rig->channels.empty() && !trial.rows.empty();
  return has_auxiliary ? auxiliary_.missing(trial.report) : std::vector<SequenceRange>();
}

bool IdentificationCore::must_wait(const MeasuredTrial& trial) const {
  if (trial.report.end != TrialEnd::kCompleted) return false;
  return rig_of(trial.report.plan) == nullptr || !missing_auxiliary(trial).empty();
}

Clock::Duration IdentificationCore::wait_of(const MeasuredTrial& trial) const {
  return rig_of(trial.report.plan) == nullptr ? settings_.rig_wait : settings_.auxiliary_wait;
}

void IdentificationCore::settle_held(Clock::TimePoint now, bool is_rig_listening, Output& output) {
  for (auto held = held_.begin(); held != held_.end();) {
    if (must_wait(held->trial) && now < held->due) {
      if (now >= held->ask_at && is_rig_listening) {
        const TrialReport& report = held->trial.report;
        for (const SequenceRange& range : missing_auxiliary(held->trial))
          output.requests.push_back({report.plan.rig, report.plan.trial, report.epoch, range});
        held->ask_at = now + settings_.auxiliary_retry;
      }
      ++held;
      continue;
    }
    settle(std::move(held->trial), output);
    held = held_.erase(held);
  }
}

void IdentificationCore::settle(MeasuredTrial trial, Output& output) {
  const TrialReport report = trial.report;
  const Rig* rig = rig_of(report.plan);
  const TrialJudge judge(settings_.judge.limits(rig != nullptr && rig->is_rotary));
  Verdict verdict = judge.judge(trial, rig != nullptr ? &rig->geometry : nullptr);
  if (rig != nullptr && !rig->channels.empty() && !trial.rows.empty())
    trial.auxiliary = auxiliary_.series_of(report, rig->channels);
  auxiliary_.finish(report.plan.trial);
  muscle_judge_.judge(trial, judge.limits(), verdict);
  const bool is_rejected = report.plan.session == session_ && rejected_.contains(report.plan.attempt);
  if (report.plan.kind == TrialKind::kContraction) {  // it enters no estimate
    if (is_rejected) muscle_judge_.withdraw(report.plan.trial);
    output.verdicts.push_back({report, std::move(verdict)});
    return;
  }
  bool is_kept = verdict.is_valid;
  if (verdict.is_valid) {
    const std::size_t onset =
        report.plan.kind == TrialKind::kRecording ? 0 : report.onset - report.range.first;
    auto converted = trial_from_rows(frame_of(report), rig->geometry, trial.rows, onset);
    auto added = converted ? book_.add_valid(report, *converted) : Result<void>(converted.error());
    if (!added && added.error().code == ErrorCode::kUnavailable) {
      remarks_.push_back(added.error().message);  // a good trial that there is no room for
      is_kept = false;
    } else if (!added) {
      verdict.is_valid = is_kept = false;
      verdict.defects = {Defect::kGap};
      verdict.detail = fmt::format("{}: {}", name_of(Defect::kGap), added.error().message);
    }
  }
  if (!verdict.is_valid) book_.add_invalid(report);
  if (is_rejected) {
    book_.withdraw(session_, report.plan.attempt);
    is_kept = false;
  }
  if (rig != nullptr) settled_.push_back({std::move(trial), is_kept});
  output.verdicts.push_back({report, std::move(verdict)});
}

void IdentificationCore::settle_live() {
  for (const Settled& settled : std::exchange(settled_, {})) {
    const Rig* rig = rig_of(settled.trial.report.plan);
    if (auto done = live_.settle(settled.trial, settled.is_kept, rig->geometry); !done) {
      remarks_.push_back(fmt::format("not in live estimates: {}", done.error().message));
    }
  }
}

std::optional<ConditionEstimate> IdentificationCore::live(Clock::TimePoint now) {
  if (!has_live_news_ || now < live_due()) return std::nullopt;
  live_budget_ = std::min(kLiveBudget, live_budget_ + settings_.live_share * Seconds(now - live_budget_at_));
  live_budget_at_ = now;
  has_live_news_ = false;
  return live_.estimate();
}

Clock::TimePoint IdentificationCore::live_due() const {
  if (live_budget_ > Seconds::zero()) return live_budget_at_;
  return live_budget_at_ + std::chrono::ceil<Clock::Duration>(-live_budget_ / settings_.live_share);
}

Clock::TimePoint IdentificationCore::next_due(Clock::TimePoint now) const {
  if (!settled_.empty() || !remarks_.empty() || next_condition()) return now;
  Clock::TimePoint due = assembler_.next_due();
  for (const Held& held : held_) {
    if (!must_wait(held.trial)) return now;
    due = std::min(due, held.due);
    const bool waits_for_values = rig_of(held.trial.report.plan) != nullptr;
    if (waits_for_values) due = std::min(due, std::max(now, held.ask_at));
  }
  if (has_live_news_) due = std::min(due, std::max(now, live_due()));
  return due;
}

std::size_t IdentificationCore::queue_depth() const {
  return assembler_.waiting().size() + held_.size() + book_.changed().size();
}

const IdentificationCore::Rig* IdentificationCore::rig_of(const TrialPlan& plan) const {
  const auto rig = rigs_.find(plan.rig);
  return rig == rigs_.end() ? nullptr : &rig->second;
}

std::optional<Condition> IdentificationCore::next_condition() const {
  const auto waiting = assembler_.waiting();
  const auto is_same = [](const Condition& a, const Condition& b) { return !(a < b) && !(b < a); };
  for (const Condition& condition : book_.changed()) {
    const bool has_more = std::any_of(waiting.begin(), waiting.end(), [&](const TrialReport* report) {
      return is_same(condition, condition_of(report->plan)) ||
             is_same(condition, set_condition_of(report->plan));
    });
    if (!has_more) return condition;
  }
  return std::nullopt;
}

}  // namespace tonus::identification
