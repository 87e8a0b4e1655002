#include "services/bus/cyclonedds/cyclone_reader.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "services/bus/cyclonedds/cdr_serdata.hpp"
#include "services/bus/cyclonedds/cyclone_qos.hpp"
#include "services/bus/payload.hpp"

namespace tonus::bus {
namespace {

constexpr std::size_t kBatch = 256;
constexpr std::size_t kMaximumDrain = 65536;  // a writer faster than this thread must not keep it for ever

using Arrived = std::pair<std::uint64_t, Sample>;

Sample to_sample(const CdrSerdata& data, const dds_sample_info_t& info) {
  Sample sample;
  sample.payload = data.payload;
  sample.key = data.key;
  sample.source_timestamp_ns = info.source_timestamp;
  sample.received_ns = data.received_ns;
  return sample;
}

}  // namespace

CycloneReader::CycloneReader(std::shared_ptr<CycloneParticipant> participant, const TopicSpec& topic,
                             std::shared_ptr<Notifier> notifier)
    : participant_(std::move(participant)), max_payload_bytes_(topic.max_payload_bytes) {
  events_.notifier = notifier ? std::move(notifier) : std::make_shared<Notifier>();
}

Result<std::unique_ptr<Reader>> CycloneReader::create(std::shared_ptr<CycloneParticipant> participant,
                                                      const TopicSpec& topic,
                                                      std::shared_ptr<Notifier> notifier) {
  std::unique_ptr<CycloneReader> reader(
      new CycloneReader(std::move(participant), topic, std::move(notifier)));
  if (auto opened = reader->open(topic); !opened) return opened.error();
  return std::unique_ptr<Reader>(std::move(reader));
}

Result<void> CycloneReader::open(const TopicSpec& topic) {
  auto cyclone_topic = participant_->create_topic(topic);
  if (!cyclone_topic) return cyclone_topic.error();
  topic_ = std::move(*cyclone_topic);
  const std::unique_ptr<dds_listener_t, void (*)(dds_listener_t*)> listener(dds_create_listener(&events_),
                                                                            dds_delete_listener);
  dds_lset_data_available(listener.get(), on_data_available);
  dds_lset_subscription_matched(listener.get(), on_subscription_matched);
  dds_lset_liveliness_changed(listener.get(), on_liveliness_changed);
  dds_lset_requested_deadline_missed(listener.get(), on_deadline_missed);
  dds_lset_sample_lost(listener.get(), on_sample_lost);
  reader_ = CycloneEntity(dds_create_reader(participant_->subscriber(), topic_.entity.get(),
                                            CycloneQos::of_reader(topic.qos).get(), listener.get()));
  if (reader_.get() <= 0) {
    return fail(ErrorCode::kInvalidArgument,
                "topic '" + std::string(topic.name) +
                    "': Cyclone DDS refuses a reader of this QoS, or of this identity: " +
                    dds_strretcode(-reader_.get()));
  }
  return {};
}

std::size_t CycloneReader::take(std::vector<Sample>& out, std::size_t max) {
  const std::lock_guard lock(take_mutex_);
  if (drained_.empty()) drain();
  const std::size_t count = std::min(max, drained_.size());
  for (std::size_t i = 0; i < count; ++i) {
    out.push_back(std::move(drained_.front()));
    drained_.pop_front();
  }
  received_ += count;
  return count;
}

void CycloneReader::drain() {
  std::vector<Arrived> arrived;
  std::array<ddsi_serdata*, kBatch> batch{};
  std::array<dds_sample_info_t, kBatch> infos{};
  dds_return_t count = 0;
  do {
    count = dds_takecdr(reader_.get(), batch.data(), kBatch, infos.data(), DDS_ANY_STATE);
    for (std::size_t i = 0; i < static_cast<std::size_t>(std::max(count, 0)); ++i) {
      const auto& data = *static_cast<const CdrSerdata*>(batch[i]);
      if (infos[i].valid_data && !is_greeting(*data.payload)) {  // else a key left by its writer, or nothing
        if (is_payload_good(*data.payload, max_payload_bytes_)) {
          arrived.emplace_back(data.arrival, to_sample(data, infos[i]));
        } else {
          ++malformed_;
        }
      }
      ddsi_serdata_unref(batch[i]);
    }
  } while (count == static_cast<dds_return_t>(kBatch) && arrived.size() < kMaximumDrain);
  std::sort(arrived.begin(), arrived.end(),
            [](const Arrived& a, const Arrived& b) { return a.first < b.first; });
  for (Arrived& sample : arrived) drained_.push_back(std::move(sample.second));
}

ReaderStatus CycloneReader::status() const {
  ReaderStatus status;
  dds_subscription_matched_status_t matched{};
  if (dds_get_subscription_matched_status(reader_.get(), &matched) == DDS_RETCODE_OK) {
    status.matched_writers = static_cast<int>(matched.current_count);
  }
  dds_liveliness_changed_status_t liveliness{};
  if (dds_get_liveliness_changed_status(reader_.get(), &liveliness) == DDS_RETCODE_OK) {
    status.alive_writers = static_cast<int>(liveliness.alive_count);
  }
  dds_sample_lost_status_t lost{};
  if (dds_get_sample_lost_status(reader_.get(), &lost) == DDS_RETCODE_OK) status.lost = lost.total_count;
  dds_requested_deadline_missed_status_t missed{};
  if (dds_get_requested_deadline_missed_status(reader_.get(), &missed) == DDS_RETCODE_OK) {
    status.deadline_missed = missed.total_count;
  }
  status.received = received_;
  status.malformed = malformed_;
  status.liveliness_lost_events = events_.liveliness_lost;
  return status;
}

void CycloneReader::on_data_available(dds_entity_t, void* events) {
  static_cast<Events*>(events)->notifier->notify();
}

void CycloneReader::on_subscription_matched(dds_entity_t, dds_subscription_matched_status_t, void* events) {
  static_cast<Events*>(events)->notifier->notify();
}

void CycloneReader::on_liveliness_changed(dds_entity_t, dds_liveliness_changed_status_t status,
                                          void* events) {
  auto& target = *static_cast<Events*>(events);
  if (status.not_alive_count_change > 0) {
    target.liveliness_lost += static_cast<std::uint64_t>(status.not_alive_count_change);
  }
  target.notifier->notify();
}

void CycloneReader::on_deadline_missed(dds_entity_t, dds_requested_deadline_missed_status_t, void* events) {
  static_cast<Events*>(events)->notifier->notify();
}

void CycloneReader::on_sample_lost(dds_entity_t, dds_sample_lost_status_t, void* events) {
  static_cast<Events*>(events)->notifier->notify();
}

}  // namespace tonus::bus
