#pragma once

#include <functional>
#include <memory>
#include <pqxx/pqxx>
#include <string>

#include "services/core/id.hpp"
#include "services/store/postgres_store.hpp"

namespace tonus::store {

/// The connection of a PostgresStore, made anew where it was lost, and the translation of its exceptions.
class PostgresLink {
 public:
  PostgresLink(const std::string& url, PostgresStore::Access access);

  /// Connects where there is no connection, and prepares it: the schema, its version, the right to be the
  /// only one that writes. Errors as PostgresStore::open().
  [[nodiscard]] Result<void> connect();

  /// Runs `work` in a transaction, and commits it. On any error nothing of it is there, but where the
  /// connection is lost during the commit itself: then all of it may be there.
  [[nodiscard]] Result<void> run(const std::function<void(pqxx::transaction_base&)>& work);

  [[nodiscard]] bool is_for_writing() const { return access_ == PostgresStore::Access::kWrite; }
  [[nodiscard]] const std::string& name() const { return name_; }

  /// "store 'NAME': TEXT"
  [[nodiscard]] Error error(ErrorCode code, const std::string& text) const;

 private:
  [[nodiscard]] Result<void> guard(const std::function<Result<void>()>& work);
  [[nodiscard]] Result<void> prepare();

  std::string url_;
  std::string name_;  ///< The URL without its password.
  PostgresStore::Access access_;
  std::unique_ptr<pqxx::connection> connection_;
};

/// Between the records' values and SQL's.
namespace sql {

[[nodiscard]] inline pqxx::binarystring bytes(const Id& id) { return {id.data(), id.size()}; }
[[nodiscard]] inline std::int64_t number(std::uint64_t value) { return static_cast<std::int64_t>(value); }
[[nodiscard]] inline std::uint64_t natural(const pqxx::field& field) {
  return static_cast<std::uint64_t>(field.as<std::int64_t>());
}
[[nodiscard]] inline std::uint32_t natural32(const pqxx::field& field) {
  return static_cast<std::uint32_t>(field.as<std::int64_t>());
}
[[nodiscard]] Id id(const pqxx::field& field);  ///< All zero where the value has another length.
[[nodiscard]] Payload payload(const pqxx::field& field);

/// Masked, with its line ends: what is not UTF-8 the server would refuse.
[[nodiscard]] std::string text(const std::string& value);

}  // namespace sql
}  // namespace tonus::store
