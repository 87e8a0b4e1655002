#include "services/bus/memory/memory_fabric.hpp"

#include <algorithm>

#include "services/bus/memory/fabric_state.hpp"
#include "services/bus/payload.hpp"

namespace tonus::bus {
namespace {

std::int64_t nanoseconds(auto time) {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(time.time_since_epoch()).count();
}

std::optional<SteadyTime> earlier(std::optional<SteadyTime> a, std::optional<SteadyTime> b) {
  if (!a) return b;
  return b ? std::min(*a, *b) : a;
}

}  // namespace

MemoryFabric::MemoryFabric() : state_(std::make_unique<State>()) {}
MemoryFabric::~MemoryFabric() = default;
void MemoryFabric::kill(std::string_view participant_name) { state_->kill(participant_name); }

MemoryFabric::State::State() : watcher_([this] { watch(); }) {}

MemoryFabric::State::~State() {
  {
    const std::lock_guard lock(mutex_);
    is_stopping_ = true;
    timing_.notify_all();
  }
  watcher_.join();
}

void MemoryFabric::State::add(const std::shared_ptr<WriterEnd>& writer) {
  const std::lock_guard lock(mutex_);
  writers_.push_back(writer);
  notify_matched(*writer);
}

void MemoryFabric::State::add(const std::shared_ptr<ReaderEnd>& reader) {
  const std::lock_guard lock(mutex_);
  if (reader->topic.qos.durability == Durability::kTransientLocal) {
    for (const auto& writer : writers_) {
      if (!writer->is_matching(*reader) || writer->killed_at) continue;
      for (const Sample& sample : writer->history.samples()) reader->queue.push(sample);
    }
  }
  readers_.push_back(reader);
  if (reader->notifier) reader->notifier->notify();
}

void MemoryFabric::State::remove(const std::shared_ptr<WriterEnd>& writer) {
  const std::lock_guard lock(mutex_);
  std::erase(writers_, writer);
  notify_matched(*writer);
}

void MemoryFabric::State::remove(const std::shared_ptr<ReaderEnd>& reader) {
  const std::lock_guard lock(mutex_);
  std::erase(readers_, reader);
  room_.notify_all();
}

bool MemoryFabric::State::has_room(const WriterEnd& writer) const {
  return std::none_of(readers_.begin(), readers_.end(), [&](const auto& reader) {
    return !reader->is_gone && reader->is_matching(writer) && reader->queue.is_full();
  });
}

Result<void> MemoryFabric::State::write(WriterEnd& writer, std::span<const std::byte> payload) {
  auto good = check_payload(payload, writer.topic.max_payload_bytes);
  Sample sample;
  if (good) {
    sample.payload = std::make_shared<const Payload>(padded_copy(payload));
    sample.key = payload_key(payload);
  }
  std::unique_lock lock(mutex_);
  if (!good) {
    ++writer.status.refused;
    return good;
  }
  const Qos& qos = writer.topic.qos;
  if (qos.reliable && !room_.wait_for(lock, qos.max_blocking, [&] { return has_room(writer); })) {
    ++writer.status.refused;
    return fail(ErrorCode::kTimeout, "topic '" + writer.topic.name + "': history of " +
                                         std::to_string(qos.depth) + " samples stayed full for " +
                                         std::to_string(qos.max_blocking.count()) + " ms");
  }
  sample.source_timestamp_ns = nanoseconds(std::chrono::system_clock::now());
  sample.received_ns = nanoseconds(std::chrono::steady_clock::now());
  ++writer.status.written;
  if (!writer.killed_at) deliver(writer, sample);
  return {};
}

void MemoryFabric::State::deliver(WriterEnd& writer, const Sample& sample) {
  const SteadyTime now = std::chrono::steady_clock::now();
  writer.deadlines.seen(sample.key, now);
  if (writer.topic.qos.durability == Durability::kTransientLocal) {
    writer.history.push(sample);
  }
  for (const auto& reader : readers_) {
    if (reader->killed_at || !reader->is_matching(writer)) continue;
    reader->deadlines.seen(sample.key, now);
    if (reader->queue.is_full()) {  // only from a best-effort writer
      ++reader->status.lost;
      continue;
    }
    reader->queue.push(sample);
    if (reader->notifier) reader->notifier->notify();
  }
  if (writer.topic.qos.deadline.count() > 0) timing_.notify_all();
}

std::size_t MemoryFabric::State::take(ReaderEnd& reader, std::vector<Sample>& out, std::size_t max) {
  const std::lock_guard lock(mutex_);
  const std::size_t count = std::min(max, reader.queue.samples().size());
  for (std::size_t i = 0; i < count; ++i) {
    out.push_back(reader.queue.samples().front());
    reader.queue.pop_front();
  }
  reader.status.received += count;
  if (count > 0) room_.notify_all();
  return count;
}

bool MemoryFabric::State::wait_acknowledged(const WriterEnd& writer, std::chrono::milliseconds limit) {
  // A reader has a sample as soon as it is written; only a killed one never does, until its place is given
  // up.
  std::unique_lock lock(mutex_);
  return room_.wait_for(lock, limit, [&] {
    return std::none_of(readers_.begin(), readers_.end(), [&](const auto& reader) {
      return reader->killed_at && !reader->is_gone && reader->is_matching(writer);
    });
  });
}

WriterStatus MemoryFabric::State::status(const WriterEnd& writer) const {
  const std::lock_guard lock(mutex_);
  WriterStatus status = writer.status;
  status.deadline_missed = writer.deadlines.missed();
  status.matched_readers =
      static_cast<int>(std::count_if(readers_.begin(), readers_.end(), [&](const auto& reader) {
        return !reader->is_gone && !writer.is_gone && reader->is_matching(writer);
      }));
  return status;
}

ReaderStatus MemoryFabric::State::status(const ReaderEnd& reader) const {
  const std::lock_guard lock(mutex_);
  ReaderStatus status = reader.status;
  status.deadline_missed = reader.deadlines.missed();
  for (const auto& writer : writers_) {
    if (writer->is_gone || reader.is_gone || !writer->is_matching(reader)) continue;
    ++status.matched_writers;
    if (!writer->is_liveliness_lost) ++status.alive_writers;
  }
  return status;
}

void MemoryFabric::State::kill(std::string_view participant_name) {
  const std::lock_guard lock(mutex_);
  const SteadyTime now = std::chrono::steady_clock::now();
  for (const auto& writer : writers_) {
    if (writer->participant == participant_name && !writer->killed_at) writer->killed_at = now;
  }
  for (const auto& reader : readers_) {
    if (reader->participant == participant_name && !reader->killed_at) reader->killed_at = now;
  }
  timing_.notify_all();
}

void MemoryFabric::State::notify_matched(const End& end) {
  for (const auto& reader : readers_) {
    if (reader->notifier && reader->is_matching(end)) reader->notifier->notify();
  }
}

void MemoryFabric::State::watch() {
  std::unique_lock lock(mutex_);
  while (!is_stopping_) {
    const std::optional<SteadyTime> next = expire(std::chrono::steady_clock::now());
    if (next) {
      timing_.wait_until(lock, *next);
    } else {
      timing_.wait(lock);
    }
  }
}

std::optional<SteadyTime> MemoryFabric::State::expire(SteadyTime now) {
  std::optional<SteadyTime> next;
  for (const auto& writer : writers_) next = earlier(next, expire_writer(*writer, now));
  for (const auto& reader : readers_) next = earlier(next, expire_reader(*reader, now));
  return next;
}

std::optional<SteadyTime> MemoryFabric::State::expire_writer(WriterEnd& writer, SteadyTime now) {
  if (!writer.killed_at) {
    static_cast<void>(writer.deadlines.expire(now));
    return writer.deadlines.next();
  }
  if (writer.is_gone) return std::nullopt;
  const SteadyTime gone_at = *writer.killed_at + writer.lease;
  const bool has_lease = writer.topic.qos.liveliness_lease.count() > 0;
  const SteadyTime lost_at = has_lease ? *writer.killed_at + writer.topic.qos.liveliness_lease : gone_at;
  if (has_lease && !writer.is_liveliness_lost && now >= lost_at) {
    writer.is_liveliness_lost = true;
    for (const auto& reader : readers_) {
      if (reader->is_matching(writer)) ++reader->status.liveliness_lost_events;
    }
    notify_matched(writer);
  }
  if (now < gone_at) return writer.is_liveliness_lost ? gone_at : std::min(lost_at, gone_at);
  writer.is_gone = true;
  notify_matched(writer);
  return std::nullopt;
}

std::optional<SteadyTime> MemoryFabric::State::expire_reader(ReaderEnd& reader, SteadyTime now) {
  if (!reader.killed_at) {
    if (reader.deadlines.expire(now) && reader.notifier) reader.notifier->notify();
    return reader.deadlines.next();
  }
  if (reader.is_gone) return std::nullopt;
  const SteadyTime gone_at = *reader.killed_at + reader.lease;
  if (now < gone_at) return gone_at;
  reader.is_gone = true;
  room_.notify_all();
  return std::nullopt;
}

}  // namespace tonus::bus
