#include "services/scheduler/ledger.hpp"

#include <algorithm>
#include <spdlog/fmt/fmt.h>

#include "services/contract/review.hpp"

namespace tonus::scheduler {
namespace {

Error misfit(const std::string& what) { return fail(ErrorCode::kDataLoss, "journal: " + what); }

/// The attempt that a record settles, if it settles one.
std::optional<std::uint32_t> settled_attempt(const Record& record) {
  if (const auto* r = std::get_if<record::Counted>(&record)) return r->attempt;
  if (const auto* r = std::get_if<record::Rejected>(&record)) return r->attempt;
  if (const auto* r = std::get_if<record::Refused>(&record)) return r->attempt;
  return std::nullopt;
}

}  // namespace

Result<void> Ledger::apply(const Record& record) {
  if (const auto* started = std::get_if<record::Started>(&record)) return start(*started);
  if (auto good = check(record); !good) return good;
  std::visit([this](const auto& r) { take(r); }, record);
  return {};
}

Result<void> Ledger::start(const record::Started& started) {
  if (has_session_) return misfit("a session begins twice");
  auto protocol = protocol::parse_protocol(started.protocol_toml, "protocol");
  if (!protocol) return misfit(protocol.error().message);
  state_ = LedgerState{};
  state_.started = started;
  state_.protocol = std::move(*protocol);
  state_.plan = protocol::build_plan(state_.protocol, started.seed);
  for (const protocol::Block& block : state_.plan.blocks)
    state_.remaining.emplace_back(block.order.begin(), block.order.end());
  for (const protocol::PlannedTrial& trial : state_.plan.trials) state_.expected_remaining += trial.duration;
  state_.runs.assign(state_.plan.trials.size(), 0);
  state_.rejections.assign(state_.plan.blocks.size(), 0);
  state_.looks.resize(state_.plan.conditions.size());
  state_.drives.resize(state_.plan.conditions.size());
  state_.commands.assign(state_.plan.conditions.size(), 0);
  has_session_ = true;
  find_block();
  return {};
}

Result<void> Ledger::check(const Record& record) const {
  if (!has_session_) return misfit("a record before the session's start");
  if (const auto* r = std::get_if<record::Commanded>(&record)) {
    if (state_.in_flight)
      return misfit(fmt::format("attempt {} while another one runs", r->program.attempt()));
    if (r->program.attempt() != state_.attempts + 1) {
      return misfit(fmt::format("attempt {} after attempt {}", r->program.attempt(), state_.attempts));
    }
    const auto index = r->program.planned_index();
    if (index >= state_.plan.trials.size()) return misfit(fmt::format("no planned trial {}", index));
    const auto& left = state_.remaining[state_.plan.trials[index].block];
    if (std::find(left.begin(), left.end(), index) == left.end()) {
      return misfit(fmt::format("planned trial {} is done already", index));
    }
  }
  if (const auto attempt = settled_attempt(record)) {
    if (!state_.in_flight || state_.in_flight->attempt() != *attempt) {
      return misfit(fmt::format("attempt {} ends, but does not run", *attempt));
    }
  }
  if (const auto* r = std::get_if<record::Rejected>(&record)) {
    const auto& left = state_.remaining[state_.plan.trials[state_.in_flight->planned_index()].block];
    if (r->place != record::Rejected::kSetAside &&
        (r->place < 0 || r->place > static_cast<int>(left.size()))) {
      return misfit(
          fmt::format("place {} for a repeat is not allowed; expected 0 to {}", r->place, left.size()));
    }
  }
  if (const auto* r = std::get_if<record::LimitRaised>(&record);
      r != nullptr && r->block >= state_.rejections.size()) {
    return misfit(fmt::format("no set {}", r->block));
  }
  if (const auto* r = std::get_if<record::Looked>(&record)) {
    if (!state_.protocol.stop_when || r->condition >= state_.looks.size())
      return misfit(fmt::format("no condition {} that is looked at", r->condition));
    if (!state_.counted_trials.contains(r->newest))
      return misfit(fmt::format("a look after attempt {}, which does not count", r->newest));
  }
  if (const auto* r = std::get_if<record::Reviewed>(&record)) return check(*r);
  return {};
}

Result<void> Ledger::check(const record::Reviewed& reviewed) const {
  const auto counted = state_.counted_trials.find(reviewed.attempt);
  if (counted == state_.counted_trials.end() || counted->second != reviewed.planned_index)
    return misfit(fmt::format("attempt {} is rejected by hand, but does not count", reviewed.attempt));
  const auto& left = state_.remaining[state_.plan.trials[reviewed.planned_index].block];
  if (reviewed.place != record::Rejected::kSetAside &&
      (reviewed.place < 0 || reviewed.place > static_cast<int>(left.size())))
    return misfit(
        fmt::format("place {} for a repeat is not allowed; expected 0 to {}", reviewed.place, left.size()));
  return {};
}

void Ledger::find_block() {
  const std::size_t blocks = state_.plan.blocks.size();
  const auto first_of = [&](const auto& suits) {
    std::size_t block = 0;
    while (block < blocks && !(state_.is_open(block) && suits(block))) ++block;
    return block;
  };
  state_.block = blocks;
  if (state_.last_block) {
    const auto posture = state_.plan.blocks[*state_.last_block].posture_index;
    state_.block = first_of([&](std::size_t block) { return block == state_.last_block; });
    if (state_.block == blocks) {
      state_.block =
          first_of([&](std::size_t block) { return state_.plan.blocks[block].posture_index == posture; });
    }
  }
  if (state_.block == blocks) state_.block = first_of([](std::size_t) { return true; });
}

void Ledger::take(const record::Bound& bound) {
  state_.bound = bound;
  protocol::bind_rig(state_.plan, state_.protocol, bound.rig_id, {bound.home[0], bound.home[1]});
}

void Ledger::take(const record::Commanded& commanded) {
  const std::uint32_t index = commanded.program.planned_index();
  state_.in_flight = commanded.program;
  state_.attempts = commanded.program.attempt();
  ++state_.runs[index];
  state_.last_block = state_.plan.trials[index].block;
  auto& left = state_.remaining[*state_.last_block];
  left.erase(std::find(left.begin(), left.end(), index));
  if (state_.protocol.stop_when) {
    const std::uint32_t condition = state_.condition_of(index);
    state_.directions.push_back(
        static_cast<std::uint32_t>(protocol::direction_of(state_.protocol, commanded.program)));
    state_.amplitudes.push_back(commanded.program.amplitude_m());
    state_.drives[condition] = {commanded.program.amplitude_m(), commanded.program.rise_time_s()};
    ++state_.commands[condition];
  }
  find_block();
}

void Ledger::settle(double duration, bool is_done) {
  const double expected = state_.plan.trials[state_.in_flight->planned_index()].duration;
  state_.experiment += duration;
  state_.expected_settled += expected;
  if (is_done) state_.expected_remaining -= expected;
  state_.in_flight.reset();
  find_block();
}

void Ledger::take(const record::Counted& counted) {
  const protocol::Block& block =
      state_.plan.blocks[state_.plan.trials[state_.in_flight->planned_index()].block];
  if (block.set_number == 1) state_.set_one[block.posture_index].insert(counted.attempt);
  state_.counted_trials[counted.attempt] = state_.in_flight->planned_index();
  ++state_.counted;
  settle(counted.duration, true);
}

void Ledger::take(const record::Rejected& rejected) {
  const std::uint32_t index = state_.in_flight->planned_index();
  const std::uint32_t block = state_.plan.trials[index].block;
  const bool is_set_aside = rejected.place == record::Rejected::kSetAside;
  if (!is_set_aside) {
    auto& left = state_.remaining[block];
    left.insert(left.begin() + rejected.place, index);
  }
  if (rejected.owes_receipt) state_.owed_receipts.insert(rejected.attempt);
  if (rejected.is_reviewed)
    state_.reviews.push_back({rejected.attempt, index, rejected.place, rejected.reason,
                              std::string(contract::kTheScheduler), rejected.reviewed_ns});
  ++state_.rejected;
  ++(is_set_aside ? state_.set_aside : state_.rejections[block]);
  settle(rejected.duration, is_set_aside);
}

void Ledger::take(const record::Refused&) {
  const std::uint32_t index = state_.in_flight->planned_index();
  state_.remaining[state_.plan.trials[index].block].push_front(index);
  state_.in_flight.reset();
  find_block();
}

void Ledger::take(const record::Receipted& receipted) { state_.owed_receipts.erase(receipted.attempt); }

void Ledger::take(const record::AxesFixed& fixed) {
  state_.axes[fixed.posture_index] = {{fixed.major[0], fixed.major[1]}, {fixed.minor[0], fixed.minor[1]}};
}

void Ledger::take(const record::PostureConfirmed& confirmed) {
  state_.confirmed_postures = {confirmed.posture_index};
}

void Ledger::take(const record::LimitRaised& raised) { state_.rejections[raised.block] = 0; }

void Ledger::take(const record::Requested& requested) {
  if (requested.request == v1::SESSION_PAUSE) state_.is_pause_wanted = true;
  if (requested.request == v1::SESSION_RESUME) state_.is_pause_wanted = false;
  if (requested.request == v1::SESSION_ABORT) state_.is_abort_wanted = true;
  if (requested.request_id != kNoId) state_.pending.push_back(requested);
}

void Ledger::take(const record::Answered& answered) {
  std::erase_if(state_.pending,
                [&](const auto& request) { return request.request_id == answered.request_id; });
  state_.answers.push_back(answered);
  if (state_.answers.size() > LedgerState::kAnswersKept) state_.answers.pop_front();
}

void Ledger::take(const record::Ended& ended) { state_.ended = ended; }

void Ledger::take(const record::Looked& looked) {
  state_.looks[looked.condition].push_back(looked);
  state_.drives[looked.condition] = {looked.amplitude, looked.rise_time};
  find_block();
}

std::vector<std::uint32_t> LedgerState::counted_in(std::uint32_t condition) const {
  std::vector<std::uint32_t> found;
  for (const auto& [attempt, index] : counted_trials) {
    if (condition_of(index) == condition) found.push_back(attempt);
  }
  return found;
}

std::vector<record::Looked> LedgerState::standing_looks(std::uint32_t condition) const {
  if (condition == protocol::kNoCondition) return {};
  std::vector<record::Looked> standing;
  const auto now = counted_in(condition);
  for (const record::Looked& look : looks[condition]) {
    // Later attempts have higher numbers: of those up to the look's newest, trials are only taken away.
    const auto left = std::upper_bound(now.begin(), now.end(), look.newest) - now.begin();
    if (left == static_cast<std::ptrdiff_t>(look.counted)) standing.push_back(look);
  }
  return standing;
}

bool LedgerState::is_ended_by_look(std::uint32_t condition) const {
  const auto standing = standing_looks(condition);
  return !standing.empty() && standing.back().end != protocol::LookEnd::kGoesOn &&
         standing.back().counted == counted_in(condition).size();
}

protocol::Drive LedgerState::first_drive(std::uint32_t condition) const {
  const protocol::Drive own{protocol.perturbation.amplitude, protocol.perturbation.rise_time};
  if (condition == 0) return own;
  const auto before = standing_looks(condition - 1);
  if (before.empty()) return own;
  return protocol::drive_after(*protocol.stop_when, own, drives[condition - 1], looks_of(before));
}

void Ledger::take(const record::Reviewed& reviewed) {
  const std::uint32_t block = state_.plan.trials[reviewed.planned_index].block;
  state_.counted_trials.erase(reviewed.attempt);
  state_.set_one[state_.plan.blocks[block].posture_index].erase(reviewed.attempt);
  --state_.counted;
  ++state_.rejected;
  if (reviewed.place == record::Rejected::kSetAside) {
    ++state_.set_aside;
  } else {
    auto& left = state_.remaining[block];
    left.insert(left.begin() + reviewed.place, reviewed.planned_index);
    state_.expected_remaining += state_.plan.trials[reviewed.planned_index].duration;
  }
  state_.reviews.push_back(reviewed);
  const auto before = next_posture();
  find_block();
  // The hand may be on its way to where the session was about to go: who goes back is asked again.
  const auto after = next_posture();
  const bool is_hand_there = state_.in_flight && state_.in_flight->posture_index() == after;
  if (before != after && !is_hand_there) state_.confirmed_postures.clear();
}

void Ledger::take(const record::Noted& noted) { state_.notes.push_back(noted); }

std::optional<std::uint32_t> Ledger::next_posture() const {
  if (state_.block >= state_.plan.blocks.size()) return std::nullopt;
  return state_.plan.blocks[state_.block].posture_index;
}

}  // namespace tonus::scheduler
