#include "services/bus/cyclonedds/cyclonedds_bus.hpp"

#include <mutex>

#include "services/bus/cyclonedds/cyclone_participant.hpp"
#include "services/bus/cyclonedds/cyclone_reader.hpp"
#include "services/bus/cyclonedds/cyclone_writer.hpp"
#include "services/bus/topic_check.hpp"

namespace tonus::bus {
namespace {

/// Cyclone DDS stops its receiving thread while a kKeepAll reader is full; that is how the writer gets to
/// feel it. Such readers therefore have a participant of their own, made for the first of them, so that a
/// slow consumer does not stop acknowledgements, liveliness and states of its process.
class CycloneBus final : public Bus {
 public:
  CycloneBus(BusOptions options, std::shared_ptr<CycloneParticipant> participant)
      : options_(std::move(options)), participant_(std::move(participant)) {}

  Result<std::unique_ptr<Writer>> create_writer(const TopicSpec& topic) override {
    if (auto good = check_topic(topic); !good) return good.error();
    return CycloneWriter::create(participant_, topic);
  }

  Result<std::unique_ptr<Reader>> create_reader(const TopicSpec& topic,
                                                std::shared_ptr<Notifier> notifier) override {
    if (auto good = check_topic(topic); !good) return good.error();
    if (topic.qos.history == History::kKeepLast)
      return CycloneReader::create(participant_, topic, std::move(notifier));
    auto participant = blocking_participant();
    if (!participant) return participant.error();
    return CycloneReader::create(std::move(*participant), topic, std::move(notifier));
  }

 private:
  Result<std::shared_ptr<CycloneParticipant>> blocking_participant() {
    const std::lock_guard lock(mutex_);
    if (blocking_participant_) return blocking_participant_;
    BusOptions options = options_;
    options.participant_name += " (kept in full)";
    auto participant = CycloneParticipant::create(options);
    if (participant) blocking_participant_ = *participant;
    return participant;
  }

  BusOptions options_;
  std::shared_ptr<CycloneParticipant> participant_;
  std::mutex mutex_;
  std::shared_ptr<CycloneParticipant> blocking_participant_;
};

}  // namespace

Result<std::unique_ptr<Bus>> create_cyclonedds_bus(const BusOptions& options) {
  auto participant = CycloneParticipant::create(options);
  if (!participant) return participant.error();
  return std::unique_ptr<Bus>(std::make_unique<CycloneBus>(options, std::move(*participant)));
}

}  // namespace tonus::bus
