// What operators ask of a session, and what they are answered.

#include <algorithm>
#include <spdlog/fmt/fmt.h>

#include "services/contract/subject.hpp"
#include "services/scheduler/session_machine.hpp"

namespace tonus::scheduler {

Effects SessionMachine::on_command(const v1::SessionCommand& command) {
  const Id request = command.request_id();
  if (request == kNoId) {
    reply(command.session_id(), request, false, "a request needs an id that is not zero");
    return finish();
  }
  const LedgerState& s = ledger_.state();
  const auto is_same = [&](const auto& other) { return other.request_id == request; };
  const std::deque<record::Answered>* const both[] = {&s.answers, &refused_};
  for (const auto* answers : both) {
    if (const auto known = std::find_if(answers->begin(), answers->end(), is_same); known != answers->end()) {
      reply(command.session_id(), request, known->is_done, known->message);
      return finish();
    }
  }
  if (std::any_of(s.pending.begin(), s.pending.end(), is_same))
    return finish();  // its answer is still to come

  if (command.request() == v1::SESSION_START) {
    start(command);
    return finish();
  }
  const bool is_this = command.session_id() == kNoId || command.session_id() == s.started.session_id;
  if (!ledger_.has_session() || !is_this) {
    reply(command.session_id(), request, false,
          command.session_id() == kNoId
              ? "there is no session"
              : fmt::format("there is no session {}", to_hex(command.session_id())));
    return finish();
  }
  if (s.ended) {
    const bool is_done = command.request() == v1::SESSION_ABORT && s.ended->phase == v1::SESSION_ABORTED;
    reply(command.session_id(), request, is_done,
          fmt::format("the session has {}: {}", phase_name(s.ended->phase), s.ended->message));
    return finish();
  }
  switch (command.request()) {
    case v1::SESSION_PAUSE:
      pause(command);
      break;
    case v1::SESSION_RESUME:
      resume(command);
      break;
    case v1::SESSION_ABORT:
      abort(command);
      break;
    case v1::SESSION_REJECT_TRIAL:
      review(command);
      break;
    case v1::SESSION_NOTE:
      take_note(command);
      break;
    case v1::SESSION_START:
      break;
  }
  return finish();
}

void SessionMachine::start(const v1::SessionCommand& command) {
  const auto refuse = [&](const std::string& why) {
    refused_.push_back({command.request_id(), false, why});
    if (refused_.size() > LedgerState::kAnswersKept) refused_.pop_front();
    reply(command.session_id(), command.request_id(), false, why);
  };
  if (is_active()) {
    return refuse(fmt::format("session {} is {}: one session runs at a time",
                              to_hex(ledger_.state().started.session_id), phase_name(phase_)));
  }
  if (command.session_id() == kNoId) return refuse("session_id = 0 is not allowed: any other id");
  if (ledger_.has_session() && command.session_id() == ledger_.state().started.session_id) {
    return refuse(
        fmt::format("session {} has been: a new session needs a new id", to_hex(command.session_id())));
  }
  if (auto good = contract::check_people(command); !good) return refuse(good.error().message);
  const auto protocol = protocol::parse_protocol(command.protocol_toml(), "protocol");
  if (!protocol) return refuse(protocol.error().message);
  if (protocol->kind == protocol::ProtocolKind::kStudy) {
    return refuse(
        protocol::refuse_value(*protocol, "kind", "\"study\"", "a protocol of one session").message);
  }
  if (facts_) {
    if (auto good = protocol::check_against_rig(*protocol, *facts_); !good)
      return refuse(good.error().message);
  }

  ledger_ = Ledger{};
  decide(record::Started{command.session_id(), command.request_id(), command.protocol_toml(),
                         command.subject(), command.seed(), iso8601(clock_.utc_ns()), software_version_,
                         command.subject_facts(), command.requested_by(), command.study(),
                         command.is_pilot()});
  begin_session();
  authorise();
  answer(command.request_id(), true,
         fmt::format("{} trials planned, about {:.1f} min", ledger_.state().plan.trials.size(),
                     ledger_.state().expected_remaining / 60.0));
  advance();
}

void SessionMachine::pause(const v1::SessionCommand& command) {
  if (ledger_.state().is_abort_wanted)
    return answer(command.request_id(), false, "the session is being aborted");
  if (phase_ == v1::SESSION_COMPLETING) return answer(command.request_id(), false, "every trial is done");
  decide(record::Requested{command.request_id(), v1::SESSION_PAUSE});
  advance();  // answers once the session is paused
}

void SessionMachine::resume(const v1::SessionCommand& command) {
  const LedgerState& s = ledger_.state();
  if (s.is_abort_wanted) return answer(command.request_id(), false, "the session is being aborted");
  if (s.is_pause_wanted) {
    if (is_held()) return answer(command.request_id(), false, where_it_stands());
    answer_pending(v1::SESSION_PAUSE, false, "resumed before the session was paused");
    decide(record::Requested{command.request_id(), v1::SESSION_RESUME});
    authorise();
    advance();
    if (is_active()) answer(command.request_id(), true, where_it_stands());
    return;
  }
  if (hold_ && hold_->asks != Asks::kNobody) return acknowledge(command);
  answer(command.request_id(), phase_ == v1::SESSION_RUNNING, where_it_stands());
}

void SessionMachine::acknowledge(const v1::SessionCommand& command) {
  const LedgerState& s = ledger_.state();
  switch (hold_->asks) {
    case Asks::kNobody:
      break;
    case Asks::kAxesMissing:
      return answer(command.request_id(), false, where_it_stands());
    case Asks::kArming:
      break;
    case Asks::kLimit:
      decide(record::LimitRaised{static_cast<std::uint32_t>(s.block)});
      break;
    case Asks::kPosture:
      decide(record::PostureConfirmed{s.plan.blocks[s.block].posture_index});
      break;
    case Asks::kAxes:
      accepts_doubtful_axes_ = true;
      break;
    case Asks::kRefusal:
      refusals_ = 0;
      break;
    case Asks::kStuck:
      reject("given up by the operator while waiting for " + hold_->waiting_for, true);
      break;
  }
  decide(record::Requested{command.request_id(), v1::SESSION_RESUME});
  authorise();
  advance();
  if (is_active()) answer(command.request_id(), true, where_it_stands());
}

Effects SessionMachine::on_rig_reply(const v1::RigReply& rig_reply) {
  if (!is_active()) return finish();
  if (arm_id_ != kNoId && rig_reply.request_id() == arm_id_) {
    note_arming(rig_reply);
    advance();
  }
  if (ledger_.state().is_abort_wanted && rig_reply.request_id() == abort_id()) {
    end(v1::SESSION_ABORTED, "aborted by request");
  }
  return finish();
}

void SessionMachine::abort(const v1::SessionCommand& command) {
  decide(record::Requested{command.request_id(), v1::SESSION_ABORT});
  answer_pending(v1::SESSION_PAUSE, false, "the session is being aborted");
  advance();  // answers once the trial that runs has ended
}

Id SessionMachine::abort_id() const { return id_of(to_hex(flight_id_) + "/abort"); }

void SessionMachine::send_abort() {
  v1::RigCommand command;
  command.rig_id(ledger_.state().in_flight->rig_id());
  command.request_id(abort_id());
  command.request(v1::RIG_ABORT_TRIAL);
  command.trial_id(flight_id_);
  command.requested_by("scheduler");
  effects_.urgent.emplace_back(std::move(command));
  abort_at_ = clock_.now() + patience_.abort_repeat;
  ++abort_repeats_;
}

void SessionMachine::answer(const Id& request_id, bool is_done, const std::string& message) {
  decide(record::Answered{request_id, is_done, message});
  reply(ledger_.state().started.session_id, request_id, is_done, message);
}

void SessionMachine::answer_pending(v1::SessionRequest request, bool is_done, const std::string& message) {
  const auto pending = ledger_.state().pending;  // answering takes them off the list
  for (const auto& asked : pending) {
    if (asked.request == request) answer(asked.request_id, is_done, message);
  }
}

}  // namespace tonus::scheduler
