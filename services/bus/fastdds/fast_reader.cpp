#include "services/bus/fastdds/fast_reader.hpp"

#include <algorithm>
#include <tuple>

#include "services/bus/fastdds/fast_qos.hpp"
#include "services/bus/payload.hpp"

namespace tonus::bus {
namespace {

using eprosima::fastrtps::rtps::GUID_t;
using eprosima::fastrtps::rtps::SequenceNumber_t;

constexpr std::size_t kMaximumDrain = 65536;  // a writer faster than this thread must not keep it for ever

struct Numbered {
  GUID_t writer;
  SequenceNumber_t number;
  Sample sample;
};

std::int64_t nanoseconds(auto time) {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(time.time_since_epoch()).count();
}

/// Fast DDS stamps receptions with the system clock; the age of the stamp leads to the steady one.
std::int64_t steady_reception(const fast::SampleInfo& info) {
  const std::int64_t age = nanoseconds(std::chrono::system_clock::now()) - info.reception_timestamp.to_ns();
  return nanoseconds(std::chrono::steady_clock::now()) - std::max<std::int64_t>(age, 0);
}

}  // namespace

FastReader::FastReader(std::shared_ptr<FastParticipant> participant, const TopicSpec& topic,
                       std::shared_ptr<Notifier> notifier)
    : participant_(std::move(participant)),
      notifier_(notifier ? std::move(notifier) : std::make_shared<Notifier>()),
      has_liveliness_(topic.qos.liveliness_lease.count() > 0),
      max_payload_bytes_(topic.max_payload_bytes) {}

Result<std::unique_ptr<Reader>> FastReader::create(std::shared_ptr<FastParticipant> participant,
                                                   const TopicSpec& topic,
                                                   std::shared_ptr<Notifier> notifier) {
  const auto fast_topic = participant->topic(topic);
  if (!fast_topic) return fast_topic.error();
  participant->received().allow_message_bytes(topic.max_payload_bytes);
  std::unique_ptr<FastReader> reader(new FastReader(std::move(participant), topic, std::move(notifier)));
  fast::StatusMask mask = fast::StatusMask::data_available();
  mask << fast::StatusMask::subscription_matched() << fast::StatusMask::liveliness_changed()
       << fast::StatusMask::requested_deadline_missed() << fast::StatusMask::sample_lost();
  reader->reader_ = reader->participant_->subscriber().create_datareader(
      *fast_topic, fast_reader_qos(topic.qos), reader.get(), mask);
  if (reader->reader_ == nullptr) {
    return fail(ErrorCode::kInvalidArgument,
                "topic '" + std::string(topic.name) +
                    "': Fast DDS refuses a reader of this QoS, or of this identity");
  }
  return std::unique_ptr<Reader>(std::move(reader));
}

FastReader::~FastReader() {
  if (reader_ == nullptr) return;
  reader_->set_listener(nullptr);
  participant_->subscriber().delete_datareader(reader_);
}

std::size_t FastReader::take(std::vector<Sample>& out, std::size_t max) {
  const std::lock_guard lock(take_mutex_);
  if (drained_.empty()) drain();
  const std::size_t count = std::min(max, drained_.size());
  for (std::size_t i = 0; i < count; ++i) {
    out.push_back(std::move(drained_.front()));
    drained_.pop_front();
  }
  const std::lock_guard status_lock(status_mutex_);
  status_.received += count;
  return count;
}

void FastReader::drain() {
  std::vector<Numbered> batch;
  std::uint64_t malformed = 0;
  Payload bytes;
  fast::SampleInfo info;
  while (batch.size() < kMaximumDrain &&
         reader_->take_next_sample(&bytes, &info) == ReturnCode_t::RETCODE_OK) {
    if (!info.valid_data || is_greeting(bytes)) continue;  // a key left by its writer; nothing to anybody
    if (!is_payload_good(bytes, max_payload_bytes_)) {
      ++malformed;
      continue;
    }
    Sample sample;
    sample.key = payload_key(bytes);
    sample.payload = std::make_shared<const Payload>(std::move(bytes));
    sample.source_timestamp_ns = info.source_timestamp.to_ns();
    sample.received_ns = steady_reception(info);
    batch.push_back(
        {info.sample_identity.writer_guid(), info.sample_identity.sequence_number(), std::move(sample)});
    bytes = Payload();
  }
  std::sort(batch.begin(), batch.end(), [](const Numbered& a, const Numbered& b) {
    return a.writer == b.writer ? a.number < b.number : a.writer < b.writer;
  });
  for (Numbered& numbered : batch) drained_.push_back(std::move(numbered.sample));
  const std::lock_guard lock(status_mutex_);
  status_.malformed += malformed;
}

ReaderStatus FastReader::status() const {
  const std::lock_guard lock(status_mutex_);
  ReaderStatus status = status_;
  status.alive_writers = has_liveliness_ ? std::min(status.alive_writers, status.matched_writers)
                                         : status.matched_writers;  // Fast DDS follows finite leases only
  return status;
}

void FastReader::on_data_available(fast::DataReader* /*reader*/) { notifier_->notify(); }

void FastReader::on_subscription_matched(fast::DataReader* /*reader*/,
                                         const fast::SubscriptionMatchedStatus& info) {
  {
    const std::lock_guard lock(status_mutex_);
    status_.matched_writers = info.current_count;
  }
  notifier_->notify();
}

void FastReader::on_liveliness_changed(fast::DataReader* /*reader*/,
                                       const fast::LivelinessChangedStatus& info) {
  {
    const std::lock_guard lock(status_mutex_);
    status_.alive_writers = info.alive_count;
    if (info.not_alive_count_change > 0) {
      status_.liveliness_lost_events += static_cast<std::uint64_t>(info.not_alive_count_change);
    }
  }
  notifier_->notify();
}

void FastReader::on_requested_deadline_missed(fast::DataReader* /*reader*/,
                                              const fast::RequestedDeadlineMissedStatus& info) {
  {
    const std::lock_guard lock(status_mutex_);
    status_.deadline_missed = info.total_count;
  }
  notifier_->notify();
}

void FastReader::on_sample_lost(fast::DataReader* /*reader*/, const fast::SampleLostStatus& info) {
  {
    const std::lock_guard lock(status_mutex_);
    status_.lost = static_cast<std::uint64_t>(info.total_count);
  }
  notifier_->notify();
}

}  // namespace tonus::bus
