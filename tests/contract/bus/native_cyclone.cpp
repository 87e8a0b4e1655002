#include <algorithm>
#include <array>
#include <generated/cyclone/probe.h>

#include "services/bus/cyclonedds/cdr_serdata.hpp"
#include "services/bus/cyclonedds/cyclone_participant.hpp"
#include "services/bus/cyclonedds/cyclone_qos.hpp"
#include "tests/contract/bus/native_peers.hpp"
#include "tests/contract/bus/test_topics.hpp"

namespace tonus::bus::test {
namespace {

using WireProbe = tonus_bus_test_v1_Probe;

class NativeCyclone final : public NativePeer {
 public:
  explicit NativeCyclone(std::shared_ptr<CycloneParticipant> participant)
      : participant_(std::move(participant)),
        topic_(dds_create_topic(participant_->get(), &tonus_bus_test_v1_Probe_desc, kNativeTopic, nullptr,
                                nullptr)),
        writer_(
            dds_create_writer(participant_->get(), topic_.get(), CycloneQos::of_writer(kQos).get(), nullptr)),
        reader_(dds_create_reader(participant_->get(), topic_.get(), CycloneQos::of_reader(kQos).get(),
                                  nullptr)) {}

  bool write(const ProbeFacts& facts) override {
    WireProbe probe{};
    std::copy(facts.id.begin(), facts.id.end(), std::begin(probe.probe_id));
    probe.sequence_number = facts.sequence_number;
    probe.note = const_cast<char*>(facts.note.c_str());
    probe.values._buffer = const_cast<double*>(facts.values.data());
    probe.values._length = probe.values._maximum = static_cast<std::uint32_t>(facts.values.size());
    probe.tail = facts.tail;
    return dds_write(writer_.get(), &probe) == DDS_RETCODE_OK;
  }

  std::vector<ProbeFacts> take() override {
    std::array<void*, 64> samples{};
    std::array<dds_sample_info_t, 64> infos{};
    const dds_return_t count =
        dds_take(reader_.get(), samples.data(), infos.data(), samples.size(), samples.size());
    std::vector<ProbeFacts> out;
    for (std::size_t i = 0; i < static_cast<std::size_t>(std::max(count, 0)); ++i) {
      if (!infos[i].valid_data) continue;
      const auto& probe = *static_cast<const WireProbe*>(samples[i]);
      ProbeFacts facts;
      std::copy(std::begin(probe.probe_id), std::end(probe.probe_id), facts.id.begin());
      facts.sequence_number = probe.sequence_number;
      facts.note = probe.note;
      facts.values.assign(probe.values._buffer, probe.values._buffer + probe.values._length);
      facts.tail = probe.tail;
      out.push_back(std::move(facts));
    }
    if (count > 0) dds_return_loan(reader_.get(), samples.data(), count);
    return out;
  }

 private:
  static const Qos kQos;
  std::shared_ptr<CycloneParticipant> participant_;
  CycloneEntity topic_;
  CycloneEntity writer_;
  CycloneEntity reader_;
};

const Qos NativeCyclone::kQos = keep_all(100, Durability::kTransientLocal);

class RawCyclone final : public RawWriter {
 public:
  RawCyclone(std::shared_ptr<CycloneParticipant> participant, const TopicSpec& topic)
      : participant_(std::move(participant)),
        topic_(std::move(*participant_->create_topic(topic))),
        writer_(dds_create_writer(participant_->get(), topic_.entity.get(),
                                  CycloneQos::of_writer(topic.qos).get(), nullptr)) {}

  bool write(Payload bytes) override {
    auto data = std::make_unique<CdrSerdata>(topic_.type, SDK_DATA,
                                             std::make_shared<const Payload>(std::move(bytes)));
    return dds_writecdr(writer_.get(), data.release()) == DDS_RETCODE_OK;
  }
  [[nodiscard]] int matched_readers() const override {
    dds_publication_matched_status_t status{};
    dds_get_publication_matched_status(writer_.get(), &status);
    return static_cast<int>(status.current_count);
  }

 private:
  std::shared_ptr<CycloneParticipant> participant_;
  CycloneTopic topic_;
  CycloneEntity writer_;
};

}  // namespace

std::unique_ptr<NativePeer> open_native_cyclone(const BusOptions& options) {
  auto participant = CycloneParticipant::create(options);
  return participant ? std::make_unique<NativeCyclone>(*participant) : nullptr;
}

std::unique_ptr<RawWriter> open_raw_cyclone(const BusOptions& options, const TopicSpec& topic) {
  auto participant = CycloneParticipant::create(options);
  return participant ? std::make_unique<RawCyclone>(*participant, topic) : nullptr;
}

}  // namespace tonus::bus::test
