// HTTP on a connection: pages, the JSON interface, and the way up to a WebSocket.

#include <algorithm>
#include <boost/beast/ssl.hpp>
#include <charconv>
#include <cstring>
#include <functional>
#include <nlohmann/json.hpp>
#include <spdlog/spdlog.h>

#include "services/core/text.hpp"
#include "services/dashboard/gateway/json_messages.hpp"
#include "services/dashboard/gateway/metrics.hpp"
#include "services/dashboard/gateway/open_api.hpp"
#include "services/dashboard/gateway/protocol_check.hpp"
#include "services/dashboard/gateway/server_core.hpp"
#include "services/dashboard/gateway/websocket_client.hpp"

namespace tonus::dashboard {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
using beast::error_code;
using Request = http::request<http::string_body>;
using Response = http::response<http::string_body>;

constexpr std::chrono::seconds kPatience{20};  // for one answer
constexpr std::chrono::minutes kDownloadPatience{30};
constexpr std::size_t kRequestBytes = 64 * 1024;  // on the wire, TLS and the framing of a body included
constexpr char kOnlyTls[] = "max-age=31536000";   // RFC 6797
constexpr std::uint32_t kHeaderLimit = 16 * 1024;
constexpr std::uint64_t kBodyLimit = 48 * 1024;  // a protocol's text
constexpr std::size_t kMaximumReadingJobs = 32;
constexpr char kMetricsType[] = "text/plain; version=0.0.4; charset=utf-8";

std::string text_of(beast::string_view view) { return {view.data(), view.size()}; }

bool is_plain_host(const std::string& host) {
  return !host.empty() && host.size() < 256 && std::all_of(host.begin(), host.end(), [](unsigned char c) {
    return std::isalnum(c) != 0 || c == '.' || c == ':' || c == '-' || c == '[' || c == ']';
  });
}

/// Pages may use what comes from this gateway, and nothing else.
std::string content_policy(const std::string& host) {
  const std::string sockets = is_plain_host(host) ? fmt::format(" ws://{0} wss://{0}", host) : "";
  return fmt::format(
      "default-src 'self'; img-src 'self' data:; connect-src 'self'{}; object-src 'none'; base-uri 'none'; "
      "form-action 'none'; frame-ancestors 'none'",
      sockets);
}

/// Reports may show their own pictures; they run nothing.
constexpr char kReportPolicy[] =
    "default-src 'none'; img-src 'self' data:; style-src 'self' 'unsafe-inline'; "
    "sandbox allow-same-origin allow-downloads";
constexpr char kReportCookie[] = "tonus-report";
constexpr char kReportPath[] = "/reports/";
constexpr char kJsonPath[] = "/json";
constexpr char kCheckPath[] = "/api/protocols/check";
constexpr char kExportPath[] = "/exports/";
constexpr char kSessionsPath[] = "/api/sessions/";
constexpr char kOrderOfExport[] = "/exports";

constexpr char kNoPages[] =
    "<!doctype html><meta charset=utf-8><title>tonus</title><p>This gateway has no pages: it was built "
    "without "
    "npm. Its WebSocket (foxglove.websocket.v1) works.";

template <typename Stream>
class Connection final : public std::enable_shared_from_this<Connection<Stream>> {
 public:
  Connection(ServerCore& core, Stream&& stream, std::string peer)
      : core_(core), stream_(std::move(stream)), peer_(std::move(peer)) {}

  void start(Seat seat) {
    seat_ = std::move(seat);
    beast::get_lowest_layer(stream_).expires_after(core_.options.request_limit);
    if constexpr (is_tls()) {
      stream_.async_handshake(asio::ssl::stream_base::server,
                              [self = this->shared_from_this()](error_code error) {
                                if (!error) self->read();
                              });
    } else {
      read();
    }
  }

  /// Makes room for another connection.
  void give_way() {
    core_.hub.refuse(Refused::kConnection, peer_, "had shown no token, and gave way to another connection");
    beast::get_lowest_layer(stream_).close();
  }

 private:
  static constexpr bool is_tls() { return std::is_same_v<Stream, TlsStream>; }

  void read() {
    beast::get_lowest_layer(stream_).rate_policy().renew(kRequestBytes);
    parser_.emplace();
    parser_->header_limit(kHeaderLimit);
    parser_->body_limit(kBodyLimit);
    http::async_read(
        stream_, buffer_, *parser_,
        [self = this->shared_from_this()](error_code error, std::size_t /*bytes*/) { self->on_read(error); });
  }

