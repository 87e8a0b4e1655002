#include "tests/support/scheduler_lab/lab.hpp"

#include <algorithm>

#include "services/contract/subject.hpp"

namespace tonus::scheduler::testing {

const Id Lab::kSession = id_of("session of the test");

std::string small_protocol(const std::string& extra) {
  return "schema = 1\nkind = \"unloaded\"\nname = \"small\"\n" + extra + R"(
[[posture]]
name = "near"
position_m = [0.0, 0.24]
[[posture]]
name = "far"
position_m = [0.0, 0.52]
[perturbation]
directions = 2
sets = 2
amplitude_m = 0.005
rise_time_s = 0.2
hold_s = [1.5, 2.0]
wait_s = [3.0, 5.0]
)";
}

std::string small_loaded_protocol() {
  return R"(schema = 1
kind = "loaded"
name = "small loaded"
[[posture]]
name = "near"
position_m = [0.0, 0.24]
[perturbation]
directions = 2
sets = 3
amplitude_m = 0.005
rise_time_s = 0.2
hold_s = [1.5, 2.0]
wait_s = [3.0, 5.0]
[bias]
sets_along = ["none", "+major", "-minor"]
force_N = [0.7, 1.0]
ramp_s = [2.0, 3.0]
hold_s = 1.0
threshold_N = 0.2
)";
}

v1::RigDescription description_of_rig() {
  v1::RigDescription d;
  d.rig_id(id_of("rig/test"));
  d.name("test");
  d.kind(v1::RIG_TWO_LINK);
  d.link_lengths_m({0.30, 0.35});
  d.force_calibration_N_per_V({4.45, 0.0, 0.0, 4.45});
  d.force_saturation_V(10.0);
  d.home_m({0.30, 0.35});
  return d;
}

void Lab::restart_machine() {
  machine_ = std::make_unique<SessionMachine>(clock_, "test");
  inputs_.clear();
  was_killed = false;
  auto effects = machine_->restore(records);
  if (effects) take(std::move(*effects));
  for (const auto& [id, published] : published_) publish(published, true);
}

void Lab::connect() {
  v1::RigDescription description = description_of_rig();
  description.moves_nothing_real(true);
  description.resumes_unattended(!is_attended);
  take(machine_->on_rig_description(description));
  take(machine_->on_roster(""));
  if (!has_rig_state) {
    v1::RigState state;
    state.rig_id(description_of_rig().rig_id());
    state.epoch(1);
    state.mode(v1::RIG_FREE);
    take(machine_->on_rig_state(state));
  }
}

void Lab::take(Effects effects) {
  if (was_killed) return;
  if (kills && kills(effects)) {
    was_killed = true;
    return;
  }
  for (const Message& message : effects.urgent) receive(message);
  if (!effects.records.empty()) frames.push_back(effects.records);
  records.insert(records.end(), effects.records.begin(), effects.records.end());
  for (const Message& message : effects.messages) receive(message);
  if (armed_.empty()) return;
  const v1::RigReply reply = armed_.front();
  armed_.pop_front();
  take(machine_->on_rig_reply(reply));
}

void Lab::take_records_only(const Effects& effects) {
  if (!effects.records.empty()) frames.push_back(effects.records);
  records.insert(records.end(), effects.records.begin(), effects.records.end());
}

void Lab::receive(const Message& message) {
  if (const auto* m = std::get_if<v1::SessionPlan>(&message)) plans.push_back(*m);
  if (const auto* m = std::get_if<v1::TrialReview>(&message)) reviews.push_back(*m);
  if (const auto* m = std::get_if<v1::SessionNote>(&message)) notes.push_back(*m);
  if (const auto* m = std::get_if<v1::SessionState>(&message)) states.push_back(*m);
  if (const auto* m = std::get_if<v1::SessionReply>(&message)) replies.push_back(*m);
  if (const auto* m = std::get_if<v1::SessionCue>(&message)) cues.push_back(*m);
  if (const auto* m = std::get_if<v1::TrialCommand>(&message)) {
    trial_commands.push_back(*m);
    if (!is_mute) run_trial(*m);
  }
  if (const auto* m = std::get_if<v1::RigCommand>(&message)) {
    const bool is_arming = m->request() == v1::RIG_ARM || m->request() == v1::RIG_DISARM;
    (is_arming ? armings : rig_commands).push_back(*m);
    if (!rig_answers_aborts && !is_arming) return;
    v1::RigReply reply;
    reply.rig_id(m->rig_id());
    reply.request_id(m->request_id());
    reply.is_done(true);
    reply.rig_clock_ns(1000);
    if (is_arming) return armed_.push_back(reply);  // told at once: arming is no step of the tests' scripts
    post([reply](SessionMachine& machine) { return machine.on_rig_reply(reply); });
  }
}

