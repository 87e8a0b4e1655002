#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "rig_agent/control/flight_recorder.hpp"
#include "rig_agent/control/pacer.hpp"
#include "rig_agent/control/rig_loop.hpp"
#include "services/bus/bus.hpp"
#include "services/bus/typed.hpp"
#include "services/core/clock.hpp"
#include "services/core/id.hpp"

#include <idl/rig.h>

namespace tonus::rig {

/// A frozen record as it goes over the bus: parts of at most 256 cycles, the oldest first. Part k of every
/// record of a rig has the same key, so that the newest record takes the place of the one before.
[[nodiscard]] std::vector<v1::FlightRecord> flight_record_parts(const control::FlightRecorder& recorder,
                                                                const Id& rig, std::uint64_t epoch);

/// The pacer's counts as they go over the bus, without rig, epoch and scheduling.
[[nodiscard]] v1::RigTiming timing_of(const control::Pacer& pacer, double period);

/// What the realtime loop tells of itself, beside its samples: its timing (rig/timing) once a second, and the
/// last 2 s before a fault (rig/flight_record) as soon as there is one. A part that the bus does not take is
/// tried again. The loop's recorder stays frozen until its record has been copied here. One thread.
class LoopReport {
 public:
  struct Options {
    Id rig{};
    std::uint64_t epoch = 0;
    std::string scheduling;                 ///< What the operating system permitted, one line.
    const control::Pacer* pacer = nullptr;  ///< Null where the loop is not paced: cycles are counted alone.
  };

  [[nodiscard]] static Result<LoopReport> create(bus::Bus& bus, Options options, control::RigLoop& loop,
                                                 const Clock& clock);

  /// Publishes what is due; returns when it is due next.
  Clock::TimePoint step();

 private:
  LoopReport(bus::TypedWriter<v1::RigTiming> timing, bus::TypedWriter<v1::FlightRecord> flight_record,
             Options options, control::RigLoop& loop, const Clock& clock);
  void publish_timing_if_due();
  void take_flight_record();
  void publish_flight_record();

  bus::TypedWriter<v1::RigTiming> timing_;
  bus::TypedWriter<v1::FlightRecord> flight_record_;
  Options options_;
  control::RigLoop* loop_;
  const Clock* clock_;
  Clock::TimePoint timing_due_;
  std::uint32_t taken_ = 0;               // Number of the last record that was copied.
  std::vector<v1::FlightRecord> unsent_;  // Its parts that are still to be sent, the last first.
};

}  // namespace tonus::rig
