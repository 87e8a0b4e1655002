#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "services/core/id.hpp"
#include "services/core/result.hpp"

struct sqlite3;
struct sqlite3_stmt;

namespace tonus::store {

/// A connection to an SQLite file, closed when it goes. For one thread. Every error names the file and what
/// SQLite says; kIo, or kDataLoss where SQLite finds the file damaged.
class Database {
 public:
  enum class Mode : std::uint8_t { kReadOnly, kReadWrite, kResting };

  /// Opens the file; kReadWrite makes it where it is missing. kResting reads a file that nobody writes: it
  /// takes no lock and makes no file beside it, so that it needs no right to write, and sees no change.
  [[nodiscard]] static Result<Database> open(const std::string& path, Mode mode);

  Database(Database&&) noexcept = default;
  Database& operator=(Database&&) noexcept = default;

  /// Runs statements that give no rows.
  [[nodiscard]] Result<void> run(const char* sql);

  /// First column of the first row, as a whole number or text.
  [[nodiscard]] Result<std::int64_t> number(const char* sql);
  [[nodiscard]] Result<std::string> text(const char* sql);

  [[nodiscard]] bool is_in_transaction() const;
  [[nodiscard]] bool is_read_only() const;

  /// What SQLite says of its last failure.
  [[nodiscard]] Error error(std::string_view doing) const;

  [[nodiscard]] sqlite3* get() const { return connection_.get(); }
  [[nodiscard]] const std::string& path() const { return path_; }

 private:
  struct Close {
    void operator()(sqlite3* connection) const;
  };
  Database(std::string path, sqlite3* connection) : path_(std::move(path)), connection_(connection) {}

  std::string path_;
  std::unique_ptr<sqlite3, Close> connection_;
};

/// A prepared statement. Parameters and columns count from 0. A bound blob or text must live until the
/// statement is reset; reset() also forgets all bindings.
class Statement {
 public:
  [[nodiscard]] static Result<Statement> prepare(Database& database, std::string_view sql);

  Statement(Statement&&) noexcept = default;
  Statement& operator=(Statement&&) noexcept = default;

  Statement& bind(int parameter, std::int64_t value);
  Statement& bind(int parameter, std::uint64_t value) {
    return bind(parameter, static_cast<std::int64_t>(value));
  }
  Statement& bind(int parameter, std::uint32_t value) {
    return bind(parameter, static_cast<std::int64_t>(value));
  }
  Statement& bind(int parameter, std::int32_t value) {
    return bind(parameter, static_cast<std::int64_t>(value));
  }
  Statement& bind(int parameter, bool value) { return bind(parameter, static_cast<std::int64_t>(value)); }
  Statement& bind(int parameter, double value);
  Statement& bind(int parameter, const std::string& value);
  Statement& bind(int parameter, std::span<const std::byte> value);
  Statement& bind(int parameter, const Id& value);

  /// Goes to the next row; false where there is none.
  [[nodiscard]] Result<bool> step(Database& database);

  /// Runs a statement that gives no rows, and resets it.
  [[nodiscard]] Result<void> run(Database& database);

  void reset();

  [[nodiscard]] std::int64_t integer(int column) const;
  [[nodiscard]] std::uint64_t natural(int column) const {
    return static_cast<std::uint64_t>(integer(column));
  }
  [[nodiscard]] std::uint32_t natural32(int column) const {
    return static_cast<std::uint32_t>(integer(column));
  }
  [[nodiscard]] double real(int column) const;
  [[nodiscard]] std::string text(int column) const;  ///< Masked: UTF-8, with its line ends.
  [[nodiscard]] std::vector<std::byte> blob(int column) const;
  [[nodiscard]] Id id(int column) const;  ///< All zero where the blob has another length.

 private:
  struct Finalize {
    void operator()(sqlite3_stmt* statement) const;
  };
  explicit Statement(sqlite3_stmt* statement) : statement_(statement) {}

  std::unique_ptr<sqlite3_stmt, Finalize> statement_;
  bool is_bound_ = true;  ///< No binding failed since the last reset.
};

}  // namespace tonus::store
