#include "services/runtime/clock_comparison.hpp"

#include <algorithm>
#include <utility>

#include "idl/topics.hpp"
#include "services/runtime/clock_answer.hpp"
#include "services/runtime/drain.hpp"

namespace tonus::runtime {

Result<ClockComparison> ClockComparison::create(bus::Bus& bus, const Clock& clock, const Id& instance,
                                                std::shared_ptr<bus::Notifier> notifier,
                                                const Options& options) {
  auto echoes = bus::TypedReader<v1::ClockEcho>::create(bus, topics::kClockEcho, notifier);
  if (!echoes) return echoes.error();
  auto probes = bus::TypedWriter<v1::ClockProbe>::create(bus, topics::kClockProbe);
  if (!probes) return probes.error();
  auto offsets = bus::TypedWriter<v1::ClockOffset>::create(bus, topics::kClockOffset);
  if (!offsets) return offsets.error();
  return ClockComparison(std::move(*echoes), std::move(*probes), std::move(*offsets), clock, instance,
                         options);
}

ClockComparison::ClockComparison(bus::TypedReader<v1::ClockEcho> echoes,
                                 bus::TypedWriter<v1::ClockProbe> probes,
                                 bus::TypedWriter<v1::ClockOffset> offsets, const Clock& clock,
                                 const Id& instance, const Options& options)
    : echoes_(std::move(echoes)),
      probes_(std::move(probes)),
      offsets_(std::move(offsets)),
      clock_(&clock),
      instance_(instance),
      options_(options) {}

Clock::TimePoint ClockComparison::step(const Roster& roster) {
  meet(roster);
  take_answers();
  Clock::TimePoint due = clock_->now() + options_.period;
  for (auto& [id, peer] : peers_) {
    if (clock_->now() >= peer.due) {
      if (peer.under_way == 0) {
        peer.left = options_.questions;
        ask(id, peer);
      } else {
        go_on(id, peer);  // an answer that comes after this is of no use: its number is forgotten
      }
    }
    due = std::min(due, peer.due);
  }
  return due;
}

void ClockComparison::meet(const Roster& roster) {
  const auto present = roster.present();
  for (const v1::ServiceHealth& health : present) {
    const Id id = health.instance_id();
    if (id == instance_) continue;
    const auto [place, is_new] = peers_.try_emplace(id);
    if (!is_new && place->second.started_ns == health.started_ns()) continue;
    place->second = Peer{};
    place->second.started_ns = health.started_ns();
    place->second.left = options_.first_questions;
    ask(id, place->second);
  }
  std::erase_if(peers_, [&present](const auto& peer) {
    return std::none_of(present.begin(), present.end(),
                        [&peer](const auto& health) { return health.instance_id() == peer.first; });
  });
}

void ClockComparison::take_answers() {
  for (const auto& echo : drain(echoes_)) {
    const auto peer = peers_.find(echo.value.answerer_id());
    if (echo.value.asker_id() != instance_ || peer == peers_.end()) continue;
    if (echo.value.number() != peer->second.under_way) continue;
    peer->second.offset.add(
        {echo.value.asked_ns(), echo.value.received_ns(), echo.value.answered_ns(), reading(*clock_)});
    go_on(peer->first, peer->second);
  }
}

void ClockComparison::go_on(const Id& id, Peer& peer) {
  --peer.left;
  if (peer.left > 0) return ask(id, peer);
  peer.left = 0;
  peer.under_way = 0;
  peer.due = clock_->now() + options_.period;
  publish(id, peer);
}

void ClockComparison::ask(const Id& id, Peer& peer) {
  peer.under_way = ++number_;
  peer.due = clock_->now() + options_.patience;
  v1::ClockProbe probe;
  probe.asker_id(instance_);
  probe.answerer_id(id);
  probe.number(peer.under_way);
  probe.asked_ns(reading(*clock_));
  (void)probes_.write(probe);  // one that the bus refuses is one without an answer
}

void ClockComparison::publish(const Id& id, const Peer& peer) {
  const auto difference = peer.offset.at(reading(*clock_));
  if (!difference) return;
  v1::ClockOffset offset;
  offset.pair_id(id_of("clock/" + to_hex(instance_) + "/" + to_hex(id)));
  offset.asker_id(instance_);
  offset.answerer_id(id);
  offset.offset_ns(difference->offset);
  offset.uncertainty_ns(difference->uncertainty);
  offset.probes(difference->round_trips);
  offset.measured_ns(clock_->utc_ns());
  (void)offsets_.write(offset);  // the next round's follows
}

}  // namespace tonus::runtime
