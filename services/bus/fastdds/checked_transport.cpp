#include "services/bus/fastdds/checked_transport.hpp"

#include <algorithm>
#include <fastdds/rtps/transport/ChainingTransport.h>
#include <fastdds/rtps/transport/ChainingTransportDescriptor.h>
#include <utility>

#include "services/bus/fastdds/forgotten_writers.hpp"
#include "services/bus/refused_packets.hpp"

namespace tonus::bus {
namespace {

namespace transport = eprosima::fastdds::rtps;
namespace rtps = eprosima::fastrtps::rtps;

std::atomic<std::uint64_t> refused_count{0};

class CheckedTransport final : public transport::ChainingTransport {
 public:
  CheckedTransport(const transport::ChainingTransportDescriptor& descriptor,
                   std::shared_ptr<ReceivedPackets> received)
      : ChainingTransport(descriptor), received_(std::move(received)) {}

  transport::TransportDescriptorInterface* get_configuration() override {
    return low_level_transport_->get_configuration();
  }

  bool send(rtps::SenderResource* sender, const rtps::octet* buffer, std::uint32_t size,
            rtps::LocatorsIterator* begin, rtps::LocatorsIterator* end,
            const std::chrono::steady_clock::time_point& timeout) override {
    return sender->send(buffer, size, begin, end, timeout);
  }

  void receive(transport::TransportReceiverInterface* next, const rtps::octet* buffer, std::uint32_t size,
               const rtps::Locator_t& local, const rtps::Locator_t& remote) override {
    const std::span datagram(reinterpret_cast<const std::byte*>(buffer), size);
    RtpsChecked checked = check_rtps(datagram, {received_->message_bytes});
    if (checked.fault != RtpsFault::kNone) {
      ++refused_count;
      return;
    }
    for (const Acknowledgement& word : checked.acknowledgements)
      forgotten_.see(word, datagram, checked.patches);
    if (checked.patches.empty()) return hand_on(next, checked.message, local, remote);
    std::vector<std::byte> patched(checked.message.begin(), checked.message.end());
    for (const BytePatch& patch : checked.patches) {
      std::copy_n(patch.bytes.begin(), patch.count, patched.begin() + static_cast<std::ptrdiff_t>(patch.at));
    }
    hand_on(next, patched, local, remote);
  }

 private:
  static void hand_on(transport::TransportReceiverInterface* next, std::span<const std::byte> message,
                      const rtps::Locator_t& local, const rtps::Locator_t& remote) {
    next->OnDataReceived(reinterpret_cast<const rtps::octet*>(message.data()),
                         static_cast<std::uint32_t>(message.size()), local, remote);
  }

  std::shared_ptr<ReceivedPackets> received_;
  ForgottenWriters forgotten_;
};

class CheckedTransportDescriptor final : public transport::ChainingTransportDescriptor {
 public:
  CheckedTransportDescriptor(std::shared_ptr<transport::TransportDescriptorInterface> low_level,
                             std::shared_ptr<ReceivedPackets> received)
      : ChainingTransportDescriptor(std::move(low_level)), received_(std::move(received)) {}

  [[nodiscard]] transport::TransportInterface* create_transport() const override {
    return new CheckedTransport(*this, received_);  // the caller owns it
  }

 private:
  std::shared_ptr<ReceivedPackets> received_;
};

}  // namespace

std::uint64_t refused_packets() { return refused_count; }

void ReceivedPackets::allow_message_bytes(std::size_t bytes) {
  std::size_t allowed = message_bytes;
  while (allowed < bytes && !message_bytes.compare_exchange_weak(allowed, bytes)) {
  }
}

void check_packets(eprosima::fastdds::dds::DomainParticipantQos& qos,
                   const std::shared_ptr<ReceivedPackets>& received) {
  for (auto& one : qos.transport().user_transports)
    one = std::make_shared<CheckedTransportDescriptor>(std::move(one), received);
}

}  // namespace tonus::bus
