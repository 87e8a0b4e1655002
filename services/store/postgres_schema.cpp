#include "services/store/postgres_schema.hpp"

#include <array>
#include <spdlog/fmt/fmt.h>

namespace tonus::store {
namespace {

struct Migration {
  int version;
  const char* name;
  const char* sql;
};

// Steps are only ever added. Names and meaning are those of the tables of an SQLite store. Whole numbers of
// 64 bits without sign are kept by their bits.
constexpr std::array kMigrations{
    Migration{1, "first tables", R"sql(
CREATE TABLE streams (
  stream BIGINT GENERATED ALWAYS AS IDENTITY PRIMARY KEY,
  rig_id BYTEA NOT NULL,
  epoch BIGINT NOT NULL,
  origin_sequence BIGINT NOT NULL,
  resent_samples BIGINT NOT NULL,
  duplicated_samples BIGINT NOT NULL,
  UNIQUE (rig_id, epoch));

CREATE TABLE coverage (
  stream BIGINT NOT NULL REFERENCES streams,
  first_sequence BIGINT NOT NULL,
  last_sequence BIGINT NOT NULL,
  PRIMARY KEY (stream, first_sequence));

CREATE TABLE blocks (
  block BIGINT GENERATED ALWAYS AS IDENTITY PRIMARY KEY,
  stream BIGINT NOT NULL REFERENCES streams,
  first_sequence BIGINT NOT NULL,
  sample_count BIGINT NOT NULL,
  session_id BYTEA NOT NULL,
  trial_id BYTEA NOT NULL,
  is_resent BOOLEAN NOT NULL,
  received_ns BIGINT NOT NULL,
  crc32c BIGINT NOT NULL,
  payload BYTEA NOT NULL);
ALTER TABLE blocks ALTER COLUMN payload SET STORAGE EXTERNAL;
CREATE INDEX blocks_by_sequence ON blocks (stream, first_sequence, block);

CREATE TABLE messages (
  message BIGINT GENERATED ALWAYS AS IDENTITY PRIMARY KEY,
  topic TEXT NOT NULL,
  key BYTEA NOT NULL,
  session_id BYTEA NOT NULL,
  received_ns BIGINT NOT NULL,
  crc32c BIGINT NOT NULL,
  payload BYTEA NOT NULL);
CREATE INDEX messages_by_key ON messages (topic, key, message);

CREATE TABLE sessions (
  session_id BYTEA PRIMARY KEY,
  rig_id BYTEA NOT NULL,
  subject TEXT NOT NULL,
  protocol_name TEXT NOT NULL,
  seed BIGINT NOT NULL,
  planned_trials BIGINT NOT NULL,
  started_at TEXT NOT NULL,
  software_version TEXT NOT NULL);

CREATE TABLE trials (
  trial_id BYTEA PRIMARY KEY,
  session_id BYTEA NOT NULL,
  rig_id BYTEA NOT NULL,
  epoch BIGINT NOT NULL,
  attempt BIGINT NOT NULL,
  planned_index BIGINT NOT NULL,
  posture TEXT NOT NULL,
  set_number BIGINT NOT NULL,
  trial_end BIGINT NOT NULL,
  has_samples BOOLEAN NOT NULL,
  first_sequence BIGINT NOT NULL,
  onset_sequence BIGINT NOT NULL,
  last_sequence BIGINT NOT NULL,
  sample_rate_hz DOUBLE PRECISION NOT NULL,
  is_certified BOOLEAN NOT NULL,
  certified_ns BIGINT NOT NULL,
  expected_samples BIGINT NOT NULL,
  received_samples BIGINT NOT NULL,
  resent_samples BIGINT NOT NULL,
  duplicated_samples BIGINT NOT NULL,
  missing_samples BIGINT NOT NULL);
CREATE INDEX trials_by_session ON trials (session_id, attempt);
CREATE INDEX trials_uncertified ON trials (trial_id) WHERE NOT is_certified;

CREATE TABLE trial_tallies (
  trial_id BYTEA PRIMARY KEY,
  resent_samples BIGINT NOT NULL,
  duplicated_samples BIGINT NOT NULL);
)sql"},
    Migration{2, "certificates of sessions", R"sql(
CREATE TABLE session_certificates (
  session_id BYTEA PRIMARY KEY,
  rig_id BYTEA NOT NULL,
  session_end BIGINT NOT NULL,
  trials BIGINT NOT NULL,
  incomplete_trials BIGINT NOT NULL,
  expected_samples BIGINT NOT NULL,
  received_samples BIGINT NOT NULL,
  resent_samples BIGINT NOT NULL,
  duplicated_samples BIGINT NOT NULL,
  missing_samples BIGINT NOT NULL,
  certified_ns BIGINT NOT NULL);
)sql"},
    Migration{3, "auxiliary channels", R"sql(
ALTER TABLE blocks ADD COLUMN is_auxiliary BOOLEAN NOT NULL DEFAULT FALSE;
ALTER TABLE streams ADD COLUMN auxiliary_values BIGINT NOT NULL DEFAULT 0;

CREATE TABLE auxiliary_coverage (
  stream BIGINT NOT NULL REFERENCES streams,
  first_sequence BIGINT NOT NULL,
  last_sequence BIGINT NOT NULL,
  PRIMARY KEY (stream, first_sequence));
)sql"},
};

/// 0: there are no tables of ours.
int version_of(pqxx::transaction_base& session) {
  const auto there = session.exec("SELECT to_regclass('tonus.schema_migrations') IS NOT NULL");
  if (!there[0][0].as<bool>()) return 0;
  return session.exec("SELECT coalesce(max(version), 0) FROM tonus.schema_migrations")[0][0].as<int>();
}

Error unknown_version(const PostgresLink& link, int version) {
  return link.error(
      ErrorCode::kInvalidArgument,
      fmt::format("schema version {} is not allowed; expected 1 to {}; a newer program wrote it", version,
                  kMigrations.back().version));
}

}  // namespace

Result<void> migrate_postgres(pqxx::transaction_base& session, const PostgresLink& link,
                              std::uint64_t utc_ns) {
  const int version = version_of(session);
  if (version > kMigrations.back().version) return unknown_version(link, version);
  for (const Migration& migration : kMigrations) {
    if (migration.version <= version) continue;
    // One string of several statements is one transaction.
    session.exec(
        fmt::format("CREATE SCHEMA IF NOT EXISTS tonus;"
                    "CREATE TABLE IF NOT EXISTS tonus.schema_migrations "
                    "(version INTEGER PRIMARY KEY, name TEXT NOT NULL, applied_ns BIGINT NOT NULL);"
                    "{}"
                    "INSERT INTO tonus.schema_migrations VALUES ({}, '{}', {});",
                    migration.sql, migration.version, migration.name, utc_ns));
  }
  // Indexes change no content: they are no version, and a reader does without.
  session.exec("CREATE INDEX IF NOT EXISTS messages_by_session ON tonus.messages (session_id, message)");
  return {};
}

Result<void> check_postgres_schema(pqxx::transaction_base& session, const PostgresLink& link) {
  const int version = version_of(session);
  if (version == 0) return link.error(ErrorCode::kNotFound, "no archive of tonus is in this database");
  if (version > kMigrations.back().version) return unknown_version(link, version);
  if (version == kMigrations.back().version) return {};
  return link.error(ErrorCode::kInvalidArgument,
                    fmt::format("schema version {} is not allowed; expected {}; tonus-archive migrates it",
                                version, kMigrations.back().version));
}

}  // namespace tonus::store
