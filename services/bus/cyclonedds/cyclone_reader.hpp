#pragma once

#include <atomic>
#include <deque>
#include <mutex>

#include "services/bus/cyclonedds/cyclone_participant.hpp"

namespace tonus::bus {

/// See Reader. Cyclone DDS hands out samples key by key; so take() empties its history at once and puts the
/// samples back into the order of their arrival.
class CycloneReader final : public Reader {
 public:
  [[nodiscard]] static Result<std::unique_ptr<Reader>> create(std::shared_ptr<CycloneParticipant> participant,
                                                              const TopicSpec& topic,
                                                              std::shared_ptr<Notifier> notifier);

  std::size_t take(std::vector<Sample>& out, std::size_t max) override;
  [[nodiscard]] ReaderStatus status() const override;

 private:
  /// What the listener touches; it only counts and signals.
  struct Events {
    std::shared_ptr<Notifier> notifier;
    std::atomic<std::uint64_t> liveliness_lost{0};
  };

  CycloneReader(std::shared_ptr<CycloneParticipant> participant, const TopicSpec& topic,
                std::shared_ptr<Notifier> notifier);
  [[nodiscard]] Result<void> open(const TopicSpec& topic);
  void drain();

  static void on_data_available(dds_entity_t reader, void* events);
  static void on_subscription_matched(dds_entity_t reader, dds_subscription_matched_status_t status,
                                      void* events);
  static void on_liveliness_changed(dds_entity_t reader, dds_liveliness_changed_status_t status,
                                    void* events);
  static void on_deadline_missed(dds_entity_t reader, dds_requested_deadline_missed_status_t status,
                                 void* events);
  static void on_sample_lost(dds_entity_t reader, dds_sample_lost_status_t status, void* events);

  std::shared_ptr<CycloneParticipant> participant_;
  std::size_t max_payload_bytes_;
  Events events_;
  CycloneTopic topic_;
  CycloneEntity reader_;

  std::mutex take_mutex_;
  std::deque<Sample> drained_;

  std::atomic<std::uint64_t> received_{0};
  std::atomic<std::uint64_t> malformed_{0};
};

}  // namespace tonus::bus
