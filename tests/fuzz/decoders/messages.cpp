// Messages of the bus: decoded, written again, and turned into what the services compute with.

#include <algorithm>
#include <concepts>

#include "idl/topics.hpp"
#include "services/archive/ingest.hpp"
#include "services/archive/wire.hpp"
#include "services/bus/payload.hpp"
#include "services/contract/rig.hpp"
#include "services/protocol/rig_facts.hpp"
#include "services/store/block_header.hpp"
#include "services/store/memory_store.hpp"
#include "services/store/sample_reader.hpp"
#include "services/store/wire.hpp"
#include "tests/fuzz/decoders/decoder.hpp"

namespace tonus::fuzz {
namespace {

/// What follows from a message in the services that take it.
template <typename T>
void use(const T& value) {
  if constexpr (std::same_as<T, v1::RigDescription>) {
    require_message(contract::geometry_of(value));
    require_message(protocol::facts_of(value));
  } else if constexpr (std::same_as<T, v1::TrialOutcome>) {
    require_message(store::to_record(value));
  } else if constexpr (std::same_as<T, v1::SessionPlan>) {
    static_cast<void>(store::to_record(value));
  } else if constexpr (std::same_as<T, v1::RigState>) {
    static_cast<void>(archive::to_report(value));
  }
}

template <typename T>
void read_as(std::span<const std::byte> payload) {
  const auto value = bus::decode<T>(payload);
  require_message(value);
  if (!value) return;
  const auto written = bus::encode(*value);
  require(written.has_value(), "what was decoded can be encoded");
  const auto again = bus::decode<T>(*written);
  require(again.has_value(), "what was encoded can be decoded");
  const auto rewritten = bus::encode(*again);
  require(rewritten && *rewritten == *written, "a message is the same after it is written and read");
  use(*value);
}

/// A topic's number and a payload.
Bytes message(std::size_t topic, const bus::Payload& payload) {
  Bytes input(1 + payload.size(), static_cast<std::byte>(topic));
  std::copy(payload.begin(), payload.end(), input.begin() + 1);
  return input;
}

v1::SampleBlock some_block() {
  v1::SampleBlock block;
  block.rig_id(id_of("rig/fuzz"));
  block.session_id(id_of("session"));
  block.trial_id(id_of("trial"));
  block.epoch(1);
  block.first_sequence(100);
  block.samples().resize(4);
  return block;
}

template <typename T>
T some() {
  T value;
  if constexpr (std::same_as<T, v1::SampleBlock>) value = some_block();
  if constexpr (std::same_as<T, v1::RigDescription>) value.limits().resize(1);
  if constexpr (std::same_as<T, v1::FlightRecord>) value.cycles().resize(2);
  if constexpr (std::same_as<T, v1::SessionPlan>) value.postures().resize(2);
  if constexpr (std::same_as<T, v1::Estimate>) {
    value.checks().resize(1);
    value.parameters().resize(1);
    value.trials().resize(2);
    value.reasons().emplace_back("too few trials");
  }
  if constexpr (std::same_as<T, v1::ServiceHealth>) value.warnings().emplace_back("a limit is off");
  return value;
}

}  // namespace

void read_cdr(std::span<const std::byte> input) {
  Parts parts(input);
  std::size_t wanted = parts.byte() % topics::kAll.size();
  const auto payload = parts.rest();
  std::apply(
      [&](const auto&... topic) {
        const auto read = [&]<typename T>(const topics::Topic<T>&) {
          if (wanted-- == 0) read_as<T>(payload);
        };
        (read(topic), ...);
      },
      topics::kTyped);
}

std::vector<Bytes> cdr_seeds() {
  std::vector<Bytes> seeds;
  std::apply(
      [&](const auto&... topic) {
        const auto add = [&]<typename T>(const topics::Topic<T>&) {
          if (const auto payload = bus::encode(some<T>())) seeds.push_back(message(seeds.size(), *payload));
        };
        (add(topic), ...);
      },
      topics::kTyped);
  return seeds;
}

void read_block(std::span<const std::byte> input) {
  const auto header = store::read_block_header(input);
  const auto block = bus::decode<v1::SampleBlock>(input);
  require_message(header);
  require_message(block);
  if (header) require(block && block->samples().size() == header->count, "a block that is taken decodes");
  store::Block stored;
  if (header) stored = *header;
  stored.payload = std::make_shared<const std::vector<std::byte>>(input.begin(), input.end());
  require_message(store::decode_block(stored));

  if (!bus::is_payload_good(input, input.size())) return;  // carriers drop it
  ManualClock clock;
  store::MemoryStore memory;
  archive::Ingest ingest(memory, clock);
  bus::Sample sample;
  sample.payload = std::make_shared<const bus::Payload>(input.begin(), input.end());
  sample.key = bus::payload_key(input);
  require_message(archive::feed(ingest, topics::kRigSamples.spec, sample, 1));
  clock.advance(std::chrono::seconds(1));
  static_cast<void>(ingest.step());
  static_cast<void>(ingest.status());
  require_message(ingest.finish());
}

std::vector<Bytes> block_seeds() { return {*bus::encode(some_block())}; }

}  // namespace tonus::fuzz
