#pragma once

#include <memory>

#include "services/bus/notifier.hpp"
#include "services/bus/typed.hpp"
#include "services/core/clock.hpp"
#include "services/core/id.hpp"

#include <idl/service.h>

namespace tonus::runtime {

/// A clock's reading as the contract has it, ns.
[[nodiscard]] std::int64_t reading(const Clock& clock);

/// Answers those who ask for this program's clock (clock/probe, clock/echo). For one thread.
class ClockAnswer {
 public:
  [[nodiscard]] static Result<ClockAnswer> create(bus::Bus& bus, const Clock& clock, const Id& instance,
                                                  std::shared_ptr<bus::Notifier> notifier);

  /// Answers what has arrived. An answer that the bus does not take is left out: the asker asks again.
  void answer();

 private:
  ClockAnswer(bus::TypedReader<v1::ClockProbe> probes, bus::TypedWriter<v1::ClockEcho> echoes,
              const Clock& clock, const Id& instance);

  bus::TypedReader<v1::ClockProbe> probes_;
  bus::TypedWriter<v1::ClockEcho> echoes_;
  const Clock* clock_;
  Id instance_;
};

}  // namespace tonus::runtime
