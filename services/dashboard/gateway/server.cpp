#include "services/dashboard/gateway/server.hpp"

#include <boost/asio/post.hpp>
#include <charconv>
#include <spdlog/spdlog.h>
#include <sys/resource.h>

#include "services/dashboard/gateway/server_core.hpp"

namespace tonus::dashboard {
namespace {

namespace asio = boost::asio;
using tcp = asio::ip::tcp;
using boost::system::error_code;

constexpr std::chrono::seconds kStatusPeriod{1};
constexpr std::chrono::milliseconds kAcceptAgain{100};
constexpr std::chrono::seconds kGoodbyeLimit{1};
constexpr int kNiceness = 5;
constexpr int kSendBufferBytes = 256 * 1024;  // what is in it is old when it arrives

Error cannot(const ListenAddress& listen, const std::string& why) {
  return fail(ErrorCode::kUnavailable, fmt::format("--listen {}:{}: {}", listen.address, listen.port, why));
}

Result<void> bind(ServerCore& core) {
  const ListenAddress& listen = core.options.listen;
  error_code error;
  const auto address = asio::ip::make_address(listen.address, error);
  if (error) return cannot(listen, "not an address; expected an IPv4 or IPv6 address of this machine");
  const tcp::endpoint endpoint(address, listen.port);
  core.acceptor.open(endpoint.protocol(), error);
  if (!error) core.acceptor.set_option(asio::socket_base::reuse_address(true), error);
  if (!error) core.acceptor.bind(endpoint, error);
  if (!error) core.acceptor.listen(asio::socket_base::max_listen_connections, error);
  if (error == asio::error::address_in_use)
    return cannot(listen, "the port is in use; name another one, or 0 for any that is free");
  if (error) return cannot(listen, error.message());
  return {};
}

Result<void> use_certificate(ServerCore& core) {
  if (core.options.certificate.empty()) return {};
  auto& tls = core.tls.emplace(asio::ssl::context::tls_server);
  error_code error;
  tls.set_options(
      asio::ssl::context::default_workarounds | asio::ssl::context::no_tlsv1 | asio::ssl::context::no_tlsv1_1,
      error);
  tls.use_certificate_chain_file(core.options.certificate, error);
  if (error)
    return fail(ErrorCode::kInvalidArgument,
                fmt::format("--tls-certificate {}: {}", core.options.certificate, error.message()));
  tls.use_private_key_file(core.options.key, asio::ssl::context::pem, error);
  if (error)
    return fail(ErrorCode::kInvalidArgument,
                fmt::format("--tls-key {}: {}", core.options.key, error.message()));
  return {};
}

void accept_next(ServerCore& core) {
  core.acceptor.async_accept([&core](error_code error, tcp::socket socket) {
    if (error == asio::error::operation_aborted) return;  // the gateway ends
    if (error) {                                          // no file descriptor left, say: it may pass
      core.accept_again.expires_after(kAcceptAgain);
      core.accept_again.async_wait([&core](error_code ended) {
        if (!ended) accept_next(core);
      });
      return;
    }
    error_code ignored;
    socket.set_option(tcp::no_delay(true), ignored);
    socket.set_option(asio::socket_base::send_buffer_size(kSendBufferBytes), ignored);
    serve(core, std::move(socket));
    accept_next(core);
  });
}

void publish_status(ServerCore& core) {
  core.hub.publish_status(core.inbox->live_dropped());
  core.status_timer.expires_after(kStatusPeriod);
  core.status_timer.async_wait([&core](error_code ended) {
    if (!ended) publish_status(core);
  });
}

/// The last client's farewell ends the loop, or the limit does: who does not read holds nobody up.
void say_goodbye(ServerCore& core) {
  error_code ignored;
  core.acceptor.close(ignored);
  core.accept_again.cancel();
  if (core.hub.clients() == 0) return core.io.stop();
  core.wants_changed = [&core](const Hub& hub) {
    if (hub.clients() == 0) core.io.stop();
  };
  core.goodbye_timer.expires_after(kGoodbyeLimit);
  core.goodbye_timer.async_wait([&core](error_code ended) {
    if (!ended) core.io.stop();
  });
  core.hub.dismiss_all();
}

void take_inbox(ServerCore& core) {
  const auto contents = core.inbox->take();
  for (const auto& message : contents.messages) core.hub.on_bus_message(message);
  for (const auto& reply : contents.replies) core.hub.on_reply(reply);
}

}  // namespace

Result<ListenAddress> parse_listen(const std::string& text) {
  ListenAddress listen;
  const auto colon = text.rfind(':');
  std::string port = text;
  if (colon != std::string::npos) {
    listen.address = text.substr(0, colon);
    port = text.substr(colon + 1);
    if (listen.address.starts_with('[') && listen.address.ends_with(']'))
      listen.address = listen.address.substr(1, listen.address.size() - 2);
  }
  const auto [end, error] = std::from_chars(port.data(), port.data() + port.size(), listen.port);
  if (error != std::errc() || end != port.data() + port.size() || port.empty()) {
    return fail(
        ErrorCode::kInvalidArgument,
        fmt::format("--listen: {} is not allowed; expected ADDRESS:PORT or PORT, PORT from 0 to 65535",
                    text));
  }
  return listen;
}

Result<std::unique_ptr<Server>> Server::create(ServerOptions options, Access access,
                                               std::optional<Pages> pages, Hub& hub, const Clock& clock) {
  auto core =
      std::make_unique<ServerCore>(std::move(options), std::move(access), std::move(pages), hub, clock);
  if (auto certified = use_certificate(*core); !certified) return certified.error();
  if (auto bound = bind(*core); !bound) return bound.error();
  return std::unique_ptr<Server>(new Server(std::move(core)));
}

Server::Server(std::unique_ptr<ServerCore> core) : core_(std::move(core)) {}

Server::~Server() { stop(); }

void Server::stop() {
  asio::post(core_->io, [core = core_.get()] { say_goodbye(*core); });
  if (!thread_.joinable()) core_->io.stop();
  if (thread_.joinable()) thread_.join();
  core_->reading_thread.join();
  core_->wants_changed = [](const Hub&) {};  // connections that are left say goodbye later
}

void Server::start(Inbox& inbox, WantsChanged wants_changed) {
  core_->inbox = &inbox;
  core_->wants_changed = std::move(wants_changed);
  accept_next(*core_);
  publish_status(*core_);
  wake();
  thread_ = std::thread([this] {
    // On Linux it is this thread's own: sending to many clients yields to identification and the rig, where
    // they share processors. A refusal changes nothing else.
    (void)setpriority(PRIO_PROCESS, 0, kNiceness);
    core_->io.run();
  });
}

void Server::wake() {
  asio::post(core_->io, [this] { take_inbox(*core_); });
}

std::string Server::url() const {
  error_code ignored;
  const auto local = core_->acceptor.local_endpoint(ignored);
  const auto address = local.address().to_string();
  return fmt::format("{}://{}:{}/", core_->tls ? "https" : "http",
                     local.address().is_v6() ? "[" + address + "]" : address, local.port());
}

}  // namespace tonus::dashboard
