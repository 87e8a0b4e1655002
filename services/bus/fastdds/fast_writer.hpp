#pragma once

#include <atomic>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/DataWriterListener.hpp>
#include <set>

#include "services/bus/fastdds/fast_participant.hpp"

namespace tonus::bus {

/// See Writer. Two things are added to what Fast DDS does for a reliable kKeepAll writer. A history of
/// several keys is bounded in total, as Fast DDS only bounds each key's. And a volatile writer waits for the
/// answer of a new reader of another vendor: Cyclone DDS lets go whatever is missing from before its first
/// heartbeat, so a packet lost at the start would never be asked for again.
class FastWriter final : public Writer, private fast::DataWriterListener {
 public:
  [[nodiscard]] static Result<std::unique_ptr<Writer>> create(std::shared_ptr<FastParticipant> participant,
                                                              const TopicSpec& topic);
  ~FastWriter() override;

  Result<void> write(std::span<const std::byte> payload) override;
  [[nodiscard]] WriterStatus status() const override;
  bool wait_acknowledged(std::chrono::milliseconds limit) override;

 private:
  FastWriter(std::shared_ptr<FastParticipant> participant, const TopicSpec& topic);
  [[nodiscard]] bool wait_for_room();
  [[nodiscard]] bool greet_new_readers();
  [[nodiscard]] Result<void> send(std::span<const std::byte> payload);

  void on_publication_matched(fast::DataWriter* writer, const fast::PublicationMatchedStatus& info) override;
  void on_offered_deadline_missed(fast::DataWriter* writer,
                                  const fast::OfferedDeadlineMissedStatus& info) override;

  std::shared_ptr<FastParticipant> participant_;
  std::string name_;
  Qos qos_;
  std::size_t max_payload_bytes_;
  bool is_bounded_;  ///< Reliable and kKeepAll.
  fast::DataWriter* writer_ = nullptr;

  mutable std::mutex mutex_;        ///< Held while a write() waits, so that writes take effect one at a time.
  std::size_t unacknowledged_ = 0;  ///< At most so many of the accepted samples.
  std::set<Key> unacknowledged_keys_;
  int greeted_ = 0;        ///< Of foreign_matches_, those that have answered.
  int greeting_sent_ = 0;  ///< Of foreign_matches_, those that the last greeting was for.

  std::atomic<int> foreign_matches_{0};  ///< How often a reader of another vendor was matched.

  mutable std::mutex status_mutex_;
  WriterStatus status_;
};

}  // namespace tonus::bus
