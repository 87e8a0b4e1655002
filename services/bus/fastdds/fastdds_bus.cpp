#include "services/bus/fastdds/fastdds_bus.hpp"

#include "services/bus/fastdds/fast_participant.hpp"
#include "services/bus/fastdds/fast_reader.hpp"
#include "services/bus/fastdds/fast_writer.hpp"
#include "services/bus/topic_check.hpp"

namespace tonus::bus {
namespace {

class FastBus final : public Bus {
 public:
  explicit FastBus(std::shared_ptr<FastParticipant> participant) : participant_(std::move(participant)) {}

  Result<std::unique_ptr<Writer>> create_writer(const TopicSpec& topic) override {
    if (auto good = check_topic(topic); !good) return good.error();
    return FastWriter::create(participant_, topic);
  }

  Result<std::unique_ptr<Reader>> create_reader(const TopicSpec& topic,
                                                std::shared_ptr<Notifier> notifier) override {
    if (auto good = check_topic(topic); !good) return good.error();
    return FastReader::create(participant_, topic, std::move(notifier));
  }

 private:
  std::shared_ptr<FastParticipant> participant_;
};

}  // namespace

Result<std::unique_ptr<Bus>> create_fastdds_bus(const BusOptions& options) {
  auto participant = FastParticipant::create(options);
  if (!participant) return participant.error();
  return std::unique_ptr<Bus>(std::make_unique<FastBus>(std::move(*participant)));
}

Result<std::vector<std::unique_ptr<Bus>>> create_fastdds_buses(const BusOptions& options,
                                                               const std::vector<Partitions>& places) {
  TONUS_TRY_ASSIGN(const auto owner, FastParticipant::create(options));
  std::vector<std::unique_ptr<Bus>> buses;
  buses.reserve(places.size());
  for (const Partitions& partitions : places)
    buses.push_back(std::make_unique<FastBus>(FastParticipant::beside(owner, partitions)));
  return buses;
}

}  // namespace tonus::bus
