#include "tests/bench/rigs/bare_reader.hpp"

#include <chrono>
#include <cstring>

#include "idl/topics.hpp"
#include "services/bus/typed.hpp"

namespace tonus::bench {
namespace {

constexpr std::size_t kAnswerBytes = 1200;  // of an estimate

/// Number of the block's first sample.
std::uint64_t read_first(const bus::Payload& payload) {
  const auto block = bus::decode<v1::SampleBlock>(payload);
  return block ? block->first_sequence() : 0;
}

}  // namespace

bus::TopicSpec answer_topic() { return {"bench/answer", "tonus::bench::Answer", topics::qos::kLive, 60000}; }

int answer_every_block(const bus::BusOptions& options, const std::vector<std::string>& rigs) {
  const auto notifier = std::make_shared<bus::Notifier>();
  const auto buses = bus::create_buses(options, {rigs, {kAnswers}});
  if (!buses) return 1;
  auto reader = buses->at(0)->create_reader(topics::kRigSamples.spec, notifier);
  auto writer = buses->at(1)->create_writer(answer_topic());
  if (!reader || !writer) return 1;
  bus::Payload answer(kAnswerBytes);
  answer[1] = std::byte{1};  // plain CDR, little endian
  std::vector<bus::Sample> samples;
  while (true) {
    (void)notifier->wait_until(std::chrono::steady_clock::time_point::max());
    samples.clear();
    while ((*reader)->take(samples, 512) == 512) {
    }
    for (const bus::Sample& sample : samples) {
      const std::uint64_t first = read_first(*sample.payload);
      std::memcpy(answer.data() + 4, sample.key.data(), sample.key.size());
      std::memcpy(answer.data() + kNumberAt, &first, sizeof first);
      (void)(*writer)->write(answer);
    }
  }
}

}  // namespace tonus::bench
