#include "tests/bench/rigs/simulated_rigs.hpp"

#include <ctime>

#include "idl/topics.hpp"

namespace tonus::bench {
namespace {

using namespace identification;

template <typename T>
bus::TypedWriter<T> writer(bus::Bus& bus, const bus::Topic<T>& topic) {
  return bus::TypedWriter<T>::create(bus, topic).value();
}

runtime::CommonOptions common(const std::string& rig, const std::string& dds) {
  runtime::CommonOptions options;
  options.rig = rig;
  options.dds = dds;
  return options;
}

MeasuredTrial trial_of(std::uint32_t attempt, std::uint64_t first_sequence) {
  identification::testing::Recipe recipe;
  recipe.attempt = attempt;
  recipe.direction_deg = 45.0 * (attempt % 8);
  recipe.set = 1 + static_cast<int>(attempt / 8);
  recipe.first_sequence = first_sequence;
  return identification::testing::made_up_trial(recipe);
}

std::string now_text() {
  const std::time_t now = std::time(nullptr);
  std::tm parts{};
  gmtime_r(&now, &parts);
  char text[32];
  (void)std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", &parts);
  return text;
}

}  // namespace

SimulatedRig::SimulatedRig(bus::Bus& bus, const Clock& clock, const std::string& name, const std::string& dds,
                           std::uint32_t trials)
    : name_(name),
      session_(id_of("bench session of " + name)),
      trials_(trials),
      description_(writer(bus, topics::kRigDescription)),
      plans_(writer(bus, topics::kSessionPlan)),
      commands_(writer(bus, topics::kTrialCommand)),
      samples_(writer(bus, topics::kRigSamples)),
      outcomes_(writer(bus, topics::kTrialOutcome)),
      resends_(bus::TypedReader<v1::ArchiveResend>::create(bus, topics::kArchiveResend, nullptr).value()),
      health_(runtime::HealthReporter::create(bus, clock, v1::ROLE_RIG, common(name, dds)).value()) {}

void SimulatedRig::introduce() {
  send(description_, identification::testing::description_of(name_));
  send(plans_, identification::testing::plan_of(name_, session_, now_text()));
  health_.set_state(true, "ready");
  report_health();
}

void SimulatedRig::send_block() {
  if (is_done()) return;
  if (messages_.empty()) {
    trial_ = identification::testing::as_of(trial_of(attempt_ + 1, next_sequence_), name_, session_);
    messages_ = identification::testing::messages_of(trial_, kRowsABlock);
    next_sequence_ = trial_.report.range.end;
    next_ = 0;
    send(commands_, identification::testing::command_of(trial_));
  }
  sent_.push_back(std::chrono::steady_clock::now());
  messages_[next_].send_ns(sent_.back().time_since_epoch().count());
  send(samples_, messages_[next_]);
  if (++next_ < messages_.size()) return;
  outcomes_sent_.push_back(std::chrono::steady_clock::now());
  send(outcomes_, identification::testing::outcome_of(trial_));
  messages_.clear();
  ++attempt_;
}

const Time* SimulatedRig::sent(std::uint64_t row) const {
  const std::uint64_t block = row / kRowsABlock;
  return block < sent_.size() ? &sent_[block] : nullptr;
}

}  // namespace tonus::bench
