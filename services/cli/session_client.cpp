#include "services/cli/session_client.hpp"

#include <algorithm>
#include <set>
#include <spdlog/fmt/fmt.h>
#include <tuple>
#include <utility>

#include "idl/topics.hpp"
#include "services/contract/names.hpp"
#include "services/contract/review.hpp"
#include "services/runtime/drain.hpp"
#include "services/runtime/options.hpp"

namespace tonus::cli {
namespace {

constexpr std::chrono::milliseconds kLook{100};
constexpr std::chrono::milliseconds kAskAgain{500};

/// None where this end may not command.
template <typename T>
Result<std::optional<bus::TypedWriter<T>>> command_writer(bus::Bus& bus, const bus::Topic<T>& topic,
                                                          bool may_command) {
  std::optional<bus::TypedWriter<T>> writer;
  if (!may_command) return writer;
  TONUS_TRY_ASSIGN(writer, bus::TypedWriter<T>::create(bus, topic));
  return writer;
}

}  // namespace

Result<SessionClient> SessionClient::create(bus::Bus& bus, const Clock& clock,
                                            std::shared_ptr<bus::Notifier> notifier, bool may_command) {
  TONUS_TRY_ASSIGN(auto commands, command_writer(bus, topics::kSessionCommand, may_command));
  TONUS_TRY_ASSIGN(auto rig_commands, command_writer(bus, topics::kRigCommand, may_command));
  auto replies = bus::TypedReader<v1::SessionReply>::create(bus, topics::kSessionReply, notifier);
  if (!replies) return replies.error();
  auto states = bus::TypedReader<v1::SessionState>::create(bus, topics::kSessionState, notifier);
  if (!states) return states.error();
  auto estimates = bus::TypedReader<v1::Estimate>::create(bus, topics::kEstimateCondition, notifier);
  if (!estimates) return estimates.error();
  auto verdicts = bus::TypedReader<v1::TrialVerdict>::create(bus, topics::kTrialVerdict, notifier);
  if (!verdicts) return verdicts.error();
  TONUS_TRY_ASSIGN(auto reviews,
                   bus::TypedReader<v1::TrialReview>::create(bus, topics::kTrialReview, notifier));
  auto descriptions = bus::TypedReader<v1::RigDescription>::create(bus, topics::kRigDescription, notifier);
  if (!descriptions) return descriptions.error();
  TONUS_TRY_ASSIGN(auto rig_states, bus::TypedReader<v1::RigState>::create(bus, topics::kRigState, notifier));
  TONUS_TRY_ASSIGN(auto rig_replies,
                   bus::TypedReader<v1::RigReply>::create(bus, topics::kRigReply, notifier));
  auto roster = runtime::Roster::create(bus, clock, notifier);
  if (!roster) return roster.error();
  return SessionClient({std::move(commands), std::move(*replies), std::move(*states), std::move(*estimates),
                        std::move(*verdicts), std::move(reviews), std::move(*descriptions),
                        std::move(rig_states), std::move(rig_commands), std::move(rig_replies)},
                       std::move(*roster), clock, std::move(notifier));
}

SessionClient::SessionClient(Endpoints endpoints, runtime::Roster roster, const Clock& clock,
                             std::shared_ptr<bus::Notifier> notifier)
    : endpoints_(std::move(endpoints)),
      roster_(std::move(roster)),
      clock_(&clock),
      notifier_(std::move(notifier)) {}

void SessionClient::update() {
  roster_.update();
  for (auto& received : runtime::drain(endpoints_.descriptions)) rig_ = std::move(received.value);
  for (auto& received : runtime::drain(endpoints_.states)) {
    // A late joiner hears of sessions in any order: one that has ended does not hide one that goes on.
    const bool is_other = newest_state_ && newest_state_->session_id() != received.value.session_id();
    if (!is_other || !v1::is_over(received.value.phase()) || v1::is_over(newest_state_->phase()))
      newest_state_ = received.value;
    states_[received.value.session_id()] = std::move(received.value);
  }
  for (auto& received : runtime::drain(endpoints_.estimates)) {
    estimates_[received.value.estimate_id()] = std::move(received.value);
  }
  for (auto& received : runtime::drain(endpoints_.verdicts)) {
    verdicts_[received.value.trial_id()] = std::move(received.value);
  }
  for (auto& received : runtime::drain(endpoints_.reviews)) {
    reviews_[received.value.trial_id()] = std::move(received.value);
  }
  for (auto& received : runtime::drain(endpoints_.replies)) {
    replies_[received.value.request_id()] = {received.value.is_done(), received.value.message()};
  }
  for (auto& received : runtime::drain(endpoints_.rig_states)) {
    rig_states_[received.value.rig_id()] = std::move(received.value);
  }
  for (auto& received : runtime::drain(endpoints_.rig_replies)) {
    replies_[received.value.request_id()] = {received.value.is_done(), received.value.message()};
  }
}

Result<void> SessionClient::wait_for(const std::function<bool()>& done, std::chrono::milliseconds limit,
                                     const std::function<bool()>& interrupted) {
  const auto deadline = clock_->now() + limit;
  while (true) {
    update();
    if (done()) return {};
    if (interrupted && interrupted())
      return fail(ErrorCode::kUnavailable, std::string(runtime::kInterruptedText));
    if (clock_->now() >= deadline) {
      return fail(ErrorCode::kTimeout,
                  fmt::format("nothing after {:.1f} s", std::chrono::duration<double>(limit).count()));
    }
    (void)notifier_->wait_until(std::min(deadline, clock_->now() + kLook));
  }
}

template <typename Command>
Result<std::string> SessionClient::ask(std::optional<bus::TypedWriter<Command>>& writer, Command command,
                                       std::chrono::milliseconds limit, const char* who) {
  if (!writer) {
    return fail(ErrorCode::kInvalidArgument,
                "this host has a viewer's certificate only: it may read and stop; expected an operator's");
  }
  const Id id = random_id();
  command.request_id(id);
  if (command.requested_by().empty()) command.requested_by("command line");
  const auto deadline = clock_->now() + limit;
  while (clock_->now() < deadline) {
    // A command that finds the history full or no reader is sent again below.
    (void)writer->write(command);
    if (!wait_for([&] { return replies_.contains(id); }, kAskAgain)) continue;
    const auto& reply = replies_.at(id);
    if (!reply.is_done) return fail(ErrorCode::kInvalidArgument, reply.message);
    return reply.message;
  }
  return fail(ErrorCode::kTimeout,
              fmt::format("no {} answered within {:.1f} s; is `tonus up` running in this "
                          "domain?",
                          who, std::chrono::duration<double>(limit).count()));
}

Result<std::string> SessionClient::request(v1::SessionCommand command, std::chrono::milliseconds limit) {
  return ask(endpoints_.commands, std::move(command), limit, "scheduler");
}

Result<std::string> SessionClient::request(v1::RigCommand command, std::chrono::milliseconds limit) {
  return ask(endpoints_.rig_commands, std::move(command), limit, "rig agent");
}

const std::optional<v1::RigState>& SessionClient::rig_state(const Id& rig) const {
  static const std::optional<v1::RigState> kNone;
  const auto found = rig_states_.find(rig);
  return found == rig_states_.end() ? kNone : found->second;
}

const std::optional<v1::SessionState>& SessionClient::state(const Id& session) const {
  static const std::optional<v1::SessionState> kNone;
  const auto found = states_.find(session);
  return found == states_.end() ? kNone : found->second;
}

std::vector<v1::Estimate> SessionClient::estimates(const Id& session) const {
  std::vector<v1::Estimate> all;
  for (const auto& [id, estimate] : estimates_) {
    if (estimate.session_id() == session) all.push_back(estimate);
  }
  const auto order = [](const v1::Estimate& e) {
    return std::make_tuple(e.posture_index(), e.set_number(), e.instruction(), e.method(), e.model());
  };
  std::sort(all.begin(), all.end(), [&order](const auto& a, const auto& b) { return order(a) < order(b); });
  return all;
}

bool SessionClient::has_estimated_every_valid_trial(const Id& session) const {
  // Trials behind the estimates of single sets, of unloaded sets among them, and of all unloaded sets
  // together.
  std::set<std::uint32_t> in_sets;
  std::set<std::uint32_t> in_unloaded_sets;
  std::set<std::uint32_t> in_all_sets;
  bool is_loaded = false;
  for (const auto& [id, estimate] : estimates_) {
    if (estimate.session_id() != session) continue;
    const bool has_bias = estimate.bias_N()[0] != 0.0 || estimate.bias_N()[1] != 0.0;
    const bool is_single_set = estimate.set_number() != 0;
    is_loaded |= has_bias;
    for (const auto& trial : estimate.trials()) {
      (is_single_set ? in_sets : in_all_sets).insert(trial.attempt());
      if (is_single_set && !has_bias) in_unloaded_sets.insert(trial.attempt());
    }
  }
  // A loaded session shows its unloaded sets one by one, too.
  if (is_loaded && in_unloaded_sets != in_all_sets) return false;
  const auto& estimated = is_loaded ? in_sets : in_all_sets;
  std::size_t valid = 0;
  for (const auto& [id, verdict] : verdicts_) {
    if (verdict.session_id() != session || !verdict.is_valid()) continue;
    // An estimate with a trial that was rejected by hand is about to be revised.
    const bool counts = standing(verdict).is_valid();
    if (estimated.contains(verdict.attempt()) != counts) return false;
    valid += counts ? 1 : 0;
  }
  // Verdicts come from another service than the state, and the last ones may be behind it.
  const auto& known = state(session);
  return !known || valid >= known->counted();
}

v1::TrialVerdict SessionClient::standing(const v1::TrialVerdict& verdict) const {
  const auto review = reviews_.find(verdict.trial_id());
  return contract::standing_verdict(verdict, review == reviews_.end() ? nullptr : &review->second);
}

std::vector<v1::TrialVerdict> SessionClient::rejections(const Id& session) const {
  std::vector<v1::TrialVerdict> all;
  for (const auto& [id, verdict] : verdicts_) {
    if (verdict.session_id() != session) continue;
    if (auto held = standing(verdict); !held.is_valid()) all.push_back(std::move(held));
  }
  std::sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.attempt() < b.attempt(); });
  return all;
}

}  // namespace tonus::cli
