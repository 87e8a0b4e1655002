#include "services/bus/cyclonedds/cyclonedds_bus.hpp"

#include <mutex>
#include <optional>

#include "services/bus/cyclonedds/cyclone_participant.hpp"
#include "services/bus/cyclonedds/cyclone_reader.hpp"
#include "services/bus/cyclonedds/cyclone_writer.hpp"
#include "services/bus/topic_check.hpp"

namespace tonus::bus {
namespace {

/// Cyclone DDS stops its receiving thread while a kKeepAll reader is full; that is how the writer gets to
/// feel it. Such readers therefore have a participant of their own, made for the first of them, so that a
/// slow consumer does not stop acknowledgements, liveliness and states of its process.
class BlockingParticipant {
 public:
  explicit BlockingParticipant(BusOptions options) : options_(std::move(options)) {
    options_.participant_name += " (kept in full)";
  }

  Result<std::shared_ptr<CycloneParticipant>> get() {
    const std::lock_guard lock(mutex_);
    if (participant_) return participant_;
    auto participant = CycloneParticipant::create(options_);
    if (participant) participant_ = *participant;
    return participant;
  }

 private:
  BusOptions options_;
  std::mutex mutex_;
  std::shared_ptr<CycloneParticipant> participant_;
};

class CycloneBus final : public Bus {
 public:
  /// `partitions`, of one place of several: those of the readers that may block.
  CycloneBus(std::shared_ptr<CycloneParticipant> participant, std::shared_ptr<BlockingParticipant> blocking,
             std::optional<Partitions> partitions = std::nullopt)
      : participant_(std::move(participant)),
        blocking_(std::move(blocking)),
        partitions_(std::move(partitions)) {}

  Result<std::unique_ptr<Writer>> create_writer(const TopicSpec& topic) override {
    if (auto good = check_topic(topic); !good) return good.error();
    return CycloneWriter::create(participant_, topic);
  }

  Result<std::unique_ptr<Reader>> create_reader(const TopicSpec& topic,
                                                std::shared_ptr<Notifier> notifier) override {
    if (auto good = check_topic(topic); !good) return good.error();
    if (topic.qos.history == History::kKeepLast)
      return CycloneReader::create(participant_, topic, std::move(notifier));
    TONUS_TRY_ASSIGN(auto participant, blocking_participant());
    return CycloneReader::create(std::move(participant), topic, std::move(notifier));
  }

 private:
  Result<std::shared_ptr<CycloneParticipant>> blocking_participant() {
    const std::lock_guard lock(mutex_);
    if (blocking_here_) return blocking_here_;
    TONUS_TRY_ASSIGN(auto shared, blocking_->get());
    blocking_here_ = partitions_ ? CycloneParticipant::beside(std::move(shared), *partitions_) : shared;
    return blocking_here_;
  }

  std::shared_ptr<CycloneParticipant> participant_;
  std::shared_ptr<BlockingParticipant> blocking_;
  std::optional<Partitions> partitions_;
  std::mutex mutex_;
  std::shared_ptr<CycloneParticipant> blocking_here_;
};

}  // namespace

Result<std::unique_ptr<Bus>> create_cyclonedds_bus(const BusOptions& options) {
  TONUS_TRY_ASSIGN(auto participant, CycloneParticipant::create(options));
  return std::unique_ptr<Bus>(
      std::make_unique<CycloneBus>(std::move(participant), std::make_shared<BlockingParticipant>(options)));
}

Result<std::vector<std::unique_ptr<Bus>>> create_cyclonedds_buses(const BusOptions& options,
                                                                  const std::vector<Partitions>& places) {
  TONUS_TRY_ASSIGN(const auto owner, CycloneParticipant::create(options));
  const auto blocking = std::make_shared<BlockingParticipant>(options);
  std::vector<std::unique_ptr<Bus>> buses;
  buses.reserve(places.size());
  for (const Partitions& partitions : places)
    buses.push_back(
        std::make_unique<CycloneBus>(CycloneParticipant::beside(owner, partitions), blocking, partitions));
  return buses;
}

}  // namespace tonus::bus
