#include "services/store/sqlite_store.hpp"

namespace tonus::store {
namespace {

/// No block holds more samples: how far before a range a block may start that reaches into it.
constexpr std::uint64_t kLargestBlock = 4096;

constexpr const char* kTrialColumns =
    "SELECT trial_id, session_id, rig_id, epoch, attempt, planned_index, posture, set_number, trial_end, "
    "has_samples, "
    "first_sequence, onset_sequence, last_sequence, sample_rate_Hz, is_certified, certified_ns, "
    "expected_samples, "
    "received_samples, resent_samples, duplicated_samples, missing_samples FROM trials ";

}  // namespace

Result<std::vector<StreamRecord>> SqliteStore::streams() {
  TONUS_TRY_ASSIGN(auto statement,
                   Statement::prepare(database_,
                                      "SELECT stream, rig_id, epoch, origin_sequence, resent_samples, "
                                      "duplicated_samples, auxiliary_values FROM streams "
                                      "ORDER BY rig_id, epoch"));
  TONUS_TRY_ASSIGN(
      auto ranges,
      Statement::prepare(
          database_,
          "SELECT first_sequence, last_sequence FROM coverage WHERE stream = ? ORDER BY first_sequence"));
  TONUS_TRY_ASSIGN(auto auxiliary_ranges,
                   Statement::prepare(database_,
                                      "SELECT first_sequence, last_sequence FROM auxiliary_coverage "
                                      "WHERE stream = ? ORDER BY first_sequence"));
  std::vector<StreamRecord> streams;
  while (true) {
    TONUS_TRY_ASSIGN(const auto has_row, statement.step(database_));
    if (!has_row) break;
    const std::int64_t number = statement.integer(0);
    StreamRecord stream{{statement.id(1), statement.natural(2)},
                        statement.natural(3),
                        {},
                        statement.natural(4),
                        statement.natural(5),
                        statement.natural32(6)};
    TONUS_TRY_ASSIGN(stream.coverage, read_coverage(database_, ranges, number));
    TONUS_TRY_ASSIGN(stream.auxiliary_coverage, read_coverage(database_, auxiliary_ranges, number));
    stream_numbers_[stream.key] = number;
    streams.push_back(std::move(stream));
  }
  TONUS_TRY(check_resting());
  return streams;
}

Result<Coverage> SqliteStore::read_coverage(Database& database, Statement& ranges, std::int64_t stream) {
  Coverage coverage;
  ranges.bind(0, stream);
  while (true) {
    TONUS_TRY_ASSIGN(const auto has_range, ranges.step(database));
    if (!has_range) break;
    coverage.add({ranges.natural(0), ranges.natural(1) + 1});
  }
  ranges.reset();
  return coverage;
}

Result<std::vector<SessionRecord>> SqliteStore::sessions() {
  TONUS_TRY_ASSIGN(auto statement,
                   Statement::prepare(database_,
                                      "SELECT session_id, rig_id, subject, protocol_name, seed, "
                                      "planned_trials, started_at, software_version FROM sessions "
                                      "ORDER BY started_at, rowid"));
  std::vector<SessionRecord> sessions;
  while (true) {
    TONUS_TRY_ASSIGN(const auto has_row, statement.step(database_));
    if (!has_row) break;
    sessions.push_back({statement.id(0), statement.id(1), statement.text(2), statement.text(3),
                        statement.natural(4), statement.natural32(5), statement.text(6), statement.text(7)});
  }
  TONUS_TRY(check_resting());
  return sessions;
}

Result<std::vector<TrialRecord>> SqliteStore::read_trials(Statement& statement) {
  std::vector<TrialRecord> trials;
  while (true) {
    TONUS_TRY_ASSIGN(const auto has_row, statement.step(database_));
    if (!has_row) break;
    TrialRecord trial;
    trial.trial = statement.id(0);
    trial.session = statement.id(1);
    trial.stream = {statement.id(2), statement.natural(3)};
    trial.attempt = statement.natural32(4);
    trial.planned_index = statement.natural32(5);
    trial.posture = statement.text(6);
    trial.set = static_cast<std::int32_t>(statement.integer(7));
    trial.end = statement.natural32(8);
    trial.has_samples = statement.integer(9) != 0;
    trial.first_sequence = statement.natural(10);
    trial.onset_sequence = statement.natural(11);
    trial.last_sequence = statement.natural(12);
    trial.sample_rate = statement.real(13);
    trial.is_certified = statement.integer(14) != 0;
    trial.certified_ns = statement.natural(15);
    trial.certificate = {statement.natural(16), statement.natural(17), statement.natural(18),
                         statement.natural(19), statement.natural(20)};
    trials.push_back(std::move(trial));
  }
  TONUS_TRY(check_resting());
  return trials;
}

Result<std::vector<TrialRecord>> SqliteStore::trials(const Id& session) {
  TONUS_TRY_ASSIGN(
      auto statement,
      Statement::prepare(database_, std::string(kTrialColumns) + "WHERE session_id = ? ORDER BY attempt"));
  statement.bind(0, session);
  return read_trials(statement);
}

Result<std::optional<TrialRecord>> SqliteStore::find_trial(const Id& trial) {
  if (!find_trial_) {
    TONUS_TRY_ASSIGN(auto statement,
                     Statement::prepare(database_, std::string(kTrialColumns) + "WHERE trial_id = ?"));
    find_trial_.emplace(std::move(statement));
  }
  find_trial_->bind(0, trial);
  auto trials = read_trials(*find_trial_);
  find_trial_->reset();
  if (!trials) return trials.error();
  return trials->empty() ? std::optional<TrialRecord>() : std::move(trials->front());
}

Result<std::vector<TrialRecord>> SqliteStore::uncertified_trials() {
  TONUS_TRY_ASSIGN(
      auto statement,
      Statement::prepare(database_, std::string(kTrialColumns) + "WHERE is_certified = 0 ORDER BY attempt"));
  return read_trials(statement);
}

Result<std::vector<TrialTally>> SqliteStore::tallies() {
  TONUS_TRY_ASSIGN(auto statement,
                   Statement::prepare(
                       database_, "SELECT trial_id, resent_samples, duplicated_samples FROM trial_tallies"));
  std::vector<TrialTally> tallies;
  while (true) {
    TONUS_TRY_ASSIGN(const auto has_row, statement.step(database_));
    if (!has_row) break;
    tallies.push_back({statement.id(0), statement.natural(1), statement.natural(2)});
  }
  TONUS_TRY(check_resting());
  return tallies;
}

Result<std::vector<SessionCertificate>> SqliteStore::session_certificates() {
  TONUS_TRY_ASSIGN(
      auto statement,
      Statement::prepare(
          database_,
          "SELECT session_id, rig_id, session_end, trials, incomplete_trials, expected_samples, "
          "received_samples, "
          "resent_samples, duplicated_samples, missing_samples, certified_ns FROM session_certificates "
          "ORDER BY certified_ns, rowid"));
  std::vector<SessionCertificate> certificates;
  while (true) {
    TONUS_TRY_ASSIGN(const auto has_row, statement.step(database_));
    if (!has_row) break;
    certificates.push_back({statement.id(0),
                            statement.id(1),
                            statement.natural32(2),
                            statement.natural32(3),
                            statement.natural32(4),
                            {statement.natural(5), statement.natural(6), statement.natural(7),
                             statement.natural(8), statement.natural(9)},
                            statement.natural(10)});
  }
  TONUS_TRY(check_resting());
  return certificates;
}

Result<std::vector<MessageDigest>> SqliteStore::newest_messages() {
  TONUS_TRY_ASSIGN(
      auto statement,
      Statement::prepare(database_,
                         "SELECT topic, key, crc32c, length(payload) FROM messages "
                         "WHERE message IN (SELECT max(message) FROM messages GROUP BY topic, key)"));
  std::vector<MessageDigest> digests;
  while (true) {
    TONUS_TRY_ASSIGN(const auto has_row, statement.step(database_));
    if (!has_row) break;
    digests.push_back({statement.text(0), statement.id(1), statement.natural32(2), statement.natural(3)});
  }
  TONUS_TRY(check_resting());
  return digests;
}

Result<void> SqliteStore::visit_blocks(const BlockQuery& query, const BlockVisitor& visit) {
  TONUS_TRY_ASSIGN(
      auto statement,
      Statement::prepare(
          database_,
          "SELECT first_sequence, sample_count, session_id, trial_id, is_resent, received_ns, crc32c, "
          "payload "
          "FROM blocks "
          "WHERE stream = (SELECT stream FROM streams WHERE rig_id = ? AND epoch = ?) AND first_sequence >= "
          "? "
          "AND "
          "first_sequence < ? AND first_sequence + sample_count > ? AND is_auxiliary = ? "
          "ORDER BY first_sequence, block"));
  const std::uint64_t lowest = query.range.first < kLargestBlock ? 0 : query.range.first - kLargestBlock;
  statement.bind(0, query.stream.rig).bind(1, query.stream.epoch);
  statement.bind(2, lowest).bind(3, query.range.end).bind(4, query.range.first).bind(5, query.is_auxiliary);
  while (true) {
    TONUS_TRY_ASSIGN(const auto has_row, statement.step(database_));
    if (!has_row) return check_resting();
    Block block{query.stream,
                statement.natural(0),
                statement.natural32(1),
                statement.id(2),
                statement.id(3),
                statement.integer(4) != 0,
                statement.natural(5),
                statement.natural32(6),
                std::make_shared<const std::vector<std::byte>>(statement.blob(7)),
                query.is_auxiliary};
    if (auto good = check(block, name()); !good && !query.with_damaged) return good;
    TONUS_TRY(visit(block));
  }
}

Result<void> SqliteStore::visit_messages(const MessageQuery& query, const MessageVisitor& visit) {
  std::string sql = "SELECT topic, key, session_id, received_ns, crc32c, payload FROM messages WHERE 1";
  if (!query.topic.empty()) sql += " AND topic = ?1";
  if (query.key) sql += " AND key = ?2";
  if (query.session) sql += " AND session_id = ?3";
  if (query.in_force_at) {
    sql +=
        " AND message IN (SELECT max(message) FROM messages WHERE message < coalesce((SELECT min(message) "
        "FROM messages WHERE session_id = ?4), 9223372036854775807)";
    if (!query.topic.empty()) sql += " AND topic = ?1";
    sql += " GROUP BY topic, key)";
  }
  TONUS_TRY_ASSIGN(auto statement, Statement::prepare(database_, sql + " ORDER BY message"));
  if (!query.topic.empty()) statement.bind(0, query.topic);
  if (query.key) statement.bind(1, *query.key);
  if (query.session) statement.bind(2, *query.session);
  if (query.in_force_at) statement.bind(3, *query.in_force_at);
  while (true) {
    TONUS_TRY_ASSIGN(const auto has_row, statement.step(database_));
    if (!has_row) return check_resting();
    Message message{
        statement.text(0),      statement.id(1),
        statement.id(2),        statement.natural(3),
        statement.natural32(4), std::make_shared<const std::vector<std::byte>>(statement.blob(5))};
    if (auto good = check(message, name()); !good && !query.with_damaged) return good;
    TONUS_TRY(visit(message));
  }
}

}  // namespace tonus::store