  void on_read(error_code error) {
    if (error == http::error::header_limit || error == http::error::body_limit) {
      core_.hub.refuse(Refused::kOversized, peer_, "an HTTP request over the limit");
      return respond(http::status::payload_too_large, "application/json", error_text("too large"), true);
    }
    if (error && error.category() == http::make_error_code(http::error::bad_method).category() &&
        error != http::error::end_of_stream && error != http::error::partial_message) {
      core_.hub.refuse(Refused::kMalformed, peer_, "not HTTP: " + error.message());
      return respond(http::status::bad_request, "application/json", error_text("not HTTP"), true);
    }
    if (error) return;
    request_ = parser_->release();
    route();
  }

  [[nodiscard]] Visit visit() const {
    Visit visit{text_of(request_[http::field::host]), text_of(request_[http::field::origin]),
                text_of(request_[http::field::authorization]), query_value(target(), "token"), is_tls()};
    // A report's pictures are asked for without the address's token.
    if (visit.query_token.empty() && path().starts_with(kReportPath))
      visit.query_token = cookie_value(text_of(request_[http::field::cookie]), kReportCookie);
    return visit;
  }

  [[nodiscard]] std::string target() const { return text_of(request_.target()); }
  [[nodiscard]] std::string path() const {
    const auto whole = target();
    return whole.substr(0, whole.find('?'));
  }

  void route() {
    const auto where = path();
    const bool is_post = request_.method() == http::verb::post;
    if (!(is_post && takes_post(where)) && request_.method() != http::verb::get &&
        request_.method() != http::verb::head)
      return respond(http::status::method_not_allowed, "application/json", error_text("GET is needed"));
    const bool is_upgrade = beast::websocket::is_upgrade(request_);
    const bool is_guarded = is_upgrade || where == "/metrics" || where.starts_with(kReportPath) ||
                            where.starts_with(kExportPath) ||
                            (where.starts_with("/api/") && where != "/api/gateway");
    if (!is_guarded) return where == "/api/gateway" ? give_info() : give_page(where);
    const auto admitted = core_.access.admit(visit());
    if (const auto* refusal = std::get_if<Refusal>(&admitted)) {
      core_.hub.refuse(Refused::kConnection, peer_, refusal->reason);
      return respond(static_cast<http::status>(refusal->http_status), "application/json",
                     error_text(refusal->reason));
    }
    const Role role = std::get<Role>(admitted);
    if (!seat_.set_standing(role == Role::kOperate ? Standing::kOperator : Standing::kViewer)) {
      const std::string why = "as many viewers are connected as are allowed";
      core_.hub.refuse(Refused::kConnection, peer_, why);
      return respond(http::status::service_unavailable, "application/json", error_text(why), true);
    }
    if (is_upgrade) return upgrade(role);
    if (where == "/api/role")
      return respond(http::status::ok, "application/json", nlohmann::json{{"role", role_name(role)}}.dump());
    if (where == "/api/status")
      return respond(http::status::ok, "application/json",
                     core_.hub.status_json(core_.inbox->live_dropped()));
    if (where == "/metrics") return give_metrics();
    if (is_post) return take_post(where, role);
    if (where == "/api/jobs") return give_jobs();
    if (where.starts_with(kExportPath)) return give_export(where.substr(std::strlen(kExportPath)));
    if (where == "/api/protocols/keys")
      return respond(http::status::ok, "application/json", protocol_keys_json());
    if (where == "/api/openapi.json")
      return respond(http::status::ok, "application/json", std::string(kOpenApi));
    if (const auto topics = topics_of_path(where); !topics.empty())
      return respond(http::status::ok, "application/json", core_.hub.latest_json(topics));
    read_elsewhere([this, where, topic = query_value(target(), "topic")] {
      is_report_ = where.starts_with(kReportPath);
      return answer_api(core_.options.folders, where, topic);
    });
  }

  void give_metrics() {
    std::string text = bus_metrics(core_.hub, core_.inbox->live_dropped(), core_.table.size());
    read_elsewhere([this, text = std::move(text)] {
      return ApiAnswer{200, kMetricsType,
                       text + file_metrics(core_.options.folders.store, core_.options.certificate)};
    });
  }

  [[nodiscard]] static bool is_order_of_export(const std::string& where) {
    return where.starts_with(kSessionsPath) && where.ends_with(kOrderOfExport);
  }
  [[nodiscard]] static bool takes_post(const std::string& where) {
    return where == kCheckPath || where == "/api/reports" || is_order_of_export(where);
  }

