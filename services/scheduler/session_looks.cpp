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

double known(double value) {
  if (std::isfinite(value)) return value;
  return kNone;
}

/// Of the condition's trials, how many an estimate leaves out; none: it has others too, or not the newest, so
/// that it is of another time or condition. Of an unbiased set there may be no estimate but that of all such
/// sets: the trials tell.
std::optional<std::size_t> left_out_of(const v1::Estimate& estimate,
                                       const std::vector<std::uint32_t>& attempts) {
  bool has_newest = false;
  for (const v1::TrialRange& trial : estimate.trials()) {
    if (!std::binary_search(attempts.begin(), attempts.end(), trial.attempt())) return std::nullopt;
    has_newest |= trial.attempt() == attempts.back();
  }
  if (!has_newest) return std::nullopt;
  return attempts.size() - std::min(estimate.trials().size(), attempts.size());
}

}  // namespace

std::string SessionMachine::name_of(std::uint32_t condition) const {
  const LedgerState& s = ledger_.state();
  const protocol::PlannedCondition& planned = s.plan.conditions[condition];
  std::string name = fmt::format("'{}'", s.plan.postures[planned.posture_index].name());
  if (planned.set_number != 0) name += fmt::format(" set {}", planned.set_number);
  const std::string& instruction = s.protocol.instructions[planned.instruction_index].name;
  if (!instruction.empty()) name += fmt::format(" ({})", instruction);
  return name;
}

std::optional<std::uint32_t> SessionMachine::condition_to_look_at() const {
  const LedgerState& s = ledger_.state();
  if (!s.protocol.stop_when) return std::nullopt;
  for (std::uint32_t c = 0; c < s.plan.conditions.size(); ++c) {
    const auto counted = s.counted_in(c);
    if (counted.size() < static_cast<std::size_t>(s.protocol.stop_when->trials_least)) continue;
    const auto standing = s.standing_looks(c);
    if (standing.empty() || standing.back().counted != counted.size()) return c;
  }
  return std::nullopt;
}

SessionMachine::Seen SessionMachine::estimate_of(std::uint32_t condition) const {
  const LedgerState& s = ledger_.state();
  const protocol::PlannedCondition& planned = s.plan.conditions[condition];
  const auto attempts = s.counted_in(condition);
  Seen best;
  for (const auto& [id, estimate] : estimates_) {
    if (estimate.posture_index() != planned.posture_index) continue;
    if (estimate.method() != s.protocol.stop_when->method || estimate.model() != "linear") continue;
    const auto left_out = left_out_of(estimate, attempts);
    if (!left_out || (best.estimate != nullptr && *left_out >= best.left_out)) continue;
    best = {&estimate, *left_out};
  }
  return best;
}

std::optional<SessionMachine::Hold> SessionMachine::hold_for_look() {
  const auto least = static_cast<std::size_t>(
      ledger_.state().protocol.stop_when ? ledger_.state().protocol.stop_when->trials_least : 0);
  while (const auto condition = condition_to_look_at()) {
    const Seen seen = estimate_of(*condition);
    const bool is_whole = seen.estimate != nullptr && seen.left_out == 0;
    if (!is_whole && !roster_missing_.empty()) {
      look_due_.reset();
      return service_hold(roster_missing_);
    }
    if (!look_due_) look_due_ = clock_.now() + patience_.estimate;
    if (!is_whole && clock_.now() < *look_due_) return hold_for_estimate(*condition);
    look_due_.reset();
    // Made without some of the trials it is looked at, too, but only with as many as a first look asks for.
    const bool is_enough = seen.estimate != nullptr && seen.estimate->trials().size() >= least;
    look(*condition, is_enough ? seen.estimate : nullptr);
  }
  look_due_.reset();
  return std::nullopt;
}

SessionMachine::Hold SessionMachine::hold_for_estimate(std::uint32_t condition) const {
  const LedgerState& s = ledger_.state();
  // It mostly comes with the verdict: at first the session runs on.
  if (clock_.now() < *look_due_ - patience_.estimate + patience_.answer)
    return {v1::SESSION_RUNNING, "", Asks::kNobody};
  return {v1::SESSION_WAITING,
          fmt::format("identification: estimate of {} by {} from {} trials; after {:g} s the session goes on "
                      "without it",
                      name_of(condition), s.protocol.stop_when->method, s.counted_in(condition).size(),
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
  auto looks = looks_of(s.standing_looks(condition));
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
  if (estimate == nullptr)
    message_ = fmt::format("{}: no estimate by {} came in time", name_of(condition), rule.method);
  else if (!ruling.because.empty())
    message_ = fmt::format("{}: {}", name_of(condition), ruling.because);
  decide(std::move(looked));
}

std::size_t SessionMachine::trials_at(std::uint32_t condition, const protocol::Drive& drive) const {
  const LedgerState& s = ledger_.state();
  const auto counted = s.counted_in(condition);
  return static_cast<std::size_t>(std::ranges::count_if(
      counted, [&](std::uint32_t attempt) { return s.amplitudes[attempt - 1] == drive.amplitude; }));
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
    progress.finished_because(s.standing_looks(condition).back().because);
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
  if (s.protocol.stop_when) {
    const auto looks = s.standing_looks(condition);
    return looks.empty() ? kNone : known(looks.back().stiffness);
  }
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
  if (const auto looks = s.standing_looks(condition); !looks.empty()) {
    needed = looks.back().needed;
  } else {
    double sum = 0.0;
    double ended = 0.0;
    for (std::uint32_t c = 0; c < s.plan.conditions.size(); ++c) {
      if (!s.is_ended_by_look(c)) continue;
      sum += static_cast<double>(s.counted_in(c).size());
      ended += 1.0;
    }
    if (ended > 0.0) needed = sum / ended;
  }
  if (!std::isfinite(needed)) return left;
  const double missing = std::ceil(needed) - static_cast<double>(s.counted_in(condition).size());
  return static_cast<std::uint32_t>(std::clamp(missing, 1.0, static_cast<double>(left)));
}

std::string SessionMachine::goals_missed() const {
  const LedgerState& s = ledger_.state();
  if (!s.protocol.stop_when) return {};
  std::vector<std::string> missed;
  for (std::uint32_t c = 0; c < s.plan.conditions.size(); ++c) {
    const auto looks = s.standing_looks(c);
    if (!looks.empty() && looks.back().end == protocol::LookEnd::kReached) continue;
    missed.push_back(name_of(c));
  }
  if (missed.empty()) return {};
  return fmt::format("; goals not reached at {} of {} conditions: {}", missed.size(),
                     s.plan.conditions.size(), fmt::join(missed, ", "));
}

void SessionMachine::describe_conditions(v1::SessionState& state) const {
  const LedgerState& s = ledger_.state();
  const std::size_t all = s.plan.conditions.size();
  const std::size_t last = all > 0 ? all - 1 : 0;
  const std::size_t in_block = s.block < s.plan.blocks.size() ? s.plan.blocks[s.block].condition : last;
  const std::size_t now = in_block == protocol::kNoCondition ? 0 : in_block;
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
