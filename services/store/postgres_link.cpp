#include "services/store/postgres_link.hpp"

#include <algorithm>
#include <spdlog/fmt/fmt.h>

#include "services/core/clock.hpp"
#include "services/core/passwords.hpp"
#include "services/core/text.hpp"
#include "services/store/postgres_schema.hpp"

namespace tonus::store {
namespace {

/// "tonus" as a number: names the lock of the one archive that writes a database.
constexpr std::int64_t kWriterLock = 0x746F6E7573;

/// Parameters of the connection that the URL does not give itself.
std::string with_defaults(std::string url) {
  const auto add = [&url](const std::string& name, const std::string& value) {
    if (url.find(name + "=") != std::string::npos) return;
    url += (url.find('?') == std::string::npos ? "?" : "&") + name + "=" + value;
  };
  add("connect_timeout", "2");      // s
  add("tcp_user_timeout", "2000");  // ms
  add("keepalives_idle", "2");      // s
  add("keepalives_interval", "1");  // s
  add("application_name", "tonus");
  return url;
}

/// The first line of what the server or the library says, without a trailing end of line.
std::string first_line(const std::string& text) { return text.substr(0, text.find('\n')); }

}  // namespace

namespace sql {

Id id(const pqxx::field& field) {
  const pqxx::binarystring bytes(field);
  Id id{};
  if (bytes.size() == id.size()) std::copy_n(bytes.data(), id.size(), id.begin());
  return id;
}

Payload payload(const pqxx::field& field) {
  const pqxx::binarystring bytes(field);
  const auto* first = reinterpret_cast<const std::byte*>(bytes.data());
  return std::make_shared<const std::vector<std::byte>>(first, first + bytes.size());
}

std::string text(const std::string& value) { return masked(value, TextKind::kFile); }

}  // namespace sql

PostgresLink::PostgresLink(const std::string& url, PostgresStore::Access access)
    : url_(with_defaults(url)), name_(without_passwords(url)), access_(access) {}

Error PostgresLink::error(ErrorCode code, const std::string& text) const {
  return fail(code, fmt::format("store '{}': {}", name_, text));
}

Result<void> PostgresLink::guard(const std::function<Result<void>()>& work) {
  try {
    return work();
  } catch (const pqxx::broken_connection& broken) {
    connection_.reset();
    return error(ErrorCode::kIo, "its server cannot be reached: " + first_line(broken.what()));
  } catch (const pqxx::in_doubt_error&) {
    connection_.reset();
    return error(ErrorCode::kIo, "its server was lost while it committed");
  } catch (const pqxx::sql_error& refused) {
    const std::string& state = refused.sqlstate();
    const bool is_damaged = state == "XX001" || state == "XX002";
    const std::string text = first_line(refused.what());
    // After a shutdown or a crash of the server the connection is of no use, whatever it says of itself.
    if (state.starts_with("57P") || state.starts_with("08") || state.empty()) connection_.reset();
    return error(is_damaged ? ErrorCode::kDataLoss : ErrorCode::kIo, "its server refuses: " + text);
  } catch (const std::exception& other) {
    connection_.reset();
    return error(ErrorCode::kIo, "cannot be used: " + first_line(other.what()));
  }
}

Result<void> PostgresLink::connect() {
  if (connection_ && connection_->is_open()) return {};
  return guard([this]() -> Result<void> {
    connection_ = std::make_unique<pqxx::connection>(url_);
    auto prepared = prepare();
    if (!prepared) connection_.reset();
    return prepared;
  });
}

Result<void> PostgresLink::prepare() {
  pqxx::nontransaction session(*connection_);
  if (session.exec1("SHOW fsync")[0].as<std::string>() != "on") {
    return error(ErrorCode::kInvalidArgument,
                 "its server's fsync is off, so that stored data could be lost; expected on");
  }
  session.exec("SET synchronous_commit TO on");
  session.exec("SET bytea_output TO hex");
  session.exec("SET client_encoding TO 'UTF8'");
  session.exec("SET client_min_messages TO warning");
  session.exec("SET search_path TO tonus");
  if (!is_for_writing()) {
    session.exec("SET default_transaction_read_only TO on");
    return check_postgres_schema(session, *this);
  }
  // The server finds out about a writer that is gone, and lets the next one write.
  session.exec("SET tcp_keepalives_idle TO 5");
  session.exec("SET tcp_keepalives_interval TO 1");
  session.exec("SET tcp_keepalives_count TO 3");
  const auto lock = session.exec(fmt::format("SELECT pg_try_advisory_lock({})", kWriterLock));
  if (!lock[0][0].as<bool>())
    return error(ErrorCode::kUnavailable, "is in use: another archive writes it, and one may at a time");
  return migrate_postgres(session, *this, SystemClock().utc_ns());
}

Result<void> PostgresLink::run(const std::function<void(pqxx::transaction_base&)>& work) {
  TONUS_TRY(connect());
  return guard([&]() -> Result<void> {
    pqxx::work transaction(*connection_);
    work(transaction);
    transaction.commit();
    return {};
  });
}

}  // namespace tonus::store
