#include "rig_agent/agent/loop_report.hpp"

#include <algorithm>
#include <spdlog/fmt/fmt.h>
#include <spdlog/spdlog.h>
#include <utility>

#include "idl/bounds.hpp"
#include "idl/topics.hpp"
#include "rig_agent/agent/wire.hpp"
#include "rig_agent/control/fault_text.hpp"

namespace tonus::rig {
namespace {

constexpr std::chrono::seconds kTimingPeriod{1};
constexpr std::chrono::milliseconds kFlightRecordPoll{50};
constexpr std::size_t kCyclesInPart = 256;

static_assert(std::tuple_size_v<std::decay_t<decltype(v1::RigTiming{}.lateness_count())>> ==
              control::JitterHistogram::kClasses);

}  // namespace

std::vector<v1::FlightRecord> flight_record_parts(const control::FlightRecorder& recorder, const Id& rig,
                                                  std::uint64_t epoch) {
  const std::size_t cycles = recorder.size();
  const std::size_t parts = (cycles + kCyclesInPart - 1) / kCyclesInPart;
  std::vector<v1::FlightRecord> record(parts);
  const std::string fault = cycles == 0 ? "" : control::fault_text(recorder.at(cycles - 1).faults);
  for (std::size_t i = 0; i < parts; ++i) {
    v1::FlightRecord& part = record[i];
    part.part_id(id_of(fmt::format("flight_record/{}/{}", to_hex(rig), i)));
    part.rig_id(rig);
    part.epoch(epoch);
    part.fault_number(recorder.number());
    part.fault(fault);
    part.part(static_cast<std::uint32_t>(i));
    part.parts(static_cast<std::uint32_t>(parts));
    const std::size_t end = std::min(cycles, (i + 1) * kCyclesInPart);
    for (std::size_t k = i * kCyclesInPart; k < end; ++k) part.cycles().push_back(to_wire(recorder.at(k)));
  }
  return record;
}

v1::RigTiming timing_of(const control::Pacer& pacer, double period) {
  v1::RigTiming timing;
  timing.period_s(period);
  timing.cycles(pacer.cycles());
  timing.overruns(pacer.overruns());
  timing.missed_periods(pacer.missed_periods());
  timing.worst_lateness_ns(pacer.jitter().worst_ns());
  for (std::size_t i = 0; i < control::JitterHistogram::kClasses; ++i)
    timing.lateness_count()[i] = pacer.jitter().count(i);
  return timing;
}

Result<LoopReport> LoopReport::create(bus::Bus& bus, Options options, control::RigLoop& loop,
                                      const Clock& clock) {
  auto timing = bus::TypedWriter<v1::RigTiming>::create(bus, topics::kRigTiming);
  if (!timing) return timing.error();
  auto flight_record = bus::TypedWriter<v1::FlightRecord>::create(bus, topics::kRigFlightRecord);
  if (!flight_record) return flight_record.error();
  return LoopReport(std::move(*timing), std::move(*flight_record), std::move(options), loop, clock);
}

LoopReport::LoopReport(bus::TypedWriter<v1::RigTiming> timing,
                       bus::TypedWriter<v1::FlightRecord> flight_record, Options options,
                       control::RigLoop& loop, const Clock& clock)
    : timing_(std::move(timing)),
      flight_record_(std::move(flight_record)),
      options_(std::move(options)),
      loop_(&loop),
      clock_(&clock) {}

Clock::TimePoint LoopReport::step() {
  take_flight_record();
  publish_flight_record();
  publish_timing_if_due();
  return unsent_.empty() ? timing_due_ : std::min(timing_due_, clock_->now() + kFlightRecordPoll);
}

void LoopReport::publish_timing_if_due() {
  if (clock_->now() < timing_due_) return;
  timing_due_ = clock_->now() + kTimingPeriod;
  v1::RigTiming timing;
  if (options_.pacer != nullptr) {
    timing = timing_of(*options_.pacer, loop_->period());
  } else {
    timing.period_s(loop_->period());
    timing.cycles(loop_->state().cycle);
  }
  timing.rig_id(options_.rig);
  timing.epoch(options_.epoch);
  timing.scheduling(options_.scheduling);
  if (auto sent = timing_.write(timing); !sent) {
    spdlog::warn("the loop's timing is not published: {}", sent.error().message);
  }
}

void LoopReport::take_flight_record() {
  const control::FlightRecorder& recorder = loop_->flight_recorder();
  if (!recorder.is_frozen() || recorder.number() == taken_ || !unsent_.empty()) return;
  taken_ = recorder.number();
  unsent_ = flight_record_parts(recorder, options_.rig, options_.epoch);
  loop_->set_flight_record_read(taken_);
  if (unsent_.empty()) return;
  spdlog::warn("fault {}: {}; the last {:.3g} s before it are published", taken_, unsent_.back().fault(),
               loop_->period() * static_cast<double>((unsent_.size() - 1) * kCyclesInPart +
                                                     unsent_.back().cycles().size()));
  std::reverse(unsent_.begin(), unsent_.end());
}

void LoopReport::publish_flight_record() {
  while (!unsent_.empty() && flight_record_.write(unsent_.back())) unsent_.pop_back();
}

}  // namespace tonus::rig
