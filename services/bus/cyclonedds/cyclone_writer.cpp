#include "services/bus/cyclonedds/cyclone_writer.hpp"

#include <utility>

#include "services/bus/cyclonedds/cyclone_qos.hpp"
#include "services/bus/payload.hpp"

namespace tonus::bus {

CycloneWriter::CycloneWriter(std::shared_ptr<CycloneParticipant> participant, const TopicSpec& topic,
                             CycloneTopic cyclone_topic, CycloneEntity writer)
    : participant_(std::move(participant)),
      name_(topic.name),
      qos_(topic.qos),
      max_payload_bytes_(topic.max_payload_bytes),
      is_bounded_(qos_.reliable && qos_.history == History::kKeepAll),
      topic_(std::move(cyclone_topic)),
      writer_(std::move(writer)) {
  if (is_bounded_ && qos_.durability == Durability::kVolatile) held_ = std::make_shared<HeldPayloads>();
}

Result<std::unique_ptr<Writer>> CycloneWriter::create(std::shared_ptr<CycloneParticipant> participant,
                                                      const TopicSpec& topic) {
  auto cyclone_topic = participant->create_topic(topic);
  if (!cyclone_topic) return cyclone_topic.error();
  CycloneEntity writer(dds_create_writer(participant->publisher(), cyclone_topic->entity.get(),
                                         CycloneQos::of_writer(topic.qos).get(), nullptr));
  if (writer.get() <= 0) {
    return fail(ErrorCode::kInvalidArgument,
                "topic '" + std::string(topic.name) +
                    "': Cyclone DDS refuses a writer of this QoS, or of this identity: " +
                    dds_strretcode(-writer.get()));
  }
  return std::unique_ptr<Writer>(
      new CycloneWriter(std::move(participant), topic, std::move(*cyclone_topic), std::move(writer)));
}

Result<void> CycloneWriter::write(std::span<const std::byte> payload) {
  const std::lock_guard lock(mutex_);
  auto result = send(payload);
  const std::lock_guard status_lock(status_mutex_);
  ++(result ? written_ : refused_);
  return result;
}

Result<void> CycloneWriter::send(std::span<const std::byte> payload) {
  if (auto good = check_payload(payload, max_payload_bytes_); !good) return good;
  if (is_bounded_ && !wait_for_room()) return full();
  auto data = std::make_unique<CdrSerdata>(topic_.type, SDK_DATA,
                                           std::make_shared<const Payload>(padded_copy(payload)));
  if (held_) {
    held_->add();
    data->held = held_;
  }
  const dds_return_t code = dds_writecdr(writer_.get(), data.release());  // takes the reference in any case
  if (code == DDS_RETCODE_TIMEOUT) return full();
  if (code != DDS_RETCODE_OK) {
    return fail(ErrorCode::kInternal,
                "topic '" + name_ + "': Cyclone DDS write failed: " + dds_strretcode(-code));
  }
  if (is_bounded_ && !held_) ++unacknowledged_;
  return {};
}

bool CycloneWriter::wait_for_room() {
  if (held_) return held_->wait_below(static_cast<std::size_t>(qos_.depth), qos_.max_blocking);
  if (unacknowledged_ < qos_.depth) return true;
  if (!wait_acknowledged(qos_.max_blocking)) return false;
  unacknowledged_ = 0;
  return true;
}

Error CycloneWriter::full() const {
  return fail(ErrorCode::kTimeout, "topic '" + name_ + "': history of " + std::to_string(qos_.depth) +
                                       " samples stayed full for " +
                                       std::to_string(qos_.max_blocking.count()) + " ms");
}

WriterStatus CycloneWriter::status() const {
  WriterStatus status;
  dds_publication_matched_status_t matched{};
  if (dds_get_publication_matched_status(writer_.get(), &matched) == DDS_RETCODE_OK) {
    status.matched_readers = static_cast<int>(matched.current_count);
  }
  dds_offered_deadline_missed_status_t missed{};
  if (dds_get_offered_deadline_missed_status(writer_.get(), &missed) == DDS_RETCODE_OK) {
    status.deadline_missed = missed.total_count;
  }
  const std::lock_guard lock(status_mutex_);
  status.written = written_;
  status.refused = refused_;
  return status;
}

bool CycloneWriter::wait_acknowledged(std::chrono::milliseconds limit) {
  return dds_wait_for_acks(writer_.get(), cyclone_duration(limit)) == DDS_RETCODE_OK;
}

}  // namespace tonus::bus
