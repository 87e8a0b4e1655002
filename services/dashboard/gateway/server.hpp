#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <thread>

#include "services/core/clock.hpp"
#include "services/core/result.hpp"
#include "services/dashboard/gateway/access.hpp"
#include "services/dashboard/gateway/connection_table.hpp"
#include "services/dashboard/gateway/http_api.hpp"
#include "services/dashboard/gateway/hub.hpp"
#include "services/dashboard/gateway/inbox.hpp"
#include "services/dashboard/gateway/pages.hpp"

namespace tonus::dashboard {

struct ListenAddress {
  std::string address = "127.0.0.1";
  std::uint16_t port = 8765;  ///< 0: any that is free.
};

/// "127.0.0.1:8765", "[::1]:8765", "8765".
[[nodiscard]] Result<ListenAddress> parse_listen(const std::string& text);

struct ServerOptions {
  ListenAddress listen;
  std::string certificate;  ///< PEM files; both or none.
  std::string key;
  ConnectionTable::Limits connections;
  /// From the connection's begin, TLS included, or from the last answer, to a whole request.
  std::chrono::milliseconds request_limit{5000};
  std::size_t maximum_frame_bytes = 256 * 1024;  ///< From a client.
  ApiFolders folders;
  std::string info_json;  ///< For /api/gateway, which needs no token.
};

struct ServerCore;

/// Serves HTTP and WebSockets in a thread of its own, in which also the hub lives; archive and reports are
/// read in another one. Nothing that a client does or leaves undone makes anybody else wait.
class Server {
 public:
  /// Called in the server's thread: who is interested in which live topics may have changed.
  using WantsChanged = std::function<void(const Hub&)>;

  /// Binds at once: kUnavailable says in one line what is in the way of address and port. `pages` may be
  /// empty. `access`, `hub` and `pages` are used by the server's thread only from start() on.
  [[nodiscard]] static Result<std::unique_ptr<Server>> create(ServerOptions options, Access access,
                                                              std::optional<Pages> pages, Hub& hub,
                                                              const Clock& clock);
  ~Server();

  /// Takes from the inbox whatever comes, as soon as wake() is called.
  void start(Inbox& inbox, WantsChanged wants_changed);

  /// Tells clients that the gateway ends (WebSocket close code 1001), waits for their answers for a second at
  /// most, and ends the thread; afterwards nothing that start() was given is used any more.
  void stop();

  /// From any thread: the inbox has something. Without effect after stop().
  void wake();

  /// "http://127.0.0.1:8765/"
  [[nodiscard]] std::string url() const;

 private:
  explicit Server(std::unique_ptr<ServerCore> core);
  std::unique_ptr<ServerCore> core_;
  std::thread thread_;
};

}  // namespace tonus::dashboard