void Lab::run_trial(const v1::TrialCommand& command) {
  if (const auto known = published_.find(command.trial_id()); known != published_.end()) {
    // A rig publishes the outcome anew; nobody else says anything twice.
    if (!known->second.fate.has_outcome) return;
    post([outcome = known->second.outcome](SessionMachine& machine) { return machine.on_outcome(outcome); });
    return;
  }
  Published p;
  p.fate = script_(command.program());
  if (p.fate.end != v1::TRIAL_REFUSED) ++runs[command.trial_id()];
  const std::uint64_t first = 1000ULL * command.program().attempt();
  p.outcome.trial_id(command.trial_id());
  p.outcome.program(command.program());
  p.outcome.end(p.fate.end);
  p.outcome.detail(p.fate.detail);
  p.outcome.first_sequence(first);
  p.outcome.last_sequence(first + 1999);  // 2000 samples at 200 Hz: 10 s
  p.outcome.sample_rate_Hz(200.0);
  p.verdict.trial_id(command.trial_id());
  p.verdict.session_id(command.program().session_id());
  p.verdict.attempt(command.program().attempt());
  p.verdict.is_valid(p.fate.is_valid && p.fate.end == v1::TRIAL_COMPLETED);
  if (!p.verdict.is_valid()) {
    p.verdict.reasons({p.fate.end == v1::TRIAL_COMPLETED ? p.fate.reason : v1::REASON_NOT_COMPLETED});
    p.verdict.detail(p.fate.detail);
  }
  p.receipt.subject_id(command.trial_id());
  p.receipt.kind(v1::RECEIPT_TRIAL);
  p.receipt.session_id(command.program().session_id());
  p.receipt.expected_samples(2000);
  p.receipt.missing_samples(p.fate.missing_samples);
  publish(p, false);
  if (p.fate.end != v1::TRIAL_REFUSED) published_[command.trial_id()] = p;
}

void Lab::publish(const Published& p, bool is_late) {
  // A late joiner gets the topics in any order: the verdict first, here.
  const bool is_refused = p.fate.end == v1::TRIAL_REFUSED;
  const auto outcome = [o = p.outcome](SessionMachine& machine) { return machine.on_outcome(o); };
  if (!is_late && p.fate.has_outcome) post(outcome);
  if (p.fate.has_verdict && !is_refused) post([v = p.verdict](SessionMachine& m) { return m.on_verdict(v); });
  if (p.fate.has_receipt && !is_refused) post([r = p.receipt](SessionMachine& m) { return m.on_receipt(r); });
  if (is_late && p.fate.has_outcome) post(outcome);
}

bool Lab::step() {
  if (inputs_.empty() || was_killed) return false;
  const auto input = std::move(inputs_.front());
  inputs_.pop_front();
  take(input(*machine_));
  return true;
}

void Lab::run() {
  while (step()) {
  }
}

bool Lab::run_until(const std::function<bool()>& done) {
  for (int i = 0; i < 10000; ++i) {
    if (done()) return true;
    if (!step()) return done();
  }
  return false;
}

bool Lab::run_to_end() {
  for (int i = 0; i < 10000; ++i) {
    if (was_killed) return false;
    if (machine_->ledger().has_session() && !machine_->is_active()) return true;
    if (step()) continue;
    const auto due = machine_->next_deadline();
    if (!due) return false;
    clock_.advance(
        std::max(Clock::Duration(0), std::chrono::duration_cast<Clock::Duration>(*due - clock_.now())));
    take(machine_->on_tick());
  }
  return false;
}

void Lab::command(v1::SessionRequest request, const std::string& request_name, const std::string& protocol) {
  v1::SessionCommand c;
  c.session_id(kSession);
  c.request_id(id_of(request_name));
  c.request(request);
  c.protocol_toml(protocol);
  c.subject("s01");
  c.subject_facts(contract::unknown_subject());
  c.seed(7);
  c.requested_by("test");
  take(machine_->on_command(c));
}

void Lab::reject(std::uint32_t attempt, const std::string& request_name, const std::string& text) {
  v1::SessionCommand c;
  c.session_id(kSession);
  c.request_id(id_of(request_name));
  c.request(v1::SESSION_REJECT_TRIAL);
  c.trial_id(trial_id(kSession, attempt));
  c.text(text);
  c.requested_by("Ada");
  take(machine_->on_command(c));
}

void Lab::note(const std::string& text, const std::string& request_name, const std::string& kind,
               std::uint32_t attempt) {
  v1::SessionCommand c;
  c.session_id(kSession);
  c.request_id(id_of(request_name));
  c.request(v1::SESSION_NOTE);
  if (attempt > 0) c.trial_id(trial_id(kSession, attempt));
  c.text(text);
  c.note_kind(kind);
  c.requested_by("Ada");
  take(machine_->on_command(c));
}

void Lab::tick(std::chrono::milliseconds duration) {
  clock_.advance(duration);
  take(machine_->on_tick());
}

const v1::SessionReply* Lab::reply_to(const std::string& request_name) const {
  const auto found = std::find_if(replies.rbegin(), replies.rend(), [&](const auto& reply) {
    return reply.request_id() == id_of(request_name);
  });
  return found == replies.rend() ? nullptr : &*found;
}

void Lab::give_rig_state(v1::RigMode mode, std::uint64_t epoch, std::int64_t clock_ns,
                         const std::string& fault) {
  v1::RigState state;
  state.rig_id(id_of("rig/test"));
  state.epoch(epoch);
  state.mode(mode);
  state.rig_clock_ns(clock_ns);
  state.fault(fault);
  state.held_because(fault);
  take(machine_->on_rig_state(state));
}

std::map<std::uint32_t, int> counted_trials(const std::vector<Record>& records) {
  std::map<std::uint32_t, std::uint32_t> planned;
  std::map<std::uint32_t, int> counted;
  for (const Record& entry : records) {
    if (const auto* r = std::get_if<record::Commanded>(&entry)) {
      planned[r->program.attempt()] = r->program.planned_index();
    }
    if (const auto* r = std::get_if<record::Counted>(&entry)) ++counted[planned.at(r->attempt)];
    if (const auto* r = std::get_if<record::Reviewed>(&entry)) --counted[r->planned_index];
  }
  return counted;
}

}  // namespace tonus::scheduler::testing
