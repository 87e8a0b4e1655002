#include "services/store/sqlite.hpp"

#include <algorithm>
#include <cstring>
#include <spdlog/fmt/fmt.h>
#include <sqlite3.h>

#include "services/core/text.hpp"

namespace tonus::store {
namespace {

constexpr int kBusyTimeoutMs = 2000;  // a reader's or a checkpoint's lock is waited for this long

ErrorCode code_of(int sqlite_code) {
  switch (sqlite_code & 0xff) {
    case SQLITE_CORRUPT:
    case SQLITE_NOTADB:
      return ErrorCode::kDataLoss;
    case SQLITE_MISUSE:
    case SQLITE_ERROR:
      return ErrorCode::kInternal;
    default:
      return ErrorCode::kIo;
  }
}

/// What SQLite says, in one line: it may quote a damaged schema.
std::string one_line(const char* text) {
  std::string line;
  for (const char* c = text; *c != '\0'; ++c) {
    const bool is_control = static_cast<unsigned char>(*c) < ' ' || *c == '\x7F';
    if (!is_control && *c != ' ') {
      line += *c;
    } else if (!line.empty() && line.back() != ' ') {
      line += ' ';
    }
  }
  return line;
}

std::string in_uri(const std::string& path) {
  std::string uri;
  for (const char c : path) {
    const bool is_special = c == '%' || c == '?' || c == '#' || static_cast<unsigned char>(c) < ' ';
    uri += is_special ? fmt::format("%{:02X}", static_cast<unsigned char>(c)) : std::string(1, c);
  }
  return uri.starts_with("//") ? uri.substr(1) : uri;
}

}  // namespace

Result<Database> Database::open(const std::string& path, Mode mode) {
  const int access =
      mode == Mode::kReadWrite ? SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE : SQLITE_OPEN_READONLY;
  sqlite3* connection = nullptr;
  const std::string resting = "file:" + in_uri(path) + "?immutable=1";
  const int opened = sqlite3_open_v2(
      mode == Mode::kResting ? resting.c_str() : path.c_str(), &connection,
      (mode == Mode::kResting ? SQLITE_OPEN_URI : 0) | access | SQLITE_OPEN_NOMUTEX | SQLITE_OPEN_EXRESCODE,
      nullptr);
  Database database(path, connection);  // a failed open may give a connection too, which has to be closed
  if (opened != SQLITE_OK) {
    const int reason = connection == nullptr ? 0 : sqlite3_system_errno(connection);
    return fail(ErrorCode::kIo, fmt::format("store '{}': cannot be opened: {}", path,
                                            reason != 0 ? std::strerror(reason) : sqlite3_errstr(opened)));
  }
  sqlite3_busy_timeout(connection, kBusyTimeoutMs);
  return database;
}

void Database::Close::operator()(sqlite3* connection) const { sqlite3_close_v2(connection); }

Result<void> Database::run(const char* sql) {
  if (sqlite3_exec(get(), sql, nullptr, nullptr, nullptr) != SQLITE_OK) return error("cannot be used");
  return {};
}

Result<std::int64_t> Database::number(const char* sql) {
  TONUS_TRY_ASSIGN(auto statement, Statement::prepare(*this, sql));
  TONUS_TRY_ASSIGN(const auto has_row, statement.step(*this));
  return has_row ? statement.integer(0) : 0;
}

Result<std::string> Database::text(const char* sql) {
  TONUS_TRY_ASSIGN(auto statement, Statement::prepare(*this, sql));
  TONUS_TRY_ASSIGN(const auto has_row, statement.step(*this));
  return has_row ? statement.text(0) : std::string();
}

bool Database::is_in_transaction() const { return sqlite3_get_autocommit(get()) == 0; }

bool Database::is_read_only() const { return sqlite3_db_readonly(get(), "main") == 1; }

Error Database::error(std::string_view doing) const {
  const int code = sqlite3_extended_errcode(get());
  const bool is_damaged = (code & 0xff) == SQLITE_CORRUPT;
  return fail(code_of(code),
              fmt::format("store '{}': {}: {}{}", path_, doing, one_line(sqlite3_errmsg(get())),
                          is_damaged ? "; `tonus recover` copies what can be read" : ""));
}

Result<Statement> Statement::prepare(Database& database, std::string_view sql) {
  sqlite3_stmt* statement = nullptr;
  if (sqlite3_prepare_v2(database.get(), sql.data(), static_cast<int>(sql.size()), &statement, nullptr) !=
      SQLITE_OK) {
    return database.error("cannot be used");
  }
  return Statement(statement);
}

void Statement::Finalize::operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }

