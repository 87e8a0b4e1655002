#include "services/bus/discovery_server.hpp"
#include "services/bus/fastdds/fast_participant.hpp"
#include "services/bus/fastdds/fast_qos.hpp"
#include "services/bus/options_check.hpp"

namespace tonus::bus {
namespace {

class FastDiscoveryServer final : public DiscoveryServer {
 public:
  explicit FastDiscoveryServer(std::shared_ptr<FastParticipant> participant)
      : participant_(std::move(participant)) {}

 private:
  std::shared_ptr<FastParticipant> participant_;
};

}  // namespace

Result<std::unique_ptr<DiscoveryServer>> DiscoveryServer::start(const BusOptions& options,
                                                                std::uint16_t port) {
  TONUS_TRY(check_options(options));
  if (options.vendor != Vendor::kFastDds) {
    return fail(ErrorCode::kInvalidArgument,
                "discovery server on " + std::string(vendor_name(options.vendor)) + ": only fastdds has one");
  }
  TONUS_TRY(own_address(options.network.interface_address));
  auto participant = FastParticipant::create(options, fast_server_qos(options, port));
  if (!participant) {
    return fail(ErrorCode::kUnavailable, "discovery server at " + options.network.interface_address + ":" +
                                             std::to_string(port) + ": cannot listen; is the port free?");
  }
  return std::unique_ptr<DiscoveryServer>(new FastDiscoveryServer(std::move(*participant)));
}

}  // namespace tonus::bus
