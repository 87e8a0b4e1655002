#include <algorithm>
#include <generated/impostor/impostor.h>

#include "services/bus/cyclonedds/cyclone_participant.hpp"
#include "services/bus/cyclonedds/cyclone_qos.hpp"
#include "tests/contract/bus/native_peers.hpp"

namespace tonus::bus::test {
namespace {

class CycloneImpostor final : public Impostor {
 public:
  CycloneImpostor(std::shared_ptr<CycloneParticipant> participant, const TopicSpec& topic)
      : participant_(std::move(participant)),
        topic_(dds_create_topic(participant_->get(), &tonus_bus_test_v1_Probe_desc,
                                std::string(topic.name).c_str(), nullptr, nullptr)),
        writer_(dds_create_writer(participant_->get(), topic_.get(), CycloneQos::of_writer(topic.qos).get(),
                                  nullptr)) {}

  bool write(const Key& id, std::uint64_t number) override {
    tonus_bus_test_v1_Probe probe{};
    std::copy(id.begin(), id.end(), std::begin(probe.probe_id));
    probe.sequence_number = number;
    return dds_write(writer_.get(), &probe) == DDS_RETCODE_OK;
  }

 private:
  std::shared_ptr<CycloneParticipant> participant_;
  CycloneEntity topic_;
  CycloneEntity writer_;
};

}  // namespace

std::unique_ptr<Impostor> open_impostor(const BusOptions& options, const TopicSpec& topic) {
  auto participant = CycloneParticipant::create(options);
  return participant ? std::make_unique<CycloneImpostor>(*participant, topic) : nullptr;
}

}  // namespace tonus::bus::test
