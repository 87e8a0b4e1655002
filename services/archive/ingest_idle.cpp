// The part of Ingest that keeps a ring while no session goes on.

#include <algorithm>
#include <utility>

#include "services/archive/ingest.hpp"

namespace tonus::archive {

store::Coverage Ingest::Stream::whole(store::Coverage Part::*coverage) const {
  return auxiliary_values == 0 ? samples.*coverage : (samples.*coverage).common(auxiliary.*coverage);
}

store::Coverage Ingest::Stream::taken_care_of() const {
  const auto of = [](const Part& part) {
    store::Coverage all = part.received;
    for (const store::SequenceRange& range : part.let_go.ranges()) all.add(range);
    return all;
  };
  return auxiliary_values == 0 ? of(samples) : of(samples).common(of(auxiliary));
}

bool Ingest::is_idle(Clock::TimePoint now) const {
  if (options_.idle.ring == Clock::Duration{}) return false;
  return std::none_of(going_on_.begin(), going_on_.end(), [&](const auto& session) {
    return now - session.second < options_.idle.session_silence;
  });
}

void Ingest::note_fault(Stream& stream, bool is_faulted) {
  if (std::exchange(stream.is_faulted, is_faulted) || !is_faulted) return;
  const Clock::TimePoint now = clock_.now();
  stream.keep_until = now + options_.idle.after_fault;
  const auto first = std::find_if(stream.ring.begin(), stream.ring.end(), [&](const Held& held) {
    return now - held.taken <= options_.idle.before_fault;
  });
  for (auto held = first; held != stream.ring.end(); ++held) {
    stream.ring_bytes -= held->block.payload->size();
    keep(stream, std::move(held->block));
  }
  stream.ring.erase(first, stream.ring.end());
  put_held_back(Clock::TimePoint::max());
}

void Ingest::let_go(Clock::TimePoint now, Decisions& decisions) {
  for (auto& [key, stream] : streams_) {
    while (!stream.ring.empty()) {
      const Held& oldest = stream.ring.front();
      const Clock::TimePoint due = oldest.taken + options_.idle.ring;
      if (now < due && stream.ring_bytes <= options_.idle.ring_bytes) {
        decisions.due = std::min(decisions.due, due);
        break;
      }
      stream.part_of(oldest.block).let_go.add(oldest.block.range());
      stream.has_let_go = true;
      stream.ring_bytes -= oldest.block.payload->size();
      stream.ring.pop_front();
    }
  }
  put_held_back(now - options_.idle.state_interval);
  for (const auto& [key, state] : idle_states_) {
    if (state.message) decisions.due = std::min(decisions.due, state.stored + options_.idle.state_interval);
  }
}

bool Ingest::hold_back(store::Message& message) {
  const Clock::TimePoint now = clock_.now();
  if (!is_idle(now) || sessions_.contains(message.session)) return false;
  const auto [place, is_first] = idle_states_.try_emplace({message.topic, message.key});
  HeldBack& state = place->second;
  if (is_first || now - state.stored >= options_.idle.state_interval) {
    state = {now, std::nullopt};
    return false;
  }
  state.message = std::move(message);
  return true;
}

void Ingest::put_held_back(Clock::TimePoint stored_before) {
  for (auto& [key, state] : idle_states_) {
    if (!state.message || state.stored > stored_before) continue;
    newest_[key] = {state.message->checksum, state.message->payload->size()};
    put(std::move(*state.message));
    state = {clock_.now(), std::nullopt};
  }
}

}  // namespace tonus::archive
