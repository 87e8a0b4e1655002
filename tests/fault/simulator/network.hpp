#pragma once

#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <queue>
#include <span>
#include <string>
#include <vector>

#include "services/bus/bus.hpp"
#include "services/bus/memory/fabric_state.hpp"
#include "tests/fault/simulator/life.hpp"
#include "tests/fault/simulator/random.hpp"

namespace tonus::simulator {

/// A network without threads or a clock of its own, between programs that live in one thread. It does what
/// DDS may do, and draws when:
///
/// - Samples of one writer come to one reader in order; samples of different writers overtake each other.
/// - Of best-effort topics some are lost.
/// - A writer and a reader find each other some time after both exist; what is written before is lost where
/// it
///   is volatile. They lose each other a lease after one has died or was cut off; found again, a reader gets
///   what a transient-local writer keeps, once more.
/// - A reliable writer of a full history is refused after its max_blocking, which passes for its program.
class Network {
 public:
  struct Options {
    double slow_share = 0.02;  ///< Of the samples, those that take up to `slow`.
    double slow = 0.4;         ///< s.
    double loss = 0.02;        ///< Of best-effort samples.
    double discovery = 0.3;    ///< s, longest time in which two ends find each other.
  };
  /// Told of every sample that a living program writes, before anybody has it.
  using Witness =
      std::function<void(const Life& writer, const std::string& topic, std::span<const std::byte> payload)>;

  Network(const Time& now, Random& random, const Options& options, Witness witness)
      : now_(now), random_(random), options_(options), witness_(std::move(witness)) {}

  ~Network();
  Network(const Network&) = delete;
  Network& operator=(const Network&) = delete;

  /// A participant of a life.
  [[nodiscard]] std::unique_ptr<bus::Bus> join(std::shared_ptr<Life> life);

  /// Nobody hears or reaches this program any more until `until`.
  void cut(const std::string& program, Time until);
  /// The life has ended without a word: its ends stay where they are for a lease.
  void bury(const Life& life);

  /// Hands out what has arrived by now.
  void deliver();
  /// When something arrives next.
  [[nodiscard]] Time next() const { return events_.empty() ? kNever : events_.top().due; }

  struct Writing;
  struct Reading;
  struct Link;
  Result<void> write(Writing& end, std::span<const std::byte> payload);
  std::shared_ptr<Writing> add_writer(std::shared_ptr<Life> life, const bus::TopicSpec& topic);
  std::shared_ptr<Reading> add_reader(std::shared_ptr<Life> life, const bus::TopicSpec& topic,
                                      std::shared_ptr<bus::Notifier> notifier);
  void remove(Writing& end);
  void remove(Reading& end);

 private:
  enum class Change : std::uint8_t { kArrive, kMeet, kPart };
  struct Event {
    Time due;
    std::uint64_t number = 0;
    Change change = Change::kArrive;
    std::weak_ptr<Link> link;
    bool operator<(const Event& other) const {  // the earliest is on top
      return due != other.due ? due > other.due : number > other.number;
    }
  };
  void schedule(Time due, Change change, const std::shared_ptr<Link>& link);
  void link(const std::shared_ptr<Writing>& writer, const std::shared_ptr<Reading>& reader);
  void meet(const std::shared_ptr<Link>& link);
  void part(Link& link);
  void arrive(const std::shared_ptr<Link>& link);
  void send(const std::shared_ptr<Link>& link, const bus::Sample& sample);
  void wake(Reading& reader);
  void forget_dead();
  [[nodiscard]] Time cut_until(const Link& link) const;
  [[nodiscard]] Clock::Duration drawn(double longest);

  const Time& now_;
  Random& random_;
  const Options options_;
  const Witness witness_;
  std::uint64_t number_ = 0;
  std::priority_queue<Event> events_;
  std::vector<std::shared_ptr<Writing>> writers_;
  std::vector<std::shared_ptr<Reading>> readers_;
  std::map<std::string, Time> cuts_;
  bool has_dead_ = false;
};

}  // namespace tonus::simulator