Statement& Statement::bind(int parameter, std::int64_t value) {
  is_bound_ &= sqlite3_bind_int64(statement_.get(), parameter + 1, value) == SQLITE_OK;
  return *this;
}

Statement& Statement::bind(int parameter, double value) {
  is_bound_ &= sqlite3_bind_double(statement_.get(), parameter + 1, value) == SQLITE_OK;
  return *this;
}

Statement& Statement::bind(int parameter, const std::string& value) {
  is_bound_ &= sqlite3_bind_text64(statement_.get(), parameter + 1, value.data(), value.size(), SQLITE_STATIC,
                                   SQLITE_UTF8) == SQLITE_OK;
  return *this;
}

Statement& Statement::bind(int parameter, std::span<const std::byte> value) {
  is_bound_ &= sqlite3_bind_blob64(statement_.get(), parameter + 1, value.data(), value.size(),
                                   SQLITE_STATIC) == SQLITE_OK;
  return *this;
}

Statement& Statement::bind(int parameter, const Id& value) {
  is_bound_ &= sqlite3_bind_blob64(statement_.get(), parameter + 1, value.data(), value.size(),
                                   SQLITE_STATIC) == SQLITE_OK;
  return *this;
}

Result<bool> Statement::step(Database& database) {
  if (!is_bound_)
    return fail(ErrorCode::kInternal, "store '" + database.path() + "': a value could not be bound");
  const int code = sqlite3_step(statement_.get());
  if (code == SQLITE_ROW) return true;
  if (code == SQLITE_DONE) return false;
  return database.error("cannot be used");
}

Result<void> Statement::run(Database& database) {
  const auto stepped = step(database);
  reset();
  if (!stepped) return stepped.error();
  return {};
}

void Statement::reset() {
  sqlite3_reset(statement_.get());
  sqlite3_clear_bindings(statement_.get());
  is_bound_ = true;
}

std::int64_t Statement::integer(int column) const { return sqlite3_column_int64(statement_.get(), column); }

double Statement::real(int column) const { return sqlite3_column_double(statement_.get(), column); }

std::string Statement::text(int column) const {
  const auto* bytes = reinterpret_cast<const char*>(sqlite3_column_text(statement_.get(), column));
  if (bytes == nullptr) return {};
  const auto size = static_cast<std::size_t>(sqlite3_column_bytes(statement_.get(), column));
  return masked({bytes, size}, TextKind::kFile);
}

std::vector<std::byte> Statement::blob(int column) const {
  const auto* bytes = static_cast<const std::byte*>(sqlite3_column_blob(statement_.get(), column));
  const auto size = static_cast<std::size_t>(sqlite3_column_bytes(statement_.get(), column));
  return bytes == nullptr ? std::vector<std::byte>() : std::vector<std::byte>(bytes, bytes + size);
}

Id Statement::id(int column) const {
  Id id{};
  const auto* bytes = static_cast<const std::uint8_t*>(sqlite3_column_blob(statement_.get(), column));
  if (bytes != nullptr && sqlite3_column_bytes(statement_.get(), column) == static_cast<int>(id.size())) {
    std::copy_n(bytes, id.size(), id.begin());
  }
  return id;
}

}  // namespace tonus::store
