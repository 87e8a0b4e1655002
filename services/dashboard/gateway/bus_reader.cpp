#include "services/dashboard/gateway/bus_reader.hpp"

#include <utility>

namespace tonus::dashboard {
namespace {

constexpr std::size_t kBatch = 256;
constexpr std::chrono::seconds kKeepUnwanted{5};
constexpr std::chrono::milliseconds kLook{500};

}  // namespace

Result<std::unique_ptr<BusReader>> BusReader::create(bus::Bus& bus, const std::vector<OfferedTopic>& topics,
                                                     Inbox& inbox, const Clock& clock,
                                                     std::shared_ptr<bus::Notifier> notifier) {
  std::unique_ptr<BusReader> made(new BusReader(bus, inbox, clock, std::move(notifier)));
  for (const OfferedTopic& topic : topics) {
    if (topic.reading.name.empty()) continue;
    auto source = std::make_unique<Source>();
    source->topic = topic;
    source->is_wanted = topic.flow != Flow::kLive;
    if (source->is_wanted) {
      if (auto opened = made->open(*source); !opened) return opened.error();
    }
    made->sources_.push_back(std::move(source));
  }
  return made;
}

Result<void> BusReader::open(Source& source) {
  auto reader = bus_.create_reader(source.topic.reading, notifier_);
  if (!reader) return reader.error();
  source.reader = std::move(*reader);
  return {};
}

Result<Clock::TimePoint> BusReader::step() {
  for (const auto& source : sources_) {
    if (source->topic.flow == Flow::kLive) close_if_unwanted(*source);
    if (!source->reader && source->is_wanted.load(std::memory_order_relaxed)) {
      if (auto opened = open(*source); !opened) return opened.error();
    }
    if (source->reader) pass_on(*source);
  }
  return clock_.now() + kLook;
}

void BusReader::close_if_unwanted(Source& source) {
  if (source.is_wanted.load(std::memory_order_relaxed)) {
    source.unwanted_since = {};
  } else if (source.reader) {
    if (source.unwanted_since == Clock::TimePoint{}) source.unwanted_since = clock_.now();
    if (clock_.now() - source.unwanted_since > kKeepUnwanted) source.reader.reset();
  }
}

void BusReader::pass_on(Source& source) {
  const bool is_live = source.topic.flow == Flow::kLive;
  samples_.clear();
  while (source.reader->take(samples_, kBatch) == kBatch) {
  }
  for (bus::Sample& sample : samples_) {
    const auto received = Clock::TimePoint(std::chrono::nanoseconds(sample.received_ns));
    lag_ = std::chrono::duration<double>(clock_.now() - received).count();
    inbox_.put({source.topic.channel.id, sample.key, static_cast<std::uint64_t>(sample.source_timestamp_ns),
                std::move(sample.payload)},
               is_live);
  }
}

void BusReader::want(std::uint32_t channel, bool is_wanted) {
  for (const auto& source : sources_) {
    if (source->topic.channel.id != channel || source->topic.flow != Flow::kLive) continue;
    if (source->is_wanted.exchange(is_wanted, std::memory_order_relaxed) != is_wanted) notifier_->notify();
  }
}

std::uint64_t BusReader::malformed() const {
  std::uint64_t sum = 0;
  for (const auto& source : sources_) {
    if (source->reader) sum += source->reader->status().malformed;
  }
  return sum;
}

}  // namespace tonus::dashboard
