#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/topic/TypeSupport.hpp>
#include <generated/fast/probePubSubTypes.h>

#include "services/bus/fastdds/fast_participant.hpp"
#include "services/bus/fastdds/fast_qos.hpp"
#include "services/bus/fastdds/fast_writer.hpp"
#include "tests/contract/bus/native_peers.hpp"
#include "tests/contract/bus/test_topics.hpp"

namespace tonus::bus::test {
namespace {

using bus_test::v1::Probe;

/// A native participant with one topic. Writer and reader have one each: a generated type support keeps a key
/// buffer that it shares between the threads of both.
class NativeParticipant {
 public:
  explicit NativeParticipant(const BusOptions& options)
      : participant_(fast::DomainParticipantFactory::get_instance()->create_participant(
            static_cast<fast::DomainId_t>(options.domain), fast_participant_qos(options))) {
    const fast::TypeSupport type(new bus_test::v1::ProbePubSubType());
    participant_->register_type(type);
    topic_ = participant_->create_topic(kNativeTopic, type.get_type_name(), fast::TOPIC_QOS_DEFAULT);
  }
  ~NativeParticipant() {
    participant_->delete_contained_entities();
    fast::DomainParticipantFactory::get_instance()->delete_participant(participant_);
  }
  NativeParticipant(const NativeParticipant&) = delete;
  NativeParticipant& operator=(const NativeParticipant&) = delete;

  [[nodiscard]] fast::DataWriter* create_writer(const Qos& qos) {
    return participant_->create_publisher(fast::PUBLISHER_QOS_DEFAULT)
        ->create_datawriter(topic_, fast_writer_qos(qos));
  }
  [[nodiscard]] fast::DataReader* create_reader(const Qos& qos) {
    return participant_->create_subscriber(fast::SUBSCRIBER_QOS_DEFAULT)
        ->create_datareader(topic_, fast_reader_qos(qos));
  }

 private:
  fast::DomainParticipant* participant_;
  fast::Topic* topic_ = nullptr;
};

class NativeFast final : public NativePeer {
 public:
  explicit NativeFast(const BusOptions& options)
      : writing_(options),
        reading_(options),
        writer_(writing_.create_writer(keep_all(100, Durability::kTransientLocal))),
        reader_(reading_.create_reader(keep_all(100, Durability::kTransientLocal))) {}

  bool write(const ProbeFacts& facts) override {
    Probe probe;
    probe.probe_id(facts.id);
    probe.sequence_number(facts.sequence_number);
    probe.note(facts.note);
    probe.values(facts.values);
    probe.tail(facts.tail);
    return writer_->write(&probe);
  }

  std::vector<ProbeFacts> take() override {
    std::vector<ProbeFacts> out;
    Probe probe;
    fast::SampleInfo info;
    while (reader_->take_next_sample(&probe, &info) == ReturnCode_t::RETCODE_OK) {
      if (!info.valid_data) continue;
      ProbeFacts facts{.id = probe.probe_id(),
                       .sequence_number = probe.sequence_number(),
                       .note = probe.note(),
                       .values = probe.values(),
                       .tail = probe.tail(),
                       .key_hash = Key{}};
      for (std::size_t i = 0; i < facts.key_hash->size(); ++i)
        (*facts.key_hash)[i] = info.instance_handle.value[i];
      out.push_back(std::move(facts));
    }
    return out;
  }

 private:
  NativeParticipant writing_;
  NativeParticipant reading_;
  fast::DataWriter* writer_;
  fast::DataReader* reader_;
};

class RawFast final : public RawWriter {
 public:
  RawFast(std::shared_ptr<FastParticipant> participant, const TopicSpec& topic)
      : participant_(std::move(participant)),
        writer_(participant_->publisher().create_datawriter(*participant_->topic(topic),
                                                            fast_writer_qos(topic.qos))) {}
  ~RawFast() override { participant_->publisher().delete_datawriter(writer_); }

  bool write(Payload bytes) override { return writer_->write(&bytes); }
  [[nodiscard]] int matched_readers() const override {
    fast::PublicationMatchedStatus status;
    writer_->get_publication_matched_status(status);
    return status.current_count;
  }

 private:
  std::shared_ptr<FastParticipant> participant_;
  fast::DataWriter* writer_;
};

}  // namespace

std::unique_ptr<NativePeer> open_native_fast(const BusOptions& options) {
  return std::make_unique<NativeFast>(options);
}

std::unique_ptr<RawWriter> open_raw_fast(const BusOptions& options, const TopicSpec& topic) {
  auto participant = FastParticipant::create(options);
  return participant ? std::make_unique<RawFast>(*participant, topic) : nullptr;
}

}  // namespace tonus::bus::test
