#include "tests/fault/simulator/operator.hpp"

#include <algorithm>
#include <utility>

#include "idl/topics.hpp"
#include "services/contract/names.hpp"
#include "services/contract/subject.hpp"
#include "services/core/name.hpp"
#include "services/runtime/drain.hpp"
#include "tests/support/needed.hpp"

namespace tonus::simulator {
namespace {

constexpr std::chrono::milliseconds kLook{50};
constexpr std::chrono::milliseconds kRepeatStop{5};
constexpr std::chrono::milliseconds kBetweenActs{1500};
constexpr const char* kName = "operator";

}  // namespace

using testing::needed;

Operator::Operator(Network& network, std::shared_ptr<Life> life, Random& random, std::string protocol,
                   std::function<void()> granted)
    : life_(std::move(life)),
      random_(random),
      protocol_(std::move(protocol)),
      granted_(std::move(granted)),
      bus_(network.join(life_)),
      commands_(needed(bus::TypedWriter<v1::SessionCommand>::create(*bus_, topics::kSessionCommand))),
      rig_commands_(needed(bus::TypedWriter<v1::RigCommand>::create(*bus_, topics::kRigCommand))),
      stops_(needed(bus::TypedWriter<v1::RigStop>::create(*bus_, topics::kRigStop))),
      states_(needed(bus::TypedReader<v1::SessionState>::create(*bus_, topics::kSessionState, nullptr))),
      rig_states_(needed(bus::TypedReader<v1::RigState>::create(*bus_, topics::kRigState, nullptr))),
      stopped_(needed(bus::TypedReader<v1::RigStop>::create(*bus_, topics::kRigStopped, nullptr))),
      session_id_(new_id()) {}

Id Operator::new_id() {
  Id id;
  for (auto& byte : id) byte = static_cast<std::uint8_t>(random_.next());
  return id;
}

bool Operator::is_over() const { return session_ && v1::is_over(session_->phase()); }

void Operator::hear() {
  for (auto& heard : runtime::drain(states_))
    if (heard.value.session_id() == session_id_) session_ = std::move(heard.value);
  for (auto& heard : runtime::drain(rig_states_)) rig_ = std::move(heard.value);
  for (const auto& heard : runtime::drain(stopped_))
    if (heard.value.stop_id() == stop_id_) stops_left_ = 0;
}

Time Operator::step() {
  hear();
  const Time now = life_->clock.now();
  if (stops_left_ > 0) {
    repeat_stop();
    return now + kRepeatStop;
  }
  if (now >= act_at_) act();
  return now + kLook;
}

void Operator::repeat_stop() {
  --stops_left_;
  v1::RigStop stop;
  stop.rig_id(rig_id("rig"));
  stop.stop_id(stop_id_);
  stop.requested_by(kName);
  (void)stops_.write(stop);
}

void Operator::act() {
  if (is_over()) return;
  const auto waits_for = [this](const char* text) {
    return session_->waiting_for().find(text) != std::string::npos;
  };
  act_at_ = life_->clock.now() + kBetweenActs;
  if (!session_) {
    granted_();
    ask(v1::SESSION_START);
  } else if (wants_abort_) {
    ask(v1::SESSION_ABORT);
  } else if (rig_ && rig_->mode() == v1::RIG_HELD &&
             (waits_for("the rig is held") || session_->phase() == v1::SESSION_PAUSED)) {
    clear();
  } else if (waits_for("operator: resume") || session_->phase() == v1::SESSION_PAUSED) {
    wants_pause_ = false;
    granted_();
    ask(v1::SESSION_RESUME);
  } else if (wants_pause_) {
    ask(v1::SESSION_PAUSE);
  } else {
    act_at_ = {};
  }
}

void Operator::ask(v1::SessionRequest request) {
  v1::SessionCommand command;
  command.session_id(session_id_);
  command.request_id(new_id());
  command.request(request);
  command.requested_by(kName);
  if (request == v1::SESSION_START) {
    command.protocol_toml(protocol_);
    command.subject("sub-01");
    command.subject_facts(contract::unknown_subject());
    command.seed(random_.next() >> 1);
  }
  (void)commands_.write(command);
}

void Operator::clear() {
  v1::RigCommand command;
  command.rig_id(rig_->rig_id());
  command.request_id(new_id());
  command.request(v1::RIG_CLEAR_FAULT);
  command.hold_number(rig_->hold_number());
  command.requested_by(kName);
  (void)rig_commands_.write(command);
}

}  // namespace tonus::simulator
