// Precision-led conditions: when an estimate is looked at, and how far conditions are.

#include <algorithm>
#include <cmath>
#include <limits>
#include <spdlog/fmt/fmt.h>

#include "services/protocol/estimate_look.hpp"
#include "services/scheduler/session_machine.hpp"

namespace tonus::scheduler {
namespace {

constexpr std::size_t kProgressMost = 64;  // of the message
constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
// In a state: not finite, and equal to itself, so that a state that has not changed is not sent again.
constexpr double kNone = std::numeric_limits<double>::infinity();

double known(double value) { return std::isfinite(value) ? value : kNone; }

/// The trials of an estimate are of these attempts alone, the newest among them. The estimator may leave
/// others out. Of an unbiased set there may be no estimate but that of all such sets: the trials tell.
bool is_of(const v1::Estimate& estimate, const std::vector<std::uint32_t>& attempts) {
  bool has_newest = false;
  for (const v1::TrialRange& trial : estimate.trials()) {
    if (!std::binary_search(attempts.begin(), attempts.end(), trial.attempt())) return false;
    has_newest |= trial.attempt() == attempts.back();
  }
  return has_newest;
}

}  // namespace

std::optional<std::uint32_t> SessionMachine::condition_to_look_at() const {
  const LedgerState& s = ledger_.state();
  if (!s.protocol.stop_when) return std::nullopt;
  for (std::uint32_t c = 0; c < s.plan.conditions.size(); ++c) {
    const auto counted = s.counted_in(c);
    if (counted.size() < static_cast<std::size_t>(s.protocol.stop_when->trials_least)) continue;
    if (s.looks[c].empty() || s.looks[c].back().newest != counted.back()) return c;
  }
  return std::nullopt;
}

const v1::Estimate* SessionMachine::estimate_of(std::uint32_t condition) const {
  const LedgerState& s = ledger_.state();
  const protocol::PlannedCondition& planned = s.plan.conditions[condition];
  const auto attempts = s.counted_in(condition);
  for (const auto& [id, estimate] : estimates_) {
    if (estimate.posture_index() != planned.posture_index) continue;
    if (estimate.method() != s.protocol.stop_when->method || estimate.model() != "linear") continue;
    if (is_of(estimate, attempts)) return &estimate;
  }
  return nullptr;
}

std::optional<SessionMachine::Hold> SessionMachine::hold_for_look() {
  while (const auto condition = condition_to_look_at()) {
    const v1::Estimate* estimate = estimate_of(*condition);
    if (estimate == nullptr && !roster_missing_.empty()) {
      look_due_.reset();
      return service_hold(roster_missing_);
    }
    if (!look_due_) look_due_ = clock_.now() + patience_.estimate;
    if (estimate == nullptr && clock_.now() < *look_due_) return hold_for_estimate(*condition);
    look_due_.reset();
    look(*condition, estimate);
  }
  look_due_.reset();
  return std::nullopt;
}

SessionMachine::Hold SessionMachine::hold_for_estimate(std::uint32_t condition) const {
  const LedgerState& s = ledger_.state();
  // It mostly comes with the verdict: at first the session runs on.
  if (clock_.now() < *look_due_ - patience_.estimate + patience_.answer)
    return {v1::SESSION_RUNNING, "", Asks::kNobody};
  return {
      v1::SESSION_WAITING,
      fmt::format("identification: estimate of '{}' by {} from {} trials; after {:g} s the session goes on "
                  "without it",
                  s.plan.postures[s.plan.conditions[condition].posture_index].name(),
                  s.protocol.stop_when->method, s.counted_in(condition).size(),
                  std::chrono::duration<double>(patience_.estimate).count()),
      Asks::kNobody};
}

void SessionMachine::look(std::uint32_t condition, const v1::Estimate* estimate) {
  const LedgerState& s = ledger_.state();
  const auto& rule = *s.protocol.stop_when;
  const auto counted = s.counted_in(condition);
  protocol::Look seen{counted.size(), kUnknown, kUnknown, kUnknown, false, false};
  if (estimate != nullptr) seen = protocol::look_at(*estimate);
  seen.trials = counted.size();
  auto looks = looks_of(s.looks[condition]);
  looks.push_back(seen);
  const protocol::Ruling ruling = protocol::ruling_on(rule, looks);
  const protocol::Drive own{s.protocol.perturbation.amplitude, s.protocol.perturbation.rise_time};
  const protocol::Drive now = s.drives[condition];
  const protocol::Drive next =
      estimate == nullptr ? now : protocol::next_drive(rule, own, now, trials_at(condition, now), looks);
  record::Looked looked{condition,
                        counted.back(),
                        static_cast<std::uint32_t>(counted.size()),
                        kNoId,
                        static_cast<std::uint32_t>(seen.trials),
                        seen.stiffness,
                        seen.mass,
                        seen.damping,
                        seen.is_ok,
                        seen.is_linear,
                        ruling.end,
                        ruling.needed,
                        ruling.because,
                        next.amplitude,
                        next.rise_time};
  if (estimate != nullptr) looked.estimate_id = estimate->estimate_id();
  const std::string& posture = s.plan.postures[s.plan.conditions[condition].posture_index].name();
  if (estimate == nullptr)
    message_ = fmt::format("'{}': no estimate by {} came in time", posture, rule.method);
  else if (!ruling.because.empty())
    message_ = fmt::format("'{}': {}", posture, ruling.because);
  decide(std::move(looked));
}

std::size_t SessionMachine::trials_at(std::uint32_t condition, const protocol::Drive& drive) const {
  // Looks tell which trials were run with which drive: the drive of a look is that of the next trial.
  const auto& looks = ledger_.state().looks[condition];
  std::size_t trials = 0;
  for (auto look = looks.rbegin(); look != looks.rend() && look->amplitude == drive.amplitude; ++look)
    ++trials;
  const bool is_from_start = trials == looks.size();
  return is_from_start ? ledger_.state().counted_in(condition).size() : trials;
}

void SessionMachine::steer_next(std::uint32_t condition, v1::TrialProgram& program) const {
  const LedgerState& s = ledger_.state();
  std::vector<int> counts(static_cast<std::size_t>(s.protocol.perturbation.directions), 0);
  for (const std::uint32_t attempt : s.counted_in(condition)) ++counts[s.directions[attempt - 1]];
  const auto direction =
      protocol::drawn_direction(s.protocol, s.started.seed, condition, s.commands[condition], counts);
  const protocol::Drive drive = s.commands[condition] == 0 ? s.first_drive(condition) : s.drives[condition];
  protocol::steer(s.protocol, direction, drive, program);
}

v1::ConditionProgress SessionMachine::progress_of(std::uint32_t condition) const {
  const LedgerState& s = ledger_.state();
  const protocol::PlannedCondition& planned = s.plan.conditions[condition];
  const auto counted = s.counted_in(condition);
  v1::ConditionProgress progress;
  progress.posture(s.plan.postures[planned.posture_index].name());
  progress.posture_index(planned.posture_index);
  progress.set_number(planned.set_number);
  if (planned.instruction_index < s.protocol.instructions.size())
    progress.instruction(s.protocol.instructions[planned.instruction_index].name);
  progress.counted(static_cast<std::uint32_t>(counted.size()));
  progress.planned(planned.trials);
  progress.precision(precision_of(condition));
  progress.precision_goal(s.protocol.stop_when ? s.protocol.stop_when->stiffness : 0.0);
  const bool is_by_look = s.is_ended_by_look(condition);
  progress.is_finished(is_by_look || left_in(condition) == 0);
  if (is_by_look) {
    progress.finished_because(s.looks[condition].back().because);
  } else if (progress.is_finished()) {
    progress.finished_because(counted.size() == planned.trials
                                  ? std::string("every planned trial counts")
                                  : fmt::format("{} of {} trials could not be used",
                                                planned.trials - counted.size(), planned.trials));
  }
  return progress;
}

double SessionMachine::precision_of(std::uint32_t condition) const {
  const LedgerState& s = ledger_.state();
  if (s.protocol.stop_when)
    return s.looks[condition].empty() ? kNone : known(s.looks[condition].back().stiffness);
  const protocol::PlannedCondition& planned = s.plan.conditions[condition];
  double precision = kNone;
  std::uint32_t trials = 0;
  for (const auto& [id, estimate] : estimates_) {
    const bool is_this = estimate.posture_index() == planned.posture_index &&
                         estimate.set_number() == planned.set_number && estimate.model() == "linear" &&
                         (s.protocol.kind == protocol::ProtocolKind::kRecording ||
                          estimate.instruction() == s.protocol.instructions[planned.instruction_index].name);
    const bool is_better = estimate.trials_used() > trials ||
                           (estimate.trials_used() == trials && estimate.method() == "refined");
    if (!is_this || !is_better) continue;
    trials = estimate.trials_used();
    precision = known(protocol::look_at(estimate).stiffness);
  }
  return precision;
}

std::uint32_t SessionMachine::left_in(std::uint32_t condition) const {
  const LedgerState& s = ledger_.state();
  if (s.is_ended_by_look(condition)) return 0;
  std::size_t left = s.in_flight && s.condition_of(s.in_flight->planned_index()) == condition ? 1 : 0;
  for (std::size_t block = 0; block < s.plan.blocks.size(); ++block) {
    if (s.plan.blocks[block].condition == condition) left += s.remaining[block].size();
  }
  return static_cast<std::uint32_t>(left);
}

std::uint32_t SessionMachine::expected_left_in(std::uint32_t condition) const {
  const LedgerState& s = ledger_.state();
  const std::uint32_t left = left_in(condition);
  if (!s.protocol.stop_when || left == 0) return left;
  // A condition without looks is expected to take as many as those before it.
  double needed = kUnknown;
  if (!s.looks[condition].empty()) {
    needed = s.looks[condition].back().needed;
  } else {
    double sum = 0.0;
    double ended = 0.0;
    for (std::uint32_t c = 0; c < s.plan.conditions.size(); ++c) {
      if (!s.is_ended_by_look(c)) continue;
      sum += s.looks[c].back().counted;
      ended += 1.0;
    }
    if (ended > 0.0) needed = sum / ended;
  }
  if (!std::isfinite(needed)) return left;
  const double missing = std::ceil(needed) - static_cast<double>(s.counted_in(condition).size());
  return static_cast<std::uint32_t>(std::clamp(missing, 1.0, static_cast<double>(left)));
}

void SessionMachine::describe_conditions(v1::SessionState& state) const {
  const LedgerState& s = ledger_.state();
  const std::size_t all = s.plan.conditions.size();
  const std::size_t now =
      s.block < s.plan.blocks.size() ? s.plan.blocks[s.block].condition : (all > 0 ? all - 1 : 0);
  const std::size_t first = now < kProgressMost ? 0 : now - kProgressMost + 1;
  double trials = 0.0;
  double expected = 0.0;
  for (std::size_t c = 0; c < all; ++c) {
    const auto condition = static_cast<std::uint32_t>(c);
    trials += left_in(condition);
    expected += expected_left_in(condition);
    if (c >= first && c < first + kProgressMost) state.conditions().push_back(progress_of(condition));
  }
  if (!s.protocol.stop_when) return;
  state.planned(s.counted + static_cast<std::uint32_t>(expected));
  state.remaining_s(trials > 0.0 ? state.remaining_s() * expected / trials : 0.0);
}

}  // namespace tonus::scheduler
