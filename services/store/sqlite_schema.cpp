#include "services/store/sqlite_schema.hpp"

#include <array>
#include <spdlog/fmt/fmt.h>

namespace tonus::store {
namespace {

struct Migration {
  int version;
  const char* name;
  const char* sql;
};

// Steps are only ever added. Ids are 16 bytes, *_ns are UTC in ns, checksums are CRC-32C of the payload
// beside them, payloads are CDR as the contract's .idl files define it.
constexpr std::array kMigrations{
    Migration{1, "first tables", R"sql(
CREATE TABLE streams (
  stream INTEGER PRIMARY KEY,
  rig_id BLOB NOT NULL,
  epoch INTEGER NOT NULL,
  origin_sequence INTEGER NOT NULL,
  resent_samples INTEGER NOT NULL,
  duplicated_samples INTEGER NOT NULL,
  UNIQUE (rig_id, epoch));

CREATE TABLE coverage (
  stream INTEGER NOT NULL REFERENCES streams,
  first_sequence INTEGER NOT NULL,
  last_sequence INTEGER NOT NULL,
  PRIMARY KEY (stream, first_sequence)) WITHOUT ROWID;

CREATE TABLE blocks (
  block INTEGER PRIMARY KEY,
  stream INTEGER NOT NULL REFERENCES streams,
  first_sequence INTEGER NOT NULL,
  sample_count INTEGER NOT NULL,
  session_id BLOB NOT NULL,
  trial_id BLOB NOT NULL,
  is_resent INTEGER NOT NULL,
  received_ns INTEGER NOT NULL,
  crc32c INTEGER NOT NULL,
  payload BLOB NOT NULL);
CREATE INDEX blocks_by_sequence ON blocks (stream, first_sequence);

CREATE TABLE messages (
  message INTEGER PRIMARY KEY,
  topic TEXT NOT NULL,
  key BLOB NOT NULL,
  session_id BLOB NOT NULL,
  received_ns INTEGER NOT NULL,
  crc32c INTEGER NOT NULL,
  payload BLOB NOT NULL);
CREATE INDEX messages_by_key ON messages (topic, key);

CREATE TABLE sessions (
  session_id BLOB PRIMARY KEY,
  rig_id BLOB NOT NULL,
  subject TEXT NOT NULL,
  protocol_name TEXT NOT NULL,
  seed INTEGER NOT NULL,
  planned_trials INTEGER NOT NULL,
  started_at TEXT NOT NULL,
  software_version TEXT NOT NULL);

CREATE TABLE trials (
  trial_id BLOB PRIMARY KEY,
  session_id BLOB NOT NULL,
  rig_id BLOB NOT NULL,
  epoch INTEGER NOT NULL,
  attempt INTEGER NOT NULL,
  planned_index INTEGER NOT NULL,
  posture TEXT NOT NULL,
  set_number INTEGER NOT NULL,
  trial_end INTEGER NOT NULL,
  has_samples INTEGER NOT NULL,
  first_sequence INTEGER NOT NULL,
  onset_sequence INTEGER NOT NULL,
  last_sequence INTEGER NOT NULL,
  sample_rate_Hz REAL NOT NULL,
  is_certified INTEGER NOT NULL,
  certified_ns INTEGER NOT NULL,
  expected_samples INTEGER NOT NULL,
  received_samples INTEGER NOT NULL,
  resent_samples INTEGER NOT NULL,
  duplicated_samples INTEGER NOT NULL,
  missing_samples INTEGER NOT NULL);
CREATE INDEX trials_by_session ON trials (session_id, attempt);
CREATE INDEX trials_uncertified ON trials (trial_id) WHERE is_certified = 0;

CREATE TABLE trial_tallies (
  trial_id BLOB PRIMARY KEY,
  resent_samples INTEGER NOT NULL,
  duplicated_samples INTEGER NOT NULL);
)sql"},
    Migration{2, "certificates of sessions", R"sql(
CREATE TABLE session_certificates (
  session_id BLOB PRIMARY KEY,
  rig_id BLOB NOT NULL,
  session_end INTEGER NOT NULL,
  trials INTEGER NOT NULL,
  incomplete_trials INTEGER NOT NULL,
  expected_samples INTEGER NOT NULL,
  received_samples INTEGER NOT NULL,
  resent_samples INTEGER NOT NULL,
  duplicated_samples INTEGER NOT NULL,
  missing_samples INTEGER NOT NULL,
  certified_ns INTEGER NOT NULL);
)sql"},
    Migration{3, "auxiliary channels", R"sql(
ALTER TABLE blocks ADD COLUMN is_auxiliary INTEGER NOT NULL DEFAULT 0;
ALTER TABLE streams ADD COLUMN auxiliary_values INTEGER NOT NULL DEFAULT 0;

CREATE TABLE auxiliary_coverage (
  stream INTEGER NOT NULL REFERENCES streams,
  first_sequence INTEGER NOT NULL,
  last_sequence INTEGER NOT NULL,
  PRIMARY KEY (stream, first_sequence)) WITHOUT ROWID;
)sql"},
};

// Indexes change no content: they are no version, and a file that is only read does without.
constexpr const char* kIndexes = "CREATE INDEX IF NOT EXISTS messages_by_session ON messages (session_id)";

Error foreign(const Database& database, const std::string& reason) {
  return fail(ErrorCode::kInvalidArgument,
              fmt::format("store '{}': is not an archive of tonus: {}", database.path(), reason));
}

Result<void> apply(Database& database, const Migration& migration, std::uint64_t utc_ns) {
  TONUS_TRY(database.run("BEGIN IMMEDIATE"));
  const std::string note = fmt::format("INSERT INTO schema_migrations VALUES ({}, '{}', {})",
                                       migration.version, migration.name, utc_ns);
  const std::string mark = fmt::format("PRAGMA application_id = {}", kApplicationId);
  constexpr const char* kMakeMigrations =
      "CREATE TABLE IF NOT EXISTS schema_migrations "
      "(version INTEGER PRIMARY KEY, name TEXT NOT NULL, applied_ns INTEGER NOT NULL)";
  const char* const steps[] = {mark.c_str(), kMakeMigrations, migration.sql, note.c_str(), "COMMIT"};
  for (const char* step : steps) {
    if (auto done = database.run(step); !done) {
      if (database.is_in_transaction()) static_cast<void>(database.run("ROLLBACK"));
      return done;
    }
  }
  return {};
}

}  // namespace

int newest_schema_version() { return kMigrations.back().version; }

Result<int> schema_version(Database& database) {
  const auto application = database.number("PRAGMA application_id");
  if (!application) {
    if (application.error().code == ErrorCode::kDataLoss)
      return foreign(database, "it is not an SQLite file");
    return application.error();
  }
  TONUS_TRY_ASSIGN(const auto tables, database.number("SELECT count(*) FROM sqlite_master"));
  if (*application == 0 && tables == 0) return 0;
  if (*application != kApplicationId) {
    return foreign(database,
                   fmt::format("its application_id is {:#x}; expected {:#x}", *application, kApplicationId));
  }
  const auto version = database.number("SELECT max(version) FROM schema_migrations");
  if (!version) return version.error();
  if (*version < 1 || *version > newest_schema_version()) {
    return fail(ErrorCode::kInvalidArgument,
                fmt::format("store '{}': schema version {} is not allowed; expected 1 to {}; a newer program "
                            "wrote the file",
                            database.path(), *version, newest_schema_version()));
  }
  return static_cast<int>(*version);
}

Result<std::vector<SchemaTable>> tables_of_schema() {
  TONUS_TRY_ASSIGN(auto database, Database::open(":memory:", Database::Mode::kReadWrite));
  TONUS_TRY(migrate(database, 0));
  TONUS_TRY_ASSIGN(auto columns, Statement::prepare(database,
                                                    "SELECT t.name, c.name, c.type FROM sqlite_master t, "
                                                    "pragma_table_info(t.name) c WHERE t.type = 'table' "
                                                    "ORDER BY t.rowid, c.cid"));
  std::vector<SchemaTable> tables;
  while (true) {
    TONUS_TRY_ASSIGN(const bool has_row, columns.step(database));
    if (!has_row) return tables;
    const std::string name(columns.text(0));
    if (tables.empty() || tables.back().name != name) tables.push_back({name, {}});
    tables.back().columns.push_back({std::string(columns.text(1)), std::string(columns.text(2))});
  }
}

std::vector<std::string> steps_after(int version) {
  std::vector<std::string> steps;
  for (const Migration& migration : kMigrations) {
    if (migration.version > version)
      steps.push_back(fmt::format("{}: {}", migration.version, migration.name));
  }
  return steps;
}

Result<void> migrate(Database& database, std::uint64_t utc_ns) {
  TONUS_TRY_ASSIGN(const int version, schema_version(database));
  for (const Migration& migration : kMigrations) {
    if (migration.version <= version) continue;
    TONUS_TRY(apply(database, migration, utc_ns));
  }
  return database.run(kIndexes);
}

}  // namespace tonus::store
