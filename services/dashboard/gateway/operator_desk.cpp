#include "services/dashboard/gateway/operator_desk.hpp"

#include <algorithm>
#include <spdlog/fmt/fmt.h>

namespace tonus::dashboard {
namespace {

constexpr std::size_t kAnswersKept = 256;
constexpr std::size_t kMaximumWaiting = 256;
constexpr std::chrono::seconds kIdle{3600};

bool is_stop(const OperatorCommand& command) {
  const auto* rig = std::get_if<v1::RigCommand>(&command);
  return rig != nullptr && rig->request() == v1::RIG_EMERGENCY_STOP;
}

bool waits_for_a_trial(const OperatorCommand& command) {
  const auto* session = std::get_if<v1::SessionCommand>(&command);
  return session != nullptr &&
         (session->request() == v1::SESSION_PAUSE || session->request() == v1::SESSION_ABORT);
}

const char* who_answers(const OperatorCommand& command) {
  return std::holds_alternative<v1::RigCommand>(command) ? "rig" : "scheduler";
}

void put_stops_first(std::vector<OperatorCommand>& commands) {
  std::stable_partition(commands.begin(), commands.end(), is_stop);
}

}  // namespace

OperatorDesk::Effects OperatorDesk::ask(OperatorRequest request) {
  Effects effects;
  const auto is_same = [&](const OperatorReply& reply) { return reply.id == request.id; };
  if (const auto known = std::find_if(answered_.begin(), answered_.end(), is_same);
      known != answered_.end()) {
    effects.replies.push_back(*known);
    return effects;
  }
  if (waiting_.contains(request.id)) return effects;
  if (waiting_.size() >= kMaximumWaiting && !is_stop(request.command)) {
    effects.replies.push_back({request.id, request.name, false,
                               fmt::format("{} requests wait for their answers already", waiting_.size()),
                               request.requested_by});
    return effects;
  }
  const auto limit = waits_for_a_trial(request.command) ? patience_.limit_of_pause : patience_.limit;
  const Id id = request.id;
  waiting_[id] = {std::move(request), clock_.now(), clock_.now() + limit};
  return tick();
}

OperatorDesk::Effects OperatorDesk::on_reply(const Id& request, bool is_done, const std::string& message) {
  Effects effects;
  const auto found = waiting_.find(request);
  if (found == waiting_.end()) return effects;
  finish(effects, found->second, is_done, message);
  waiting_.erase(found);
  return effects;
}

OperatorDesk::Effects OperatorDesk::tick() {
  Effects effects;
  const auto now = clock_.now();
  for (auto it = waiting_.begin(); it != waiting_.end();) {
    Waiting& waiting = it->second;
    const OperatorCommand& command = waiting.request.command;
    if (now >= waiting.give_up_at) {
      finish(
          effects, waiting, false,
          fmt::format("no {} answered {}; it may still be done", who_answers(command), waiting.request.name));
      it = waiting_.erase(it);
      continue;
    }
    if (now >= waiting.send_at) {
      effects.commands.push_back(command);
      waiting.send_at = now + (is_stop(command) ? patience_.repeat_stop : patience_.repeat);
    }
    ++it;
  }
  put_stops_first(effects.commands);
  return effects;
}

Clock::TimePoint OperatorDesk::due() const {
  auto due = clock_.now() + kIdle;
  for (const auto& [id, waiting] : waiting_) due = std::min({due, waiting.send_at, waiting.give_up_at});
  return due;
}

void OperatorDesk::finish(Effects& effects, const Waiting& waiting, bool is_done,
                          const std::string& message) {
  OperatorReply reply{waiting.request.id, waiting.request.name, is_done, message,
                      waiting.request.requested_by};
  answered_.push_back(reply);
  if (answered_.size() > kAnswersKept) answered_.pop_front();
  effects.replies.push_back(std::move(reply));
}

}  // namespace tonus::dashboard