  void take_post(const std::string& where, Role role) {
    if (where == kCheckPath) return give_check();
    if (role != Role::kOperate) {
      const auto why = fmt::format("the role {} may not ask for exports and reports", role_name(role));
      core_.hub.refuse(Refused::kForbidden, peer_, why);
      return respond(http::status::forbidden, "application/json", error_text(why));
    }
    if (!core_.jobs)
      return respond(http::status::service_unavailable, "application/json",
                     error_text("no jobs are run here"));
    const std::string session = where.substr(std::min(where.size(), std::strlen(kSessionsPath)));
    const auto number =
        is_order_of_export(where)
            ? core_.jobs->order_export(session.substr(0, session.size() - std::strlen(kOrderOfExport)),
                                       query_value(target(), "format"))
            : core_.jobs->order_report(query_value(target(), "name"), request_.body());
    if (number) return respond(http::status::ok, "application/json", nlohmann::json{{"job", *number}}.dump());
    respond(number.error().code == ErrorCode::kUnavailable ? http::status::service_unavailable
                                                           : http::status::bad_request,
            "application/json", error_text(number.error().message));
  }

  void give_jobs() {
    respond(http::status::ok, "application/json", core_.jobs ? core_.jobs->list_json() : "[]");
  }

  /// A file of any size, which is read as it is sent.
  void give_export(const std::string& name) {
    const auto file = core_.options.folders.exports / name;
    error_code error;
    auto response = std::make_shared<http::response<http::file_body>>();
    const bool is_name = name.find('/') == std::string::npos && !name.starts_with('.');
    if (is_name) response->body().open(file.c_str(), beast::file_mode::scan, error);
    if (!is_name || error)
      return respond(http::status::not_found, "application/json", error_text("there is no such export"));
    response->version(11);
    response->set(http::field::server, "tonus-dashboard");
    response->set(http::field::content_type, "application/octet-stream");
    response->set(http::field::content_disposition, fmt::format("attachment; filename=\"{}\"", name));
    response->set(http::field::cache_control, "no-store");
    response->set("X-Content-Type-Options", "nosniff");
    response->keep_alive(false);
    response->prepare_payload();
    beast::get_lowest_layer(stream_).expires_after(kDownloadPatience);
    http::async_write(
        stream_, *response,
        [self = this->shared_from_this(), response](error_code, std::size_t) { self->close(); });
  }

  /// The body is a protocol's text.
  void give_check() {
    const std::string seed = query_value(target(), "seed");
    std::uint64_t number = 1;
    const auto [end, error] = std::from_chars(seed.data(), seed.data() + seed.size(), number);
    if (!seed.empty() && (error != std::errc() || end != seed.data() + seed.size())) {
      return respond(http::status::bad_request, "application/json",
                     error_text(fmt::format("seed: '{:.40}' is not allowed; expected a whole number from 0",
                                            shown(seed))));
    }
    read_elsewhere([text = request_.body(), number, rig = core_.hub.rig_description()] {
      return ApiAnswer{200, "application/json", check_protocol(text, number, rig)};
    });
  }

  void give_info() { respond(http::status::ok, "application/json", core_.options.info_json); }

  void give_page(const std::string& where) {
    if (!core_.pages) return respond(http::status::ok, "text/html; charset=utf-8", kNoPages);
    const Page* page = core_.pages->find(where);
    if (page == nullptr && core_.pages->find(where + "/") != nullptr) {
      location_ = where + "/";
      return respond(http::status::moved_permanently, "text/plain; charset=utf-8", where + "/\n");
    }
    if (page == nullptr)
      return respond(http::status::not_found, "text/plain; charset=utf-8", "there is no such page\n");
    is_kept_ = page->is_named_by_content;
    const auto [body, coding] = representation(*page, text_of(request_[http::field::accept_encoding]));
    is_negotiated_ = true;
    coding_ = coding;
    respond(http::status::ok, page->type, body);
  }

  void upgrade(Role role) {
    if (path() == kJsonPath) return upgrade_to_json(role);
    const auto offered = request_[http::field::sec_websocket_protocol];
    if (!http::token_list{offered}.exists(kSubprotocol)) {
      const auto why = fmt::format("the subprotocol {} is needed, or the path {}", kSubprotocol, kJsonPath);
      core_.hub.refuse(Refused::kConnection, peer_, why);
      return respond(http::status::bad_request, "application/json", error_text(why));
    }
    make_client(role)->accept(request_);
  }

  void upgrade_to_json(Role role) {
    auto topics = json_topics_of(query_value(target(), "topics"));
    if (!topics) {
      core_.hub.refuse(Refused::kConnection, peer_, topics.error().message);
      return respond(http::status::bad_request, "application/json", error_text(topics.error().message));
    }
    make_client(role)->accept_json(request_, std::move(*topics));
  }

  [[nodiscard]] auto make_client(Role role) {
    return std::make_shared<WebSocketClient<Stream>>(core_, std::move(stream_), role, peer_,
                                                     std::move(seat_));
  }

