#include "services/bus/fastdds/fast_writer.hpp"

#include <algorithm>

#include "services/bus/fastdds/fast_qos.hpp"
#include "services/bus/payload.hpp"

namespace tonus::bus {
namespace {

/// The first two bytes of an entity's identifier are its vendor's (RTPS 2.3, 9.3.1.1); 01 0f is eProsima.
bool is_fast_dds(const fast::InstanceHandle_t& entity) {
  return entity.value[0] == 0x01 && entity.value[1] == 0x0f;
}

}  // namespace

FastWriter::FastWriter(std::shared_ptr<FastParticipant> participant, const TopicSpec& topic)
    : participant_(std::move(participant)),
      name_(topic.name),
      qos_(topic.qos),
      max_payload_bytes_(topic.max_payload_bytes),
      is_bounded_(qos_.reliable && qos_.history == History::kKeepAll) {}

Result<std::unique_ptr<Writer>> FastWriter::create(std::shared_ptr<FastParticipant> participant,
                                                   const TopicSpec& topic) {
  const auto fast_topic = participant->topic(topic);
  if (!fast_topic) return fast_topic.error();
  std::unique_ptr<FastWriter> writer(new FastWriter(std::move(participant), topic));
  fast::StatusMask mask = fast::StatusMask::publication_matched();
  mask << fast::StatusMask::offered_deadline_missed();
  writer->writer_ = writer->participant_->publisher().create_datawriter(
      *fast_topic, fast_writer_qos(topic.qos), writer.get(), mask);
  if (writer->writer_ == nullptr) {
    return fail(ErrorCode::kInvalidArgument,
                "topic '" + writer->name_ + "': Fast DDS refuses a writer of this QoS, or of this identity");
  }
  return std::unique_ptr<Writer>(std::move(writer));
}

FastWriter::~FastWriter() {
  if (writer_ == nullptr) return;
  writer_->set_listener(nullptr);
  // Fast DDS 2.9 gives the history's samples back one by one while heartbeats go on; a heartbeat that looks
  // for gaps among samples that are given back seeks without end, and the destructor waits for it.
  std::size_t removed = 0;
  (void)writer_->clear_history(&removed);
  participant_->publisher().delete_datawriter(writer_);
}

Result<void> FastWriter::write(std::span<const std::byte> payload) {
  const std::lock_guard lock(mutex_);
  auto result = send(payload);
  const std::lock_guard status_lock(status_mutex_);
  ++(result ? status_.written : status_.refused);
  return result;
}

Result<void> FastWriter::send(std::span<const std::byte> payload) {
  if (auto good = check_payload(payload, max_payload_bytes_); !good) return good;
  const auto depth = static_cast<std::size_t>(qos_.depth);
  const Key key = payload_key(payload);
  bool has_room = greet_new_readers();
  if (has_room && is_bounded_ && unacknowledged_ >= depth) {
    // One key only: Fast DDS's own limit holds, and lets the samples through one by one.
    const bool is_one_key = unacknowledged_keys_.size() == 1 && unacknowledged_keys_.contains(key);
    has_room = is_one_key || wait_for_room();
  }
  if (has_room) {
    Payload bytes = padded_copy(payload);
    const ReturnCode_t code = writer_->write(&bytes, fast::HANDLE_NIL);
    if (code == ReturnCode_t::RETCODE_OK) {
      if (is_bounded_) {
        unacknowledged_ = std::min(unacknowledged_ + 1, depth);
        unacknowledged_keys_.insert(key);
      }
      return {};
    }
    if (code != ReturnCode_t::RETCODE_TIMEOUT) {
      return fail(ErrorCode::kInternal,
                  "topic '" + name_ + "': Fast DDS write failed with code " + std::to_string(code()));
    }
  }
  return fail(ErrorCode::kTimeout, "topic '" + name_ + "': history of " + std::to_string(qos_.depth) +
                                       " samples stayed full for " +
                                       std::to_string(qos_.max_blocking.count()) + " ms");
}

bool FastWriter::wait_for_room() {
  if (writer_->wait_for_acknowledgments(fast_duration(qos_.max_blocking)) != ReturnCode_t::RETCODE_OK)
    return false;
  unacknowledged_ = 0;
  unacknowledged_keys_.clear();
  return true;
}

bool FastWriter::greet_new_readers() {
  if (!is_bounded_ || qos_.durability != Durability::kVolatile) return true;
  const int matches = foreign_matches_;
  if (greeted_ == matches) return true;
  if (greeting_sent_ != matches) {
    // A sample like any other. The goodbye of a key that never was would not do: a Fast DDS reader refuses
    // it, never acknowledges it, and holds back everything after it.
    Payload greeting = greeting_payload();
    if (writer_->write(&greeting, fast::HANDLE_NIL) != ReturnCode_t::RETCODE_OK) return false;
    greeting_sent_ = matches;
  }
  if (!wait_for_room()) return false;
  greeted_ = matches;
  return true;
}

WriterStatus FastWriter::status() const {
  const std::lock_guard lock(status_mutex_);
  return status_;
}

bool FastWriter::wait_acknowledged(std::chrono::milliseconds limit) {
  return writer_->wait_for_acknowledgments(fast_duration(limit)) == ReturnCode_t::RETCODE_OK;
}

void FastWriter::on_publication_matched(fast::DataWriter* /*writer*/,
                                        const fast::PublicationMatchedStatus& info) {
  if (info.current_count_change > 0 && !is_fast_dds(info.last_subscription_handle)) ++foreign_matches_;
  const std::lock_guard lock(status_mutex_);
  status_.matched_readers = info.current_count;
}

void FastWriter::on_offered_deadline_missed(fast::DataWriter* /*writer*/,
                                            const fast::OfferedDeadlineMissedStatus& info) {
  const std::lock_guard lock(status_mutex_);
  status_.deadline_missed = info.total_count;
}

}  // namespace tonus::bus
