#include "services/runtime/rig_stop.hpp"

#include <algorithm>
#include <spdlog/fmt/fmt.h>
#include <utility>

#include "idl/topics.hpp"
#include "services/runtime/drain.hpp"

namespace tonus::runtime {
namespace {

constexpr std::chrono::milliseconds kRepeat{5};

}  // namespace

Result<RigStopSender> RigStopSender::create(std::unique_ptr<bus::Bus> bus, const Clock& clock) {
  auto notifier = std::make_shared<bus::Notifier>();
  TONUS_TRY_ASSIGN(auto writer, bus::TypedWriter<v1::RigStop>::create(*bus, topics::kRigStop));
  TONUS_TRY_ASSIGN(auto stopped, bus::TypedReader<v1::RigStop>::create(*bus, topics::kRigStopped, notifier));
  return RigStopSender(std::move(bus), std::move(writer), std::move(stopped), std::move(notifier), clock);
}

Result<Clock::Duration> RigStopSender::stop(const Id& rig, const Id& stop_id, const std::string& requested_by,
                                            Clock::Duration limit) {
  const Clock::TimePoint begun = clock_->now();
  v1::RigStop stop;
  stop.rig_id(rig);
  stop.stop_id(stop_id);
  stop.requested_by(requested_by);
  while (clock_->now() - begun < limit) {
    stop.number(stop.number() + 1);
    (void)writer_.write(stop);  // best effort: the next one follows
    (void)notifier_->wait_until(std::min(begun + limit, clock_->now() + kRepeat));
    const auto confirmed = drain(stopped_);
    if (std::any_of(confirmed.begin(), confirmed.end(),
                    [&](const auto& received) { return received.value.stop_id() == stop_id; }))
      return clock_->now() - begun;
  }
  return fail(ErrorCode::kTimeout, fmt::format("no rig confirmed the stop within {:.1f} s",
                                               std::chrono::duration<double>(limit).count()));
}

}  // namespace tonus::runtime
