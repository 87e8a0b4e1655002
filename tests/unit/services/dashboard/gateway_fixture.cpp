#include "tests/unit/services/dashboard/gateway_fixture.hpp"

#include <charconv>

namespace tonus::dashboard::testing {
namespace {

ServerOptions on_free_port(ServerOptions options) {
  options.listen.port = 0;
  options.info_json = "{}";
  return options;
}

}  // namespace

Gateway::Gateway(Access access, ServerOptions options, Hub::Options hub_options, std::optional<Pages> pages)
    : hub_(offered_topics(), std::move(hub_options), clock_,
           [this](OperatorRequest request) {
             const std::lock_guard lock(mutex_);
             asked_.push_back(std::move(request));
           }),
      inbox_([this] { server_->wake(); }) {
  auto server =
      Server::create(on_free_port(std::move(options)), std::move(access), std::move(pages), hub_, clock_);
  if (!server) {
    error_ = server.error().message;
    return;
  }
  server_ = std::move(*server);
  server_->start(inbox_, [](const Hub&) {});
  const std::string url = server_->url();
  const auto colon = url.rfind(':');
  std::from_chars(url.data() + colon + 1, url.data() + url.size(), port_);
}

Gateway::~Gateway() { stop(); }

void Gateway::stop() {
  if (server_) server_->stop();
}

std::uint32_t Gateway::channel(std::string_view topic) const {
  for (const auto& offered : topics_)
    if (offered.channel.topic == topic) return offered.channel.id;
  return 0;
}

std::vector<OperatorRequest> Gateway::asked() {
  const std::lock_guard lock(mutex_);
  return asked_;
}

void Gateway::put(std::string_view topic, std::uint8_t key, std::size_t bytes) {
  bus::Key k{};
  k[0] = key;
  inbox_.put({channel(topic), k, 1, std::make_shared<const bus::Payload>(bytes, static_cast<std::byte>(key))},
             topic == "rig/samples");
}

}  // namespace tonus::dashboard::testing
