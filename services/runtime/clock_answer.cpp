#include "services/runtime/clock_answer.hpp"

#include <utility>

#include "idl/topics.hpp"
#include "services/runtime/drain.hpp"

namespace tonus::runtime {

std::int64_t reading(const Clock& clock) {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(clock.now().time_since_epoch()).count();
}

Result<ClockAnswer> ClockAnswer::create(bus::Bus& bus, const Clock& clock, const Id& instance,
                                        std::shared_ptr<bus::Notifier> notifier) {
  auto probes = bus::TypedReader<v1::ClockProbe>::create(bus, topics::kClockProbe, notifier);
  if (!probes) return probes.error();
  auto echoes = bus::TypedWriter<v1::ClockEcho>::create(bus, topics::kClockEcho);
  if (!echoes) return echoes.error();
  return ClockAnswer(std::move(*probes), std::move(*echoes), clock, instance);
}

ClockAnswer::ClockAnswer(bus::TypedReader<v1::ClockProbe> probes, bus::TypedWriter<v1::ClockEcho> echoes,
                         const Clock& clock, const Id& instance)
    : probes_(std::move(probes)), echoes_(std::move(echoes)), clock_(&clock), instance_(instance) {}

void ClockAnswer::answer() {
  const auto probes = drain(probes_);
  const std::int64_t received = reading(*clock_);
  for (const auto& probe : probes) {
    if (probe.value.answerer_id() != instance_) continue;
    v1::ClockEcho echo;
    echo.asker_id(probe.value.asker_id());
    echo.answerer_id(instance_);
    echo.number(probe.value.number());
    echo.asked_ns(probe.value.asked_ns());
    echo.received_ns(received);
    echo.answered_ns(reading(*clock_));
    (void)echoes_.write(echo);
  }
}

}  // namespace tonus::runtime
