#pragma once

#include <condition_variable>
#include <deque>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>

#include "services/bus/bus.hpp"
#include "services/bus/memory/memory_fabric.hpp"

namespace tonus::bus {

using SteadyTime = std::chrono::steady_clock::time_point;

/// A topic as a carrier keeps it: owns its names.
struct OwnedTopic {
  explicit OwnedTopic(const TopicSpec& spec)
      : name(spec.name),
        type_name(spec.type_name),
        qos(spec.qos),
        max_payload_bytes(spec.max_payload_bytes) {}
  std::string name;
  std::string type_name;
  Qos qos;
  std::size_t max_payload_bytes;
};

/// Samples under a history policy: kKeepLast `depth` of each key, or kKeepAll.
class SampleQueue {
 public:
  explicit SampleQueue(const Qos& qos) : qos_(qos) {}
  void push(const Sample& sample);
  void pop_front() { samples_.pop_front(); }
  [[nodiscard]] const std::deque<Sample>& samples() const { return samples_; }
  [[nodiscard]] bool is_full() const;  ///< Of kKeepAll; kKeepLast always has room.

 private:
  Qos qos_;
  std::deque<Sample> samples_;
};

/// When each key is due next; counts the times that one was not.
class DeadlineWatch {
 public:
  explicit DeadlineWatch(std::chrono::milliseconds deadline) : deadline_(deadline) {}
  void seen(const Key& key, SteadyTime now);
  [[nodiscard]] bool expire(SteadyTime now);  ///< True if a deadline passed since the last call.
  [[nodiscard]] std::optional<SteadyTime> next() const;
  [[nodiscard]] std::uint64_t missed() const { return missed_; }

 private:
  std::chrono::milliseconds deadline_;
  std::map<Key, SteadyTime> due_;
  std::uint64_t missed_ = 0;
};

/// What writers and readers have in common: whose they are, and whether that participant was killed.
struct End {
  End(int domain_id, const BusOptions& options, const TopicSpec& spec)
      : domain(domain_id),
        participant(options.participant_name),
        lease(options.participant_lease),
        topic(spec),
        deadlines(spec.qos.deadline) {}
  [[nodiscard]] bool is_matching(const End& other) const {
    return domain == other.domain && topic.name == other.topic.name &&
           topic.type_name == other.topic.type_name;
  }
  int domain;
  std::string participant;
  std::chrono::milliseconds lease;
  OwnedTopic topic;
  DeadlineWatch deadlines;
  std::optional<SteadyTime> killed_at;
  bool is_gone = false;  ///< Killed, and its lease is over: matched with nobody.
};

struct WriterEnd : End {
  using End::End;
  /// What is kept for late readers is always the last of each key.
  static Qos late_reader_qos(Qos qos) {
    qos.history = History::kKeepLast;
    return qos;
  }
  SampleQueue history{late_reader_qos(topic.qos)};  ///< kTransientLocal only.
  WriterStatus status;
  bool is_liveliness_lost = false;
};

struct ReaderEnd : End {
  using End::End;
  SampleQueue queue{topic.qos};
  std::shared_ptr<Notifier> notifier;
  ReaderStatus status;  ///< The matched and alive counts are computed when asked for.
};

/// Everything behind the fabric's one mutex, and the thread that watches times.
class MemoryFabric::State {
 public:
  State();
  ~State();

  void add(const std::shared_ptr<WriterEnd>& writer);
  void add(const std::shared_ptr<ReaderEnd>& reader);
  void remove(const std::shared_ptr<WriterEnd>& writer);
  void remove(const std::shared_ptr<ReaderEnd>& reader);
  Result<void> write(WriterEnd& writer, std::span<const std::byte> payload);
  std::size_t take(ReaderEnd& reader, std::vector<Sample>& out, std::size_t max);
  bool wait_acknowledged(const WriterEnd& writer, std::chrono::milliseconds limit);
  WriterStatus status(const WriterEnd& writer) const;
  ReaderStatus status(const ReaderEnd& reader) const;
  void kill(std::string_view participant_name);

 private:
  [[nodiscard]] bool has_room(const WriterEnd& writer) const;
  void deliver(WriterEnd& writer, const Sample& sample);
  void notify_matched(const End& end);
  void watch();
  std::optional<SteadyTime> expire(SteadyTime now);
  std::optional<SteadyTime> expire_writer(WriterEnd& writer, SteadyTime now);
  std::optional<SteadyTime> expire_reader(ReaderEnd& reader, SteadyTime now);

  mutable std::mutex mutex_;
  std::condition_variable room_;    ///< A queue got shorter, or an end went away.
  std::condition_variable timing_;  ///< A deadline or a lease may now be earlier.
  std::vector<std::shared_ptr<WriterEnd>> writers_;
  std::vector<std::shared_ptr<ReaderEnd>> readers_;
  bool is_stopping_ = false;
  std::thread watcher_;
};

}  // namespace tonus::bus
