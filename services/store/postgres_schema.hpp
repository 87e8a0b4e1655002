#pragma once

#include "services/store/postgres_link.hpp"

namespace tonus::store {

/// Makes the schema `tonus` and its tables where they are missing, and brings older tables to the newest
/// version, each step in a transaction of its own. kInvalidArgument: a newer program made them.
[[nodiscard]] Result<void> migrate_postgres(pqxx::transaction_base& session, const PostgresLink& link,
                                            std::uint64_t utc_ns);

/// kNotFound: the database holds no archive. kInvalidArgument: its tables are of another version.
[[nodiscard]] Result<void> check_postgres_schema(pqxx::transaction_base& session, const PostgresLink& link);

}  // namespace tonus::store
