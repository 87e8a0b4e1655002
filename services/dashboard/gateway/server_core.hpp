#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ssl/context.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/thread_pool.hpp>
#include <boost/beast/core/basic_stream.hpp>
#include <boost/beast/ssl/ssl_stream.hpp>
#include <optional>
#include <utility>

#include "services/dashboard/gateway/connection_table.hpp"
#include "services/dashboard/gateway/jobs.hpp"
#include "services/dashboard/gateway/read_budget.hpp"
#include "services/dashboard/gateway/server.hpp"

namespace tonus::dashboard {

using PlainStream =
    boost::beast::basic_stream<boost::asio::ip::tcp, boost::asio::any_io_executor, ReadBudget>;
using TlsStream = boost::beast::ssl_stream<PlainStream>;

/// What the connections of a Server share. All of it belongs to the server's thread. Connections die with
/// `io`, at the latest, and before what stands above it.
struct ServerCore {
  ServerCore(ServerOptions given_options, Access given_access, std::optional<Pages> given_pages,
             Hub& given_hub, const Clock& given_clock)
      : options(std::move(given_options)),
        access(std::move(given_access)),
        pages(std::move(given_pages)),
        hub(given_hub),
        clock(given_clock),
        table(options.connections) {
    if (const ApiFolders& f = options.folders; !f.tonus.empty())
      jobs.emplace(JobFolders{f.tonus, f.store, f.exports, f.reports});
  }

  ServerOptions options;
  Access access;
  std::optional<Pages> pages;
  Hub& hub;
  const Clock& clock;
  Inbox* inbox = nullptr;
  Server::WantsChanged wants_changed;
  ConnectionTable table;
  std::size_t reading_jobs = 0;  ///< Waiting for the reading thread, or under way there.
  std::optional<boost::asio::ssl::context> tls;
  std::optional<Jobs> jobs;  ///< Threads of its own.

  boost::asio::io_context io{1};
  boost::asio::ip::tcp::acceptor acceptor{io};
  boost::asio::steady_timer status_timer{io};
  boost::asio::steady_timer accept_again{io};
  boost::asio::steady_timer goodbye_timer{io};
  boost::asio::thread_pool reading_thread{1};  ///< For archive and reports.
};

/// A connection's entry in the table, while this lives.
class Seat {
 public:
  Seat() = default;
  Seat(ServerCore& core, ConnectionTable::Number number) : core_(&core), number_(number) {}
  Seat(Seat&& other) noexcept : core_(std::exchange(other.core_, nullptr)), number_(other.number_) {}
  Seat& operator=(Seat&& other) noexcept {
    std::swap(core_, other.core_);
    std::swap(number_, other.number_);
    return *this;
  }
  ~Seat() {
    if (core_ != nullptr) core_->table.leave(number_);
  }

  /// As ConnectionTable::set_standing().
  [[nodiscard]] bool set_standing(Standing standing) {
    return core_ != nullptr && core_->table.set_standing(number_, standing);
  }

 private:
  ServerCore* core_ = nullptr;
  ConnectionTable::Number number_ = 0;
};

/// Serves a connection that has been accepted, until it ends; it owns itself.
void serve(ServerCore& core, boost::asio::ip::tcp::socket socket);

}  // namespace tonus::dashboard
