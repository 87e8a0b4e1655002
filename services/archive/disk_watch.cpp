#include "services/archive/disk_watch.hpp"

#include <spdlog/fmt/fmt.h>

#include "idl/topics.hpp"
#include "services/bus/typed.hpp"
#include "services/contract/names.hpp"

namespace tonus::archive {
namespace {

constexpr std::chrono::seconds kPeriod{1};

}  // namespace

void DiskWatch::note(const bus::TopicSpec& topic, const bus::Sample& sample) {
  if (topic.name == topics::kRigDescription.spec.name) {
    if (const auto rig = bus::decode<v1::RigDescription>(*sample.payload))
      budget_.note_rate(rig->sample_rate_Hz());
  } else if (topic.name == topics::kSessionState.spec.name) {
    const auto state = bus::decode<v1::SessionState>(*sample.payload);
    if (!state) return;
    if (v1::is_over(state->phase())) {
      budget_.note_no_session();
    } else {
      budget_.note_session(state->attempts() > 0, state->remaining_s());
    }
    word();
  }
}

void DiskWatch::word() {
  const std::uint64_t needed = budget_.has_begun() ? 0 : budget_.needed();
  if (needed != worded_for_) {
    refusal_.clear();
    need_.clear();
  }
  worded_for_ = needed;
  const std::string refusal = budget_.refusal();
  if (refusal.empty() || refusal_.empty()) refusal_ = refusal;
  const auto room = budget_.available();
  if (!need_.empty() || needed == 0 || !room) return;
  need_ = fmt::format("; the session needs about {}, {} are available", size_text(needed), size_text(*room));
}

Clock::TimePoint DiskWatch::measure_if_due(const IngestStatus& taken) {
  const Clock::TimePoint now = clock_.now();
  if (now < due_) return due_;
  due_ = now + kPeriod;
  budget_.note_blocks(taken.sample_bytes, taken.samples);
  if (const auto space = store_.space()) {
    budget_.note_space(*space);
    failure_.clear();
  } else {
    failure_ = space.error().message;
  }
  word();
  return due_;
}

}  // namespace tonus::archive
