#pragma once

#include <string>

#include "services/bus/cyclonedds/cdr_serdata.hpp"
#include "services/bus/cyclonedds/cyclone_participant.hpp"

namespace tonus::bus {

/// See Writer. Cyclone DDS bounds a writer's history by bytes (Watermarks/WhcHigh); the bound in samples is
/// kept here.
class CycloneWriter final : public Writer {
 public:
  [[nodiscard]] static Result<std::unique_ptr<Writer>> create(std::shared_ptr<CycloneParticipant> participant,
                                                              const TopicSpec& topic);

  Result<void> write(std::span<const std::byte> payload) override;
  [[nodiscard]] WriterStatus status() const override;
  bool wait_acknowledged(std::chrono::milliseconds limit) override;

 private:
  CycloneWriter(std::shared_ptr<CycloneParticipant> participant, const TopicSpec& topic,
                CycloneTopic cyclone_topic, CycloneEntity writer);
  [[nodiscard]] Result<void> send(std::span<const std::byte> payload);
  [[nodiscard]] bool wait_for_room();
  [[nodiscard]] Error full() const;

  std::shared_ptr<CycloneParticipant> participant_;
  std::string name_;
  Qos qos_;
  std::size_t max_payload_bytes_;
  bool is_bounded_;  ///< Reliable and kKeepAll.
  CycloneTopic topic_;
  CycloneEntity writer_;
  std::shared_ptr<HeldPayloads> held_;  ///< Of a bounded volatile writer.

  std::mutex mutex_;        ///< Held while a write() waits, so that writes take effect one at a time.
  int unacknowledged_ = 0;  ///< Of a bounded transient-local writer: at most so many.

  mutable std::mutex status_mutex_;
  std::uint64_t written_ = 0;
  std::uint64_t refused_ = 0;
};

}  // namespace tonus::bus
