#pragma once

#include <gmock/gmock.h>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "services/dashboard/gateway/server.hpp"
#include "tests/support/gateway_client/gateway_client.hpp"

namespace tonus::dashboard::testing {

/// A gateway without a bus, on a free port of the loopback.
class Gateway {
 public:
  explicit Gateway(Access access = Access({}, {}), ServerOptions options = {}, Hub::Options hub_options = {},
                   std::optional<Pages> pages = std::nullopt);
  ~Gateway();

  [[nodiscard]] std::uint16_t port() const { return port_; }
  [[nodiscard]] Inbox& inbox() { return inbox_; }
  [[nodiscard]] const std::string& error() const { return error_; }
  [[nodiscard]] std::uint32_t channel(std::string_view topic) const;
  [[nodiscard]] std::vector<OperatorRequest> asked();

  /// Ends the gateway as its program does.
  void stop();

  /// Publishes a message of the bus.
  void put(std::string_view topic, std::uint8_t key, std::size_t bytes = 32);

 private:
  SystemClock clock_;
  std::mutex mutex_;
  std::vector<OperatorRequest> asked_;
  std::string error_;
  std::vector<OfferedTopic> topics_ = offered_topics();
  Hub hub_;
  std::unique_ptr<Server> server_;
  Inbox inbox_;
  std::uint16_t port_ = 0;
};

}  // namespace tonus::dashboard::testing
