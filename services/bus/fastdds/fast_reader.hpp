#pragma once

#include <deque>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/DataReaderListener.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>

#include "services/bus/fastdds/fast_participant.hpp"

namespace tonus::bus {

/// See Reader. Fast DDS hands out samples key by key; so take() empties its history at once and puts each
/// writer's samples back into the order of their writing.
class FastReader final : public Reader, private fast::DataReaderListener {
 public:
  [[nodiscard]] static Result<std::unique_ptr<Reader>> create(std::shared_ptr<FastParticipant> participant,
                                                              const TopicSpec& topic,
                                                              std::shared_ptr<Notifier> notifier);
  ~FastReader() override;

  std::size_t take(std::vector<Sample>& out, std::size_t max) override;
  [[nodiscard]] ReaderStatus status() const override;

 private:
  FastReader(std::shared_ptr<FastParticipant> participant, const TopicSpec& topic,
             std::shared_ptr<Notifier> notifier);
  void drain();

  void on_data_available(fast::DataReader* reader) override;
  void on_subscription_matched(fast::DataReader* reader,
                               const fast::SubscriptionMatchedStatus& info) override;
  void on_liveliness_changed(fast::DataReader* reader, const fast::LivelinessChangedStatus& info) override;
  void on_requested_deadline_missed(fast::DataReader* reader,
                                    const fast::RequestedDeadlineMissedStatus& info) override;
  void on_sample_lost(fast::DataReader* reader, const fast::SampleLostStatus& info) override;

  std::shared_ptr<FastParticipant> participant_;
  std::shared_ptr<Notifier> notifier_;
  bool has_liveliness_;
  std::size_t max_payload_bytes_;
  fast::DataReader* reader_ = nullptr;

  std::mutex take_mutex_;
  std::deque<Sample> drained_;

  mutable std::mutex status_mutex_;
  ReaderStatus status_;
};

}  // namespace tonus::bus
