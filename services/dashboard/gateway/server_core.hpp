#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ssl/context.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/thread_pool.hpp>
#include <optional>

#include "services/dashboard/gateway/server.hpp"

namespace tonus::dashboard {

/// What the connections of a Server share. All of it belongs to the server's thread. Connections die with
/// `io`, at the latest, and before what stands above it.
struct ServerCore {
  ServerCore(ServerOptions given_options, Access given_access, std::optional<Pages> given_pages,
             Hub& given_hub, const Clock& given_clock)
      : options(std::move(given_options)),
        access(std::move(given_access)),
        pages(std::move(given_pages)),
        hub(given_hub),
        clock(given_clock) {}

  ServerOptions options;
  Access access;
  std::optional<Pages> pages;
  Hub& hub;
  const Clock& clock;
  Inbox* inbox = nullptr;
  Server::WantsChanged wants_changed;
  std::size_t connections = 0;
  std::size_t reading_jobs = 0;  ///< Waiting for the reading thread, or under way there.
  std::optional<boost::asio::ssl::context> tls;

  boost::asio::io_context io{1};
  boost::asio::ip::tcp::acceptor acceptor{io};
  boost::asio::steady_timer status_timer{io};
  boost::asio::steady_timer accept_again{io};
  boost::asio::thread_pool reading_thread{1};  ///< For archive and reports.
};

/// Serves a connection that has been accepted, until it ends; it owns itself.
void serve(ServerCore& core, boost::asio::ip::tcp::socket socket);

}  // namespace tonus::dashboard