  /// Archive, reports, metrics: from a disk, which may take its time, in the reading thread. `read` has this
  /// connection to itself.
  void read_elsewhere(std::function<ApiAnswer()> read) {
    if (core_.reading_jobs >= kMaximumReadingJobs)
      return respond(http::status::service_unavailable, "application/json", error_text("too many requests"));
    ++core_.reading_jobs;
    asio::post(core_.reading_thread, [self = this->shared_from_this(), read = std::move(read)] {
      auto answer = std::make_shared<ApiAnswer>(read());
      asio::post(self->core_.io, [self, answer] {
        --self->core_.reading_jobs;
        self->respond(static_cast<http::status>(answer->status), answer->type, std::move(answer->body));
      });
    });
  }

  void respond(http::status status, const std::string& type, std::string body, bool is_last = false) {
    response_ = Response(status, request_.version() == 0 ? 11 : request_.version());
    response_.set(http::field::server, "tonus-dashboard");
    response_.set(http::field::content_type, type);
    response_.set(http::field::cache_control, is_kept_ ? "max-age=31536000, immutable" : "no-store");
    response_.set("X-Content-Type-Options", "nosniff");
    response_.set("Referrer-Policy", "no-referrer");
    response_.set("Content-Security-Policy",
                  is_report_ ? kReportPolicy : content_policy(text_of(request_[http::field::host])));
    if constexpr (is_tls()) response_.set("Strict-Transport-Security", kOnlyTls);
    if (const auto token = query_value(target(), "token"); is_report_ && core_.access.knows(token)) {
      response_.set(http::field::set_cookie,
                    fmt::format("{}={}; Path={}; HttpOnly; SameSite=Strict{}", kReportCookie, token,
                                kReportPath, is_tls() ? "; Secure" : ""));
    }
    if (!location_.empty()) response_.set(http::field::location, location_);
    location_.clear();
    if (status == http::status::unauthorized) response_.set(http::field::www_authenticate, "Bearer");
    if (is_negotiated_) response_.set(http::field::vary, "Accept-Encoding");
    if (!coding_.empty()) response_.set(http::field::content_encoding, coding_);
    is_kept_ = false;
    is_negotiated_ = false;
    coding_.clear();
    is_report_ = false;
    response_.keep_alive(!is_last && request_.keep_alive());
    response_.body() = std::move(body);
    response_.prepare_payload();
    if (request_.method() == http::verb::head) response_.body().clear();
    beast::get_lowest_layer(stream_).expires_after(kPatience);
    http::async_write(stream_, response_, [self = this->shared_from_this()](error_code error, std::size_t) {
      if (error || !self->response_.keep_alive()) return self->close();
      if (!self->seat_.set_standing(Standing::kUnproven)) return self->close();
      beast::get_lowest_layer(self->stream_).expires_after(self->core_.options.request_limit);
      self->read();
    });
  }

  void close() {
    error_code ignored;
    beast::get_lowest_layer(stream_).socket().shutdown(asio::ip::tcp::socket::shutdown_send, ignored);
  }

  ServerCore& core_;
  Stream stream_;
  std::string peer_;
  Seat seat_;
  beast::flat_buffer buffer_;
  std::optional<http::request_parser<http::string_body>> parser_;
  Request request_;
  Response response_;
  bool is_kept_ = false;
  std::string location_;        ///< Of the next response; empty: none.
  bool is_negotiated_ = false;  ///< Another client may get the same page in another form.
  std::string coding_;          ///< Of the answer; empty: as it is.
  bool is_report_ = false;
};

template <typename Stream>
void seat(ServerCore& core, Stream&& stream, const std::string& address, const std::string& peer) {
  const auto connection = std::make_shared<Connection<Stream>>(core, std::forward<Stream>(stream), peer);
  const std::weak_ptr<Connection<Stream>> weak = connection;
  const auto arrival = core.table.arrive(counted_address(address), [weak] {
    if (const auto found = weak.lock()) found->give_way();
  });
  if (arrival.gives_way) arrival.gives_way();
  if (!arrival.number) {
    core.hub.refuse(Refused::kConnection, peer,
                    fmt::format("{} connections are open, no more are allowed", core.table.size()));
    return;
  }
  connection->start(Seat(core, *arrival.number));
}

}  // namespace

void serve(ServerCore& core, asio::ip::tcp::socket socket) {
  error_code ignored;
  const auto remote = socket.remote_endpoint(ignored);
  const auto address = remote.address().to_string();
  const auto peer = fmt::format("{}:{}", address, remote.port());
  PlainStream stream(std::move(socket));
  if (core.tls) {
    seat(core, TlsStream(std::move(stream), *core.tls), address, peer);
  } else {
    seat(core, std::move(stream), address, peer);
  }
}

}  // namespace tonus::dashboard
