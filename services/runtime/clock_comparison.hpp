#pragma once

#include <map>
#include <memory>
#include <optional>

#include "services/bus/notifier.hpp"
#include "services/bus/typed.hpp"
#include "services/core/clock.hpp"
#include "services/core/id.hpp"
#include "services/runtime/clock_offset.hpp"
#include "services/runtime/health.hpp"

#include <idl/service.h>

namespace tonus::runtime {

/// Compares this program's monotonic clock with that of every service in the roster, and publishes the
/// difference (clock/offset) after each round of questions. A round is `questions` long, one after the other;
/// the first one of a service, and of one that was started anew, is `first_questions` long. For one thread.
class ClockComparison {
 public:
  struct Options {
    Clock::Duration period = std::chrono::seconds(5);           ///< Between rounds.
    Clock::Duration patience = std::chrono::milliseconds(500);  ///< For an answer; then the next question.
    int questions = 4;
    int first_questions = 16;
  };

  [[nodiscard]] static Result<ClockComparison> create(bus::Bus& bus, const Clock& clock, const Id& instance,
                                                      std::shared_ptr<bus::Notifier> notifier,
                                                      const Options& options);

  /// Takes answers and asks what is due; returns when it has to be called again.
  Clock::TimePoint step(const Roster& roster);

 private:
  struct Peer {
    std::uint64_t started_ns = 0;  ///< Of its health: another one is another program.
    ClockOffset offset;
    int left = 0;                 ///< Questions of this round, the one under way counted.
    std::uint64_t under_way = 0;  ///< Number of the question; 0: none.
    Clock::TimePoint due;         ///< End of the patience, or next round.
  };

  ClockComparison(bus::TypedReader<v1::ClockEcho> echoes, bus::TypedWriter<v1::ClockProbe> probes,
                  bus::TypedWriter<v1::ClockOffset> offsets, const Clock& clock, const Id& instance,
                  const Options& options);
  void meet(const Roster& roster);
  void take_answers();
  void go_on(const Id& id, Peer& peer);
  void ask(const Id& id, Peer& peer);
  void publish(const Id& id, const Peer& peer);

  bus::TypedReader<v1::ClockEcho> echoes_;
  bus::TypedWriter<v1::ClockProbe> probes_;
  bus::TypedWriter<v1::ClockOffset> offsets_;
  const Clock* clock_;
  Id instance_;
  Options options_;
  std::map<Id, Peer> peers_;
  std::uint64_t number_ = 0;
};

}  // namespace tonus::runtime
