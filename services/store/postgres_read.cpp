#include <algorithm>
#include <limits>
#include <spdlog/fmt/fmt.h>

#include "services/store/postgres_link.hpp"
#include "services/store/postgres_store.hpp"

namespace tonus::store {
namespace {

/// No block holds more samples: how far before a range a block may start that reaches into it.
constexpr std::uint64_t kLargestBlock = 4096;

/// Rows that are fetched at once. Nothing is open between two fetches, so a visitor may use the store.
constexpr int kPage = 256;

constexpr const char* kTrialColumns =
    "SELECT trial_id, session_id, rig_id, epoch, attempt, planned_index, posture, set_number, trial_end, "
    "has_samples, first_sequence, onset_sequence, last_sequence, sample_rate_hz, is_certified, certified_ns, "
    "expected_samples, received_samples, resent_samples, duplicated_samples, missing_samples FROM trials ";

Certificate counts_at(const pqxx::row& row, pqxx::row_size_type first) {
  return {sql::natural(row[first]), sql::natural(row[first + 1]), sql::natural(row[first + 2]),
          sql::natural(row[first + 3]), sql::natural(row[first + 4])};
}

TrialRecord trial_of(const pqxx::row& row) {
  TrialRecord trial;
  trial.trial = sql::id(row[0]);
  trial.session = sql::id(row[1]);
  trial.stream = {sql::id(row[2]), sql::natural(row[3])};
  trial.attempt = sql::natural32(row[4]);
  trial.planned_index = sql::natural32(row[5]);
  trial.posture = sql::text(row[6].as<std::string>());
  trial.set = static_cast<std::int32_t>(row[7].as<std::int64_t>());
  trial.end = sql::natural32(row[8]);
  trial.has_samples = row[9].as<bool>();
  trial.first_sequence = sql::natural(row[10]);
  trial.onset_sequence = sql::natural(row[11]);
  trial.last_sequence = sql::natural(row[12]);
  trial.sample_rate = row[13].as<double>();
  trial.is_certified = row[14].as<bool>();
  trial.certified_ns = sql::natural(row[15]);
  trial.certificate = counts_at(row, 16);
  return trial;
}

Coverage coverage_in(pqxx::transaction_base& transaction, const std::string& table, std::int64_t stream) {
  Coverage coverage;
  const auto ranges = transaction.exec_params(
      "SELECT first_sequence, last_sequence FROM " + table + " WHERE stream = $1 ORDER BY first_sequence",
      stream);
  for (const pqxx::row& range : ranges) coverage.add({sql::natural(range[0]), sql::natural(range[1]) + 1});
  return coverage;
}

/// All rows of a query, each made into a T.
template <typename T, typename Make, typename... Parameters>
Result<std::vector<T>> collect(PostgresLink& link, const std::string& query, const Make& make,
                               const Parameters&... parameters) {
  std::vector<T> all;
  auto done = link.run([&](pqxx::transaction_base& transaction) {
    for (const pqxx::row& row : transaction.exec_params(query, parameters...)) all.push_back(make(row));
  });
  if (!done) return done.error();
  return all;
}

}  // namespace

Result<std::vector<StreamRecord>> PostgresStore::streams() {
  std::vector<StreamRecord> all;
  auto done = link_->run([&all](pqxx::transaction_base& transaction) {
    const auto streams = transaction.exec(
        "SELECT stream, rig_id, epoch, origin_sequence, resent_samples, duplicated_samples, "
        "auxiliary_values FROM streams ORDER BY rig_id, epoch");
    for (const pqxx::row& row : streams) {
      StreamRecord stream{{sql::id(row[1]), sql::natural(row[2])},
                          sql::natural(row[3]),
                          {},
                          sql::natural(row[4]),
                          sql::natural(row[5]),
                          sql::natural32(row[6])};
      stream.coverage = coverage_in(transaction, "coverage", row[0].as<std::int64_t>());
      stream.auxiliary_coverage = coverage_in(transaction, "auxiliary_coverage", row[0].as<std::int64_t>());
      all.push_back(std::move(stream));
    }
  });
  if (!done) return done.error();
  return all;
}

Result<std::vector<SessionRecord>> PostgresStore::sessions() {
  return collect<SessionRecord>(
      *link_,
      "SELECT session_id, rig_id, subject, protocol_name, seed, planned_trials, started_at, software_version "
      "FROM sessions ORDER BY started_at COLLATE \"C\", session_id",
      [](const pqxx::row& row) {
        return SessionRecord{sql::id(row[0]),
                             sql::id(row[1]),
                             sql::text(row[2].as<std::string>()),
                             sql::text(row[3].as<std::string>()),
                             sql::natural(row[4]),
                             sql::natural32(row[5]),
                             sql::text(row[6].as<std::string>()),
                             sql::text(row[7].as<std::string>())};
      });
}

Result<std::vector<TrialRecord>> PostgresStore::trials(const Id& session) {
  return collect<TrialRecord>(*link_, std::string(kTrialColumns) + "WHERE session_id = $1 ORDER BY attempt",
                              trial_of, sql::bytes(session));
}

Result<std::optional<TrialRecord>> PostgresStore::find_trial(const Id& trial) {
  TONUS_TRY_ASSIGN(auto trials,
                   collect<TrialRecord>(*link_, std::string(kTrialColumns) + "WHERE trial_id = $1", trial_of,
                                        sql::bytes(trial)));
  return trials.empty() ? std::optional<TrialRecord>() : std::move(trials.front());
}

Result<std::vector<TrialRecord>> PostgresStore::uncertified_trials() {
  return collect<TrialRecord>(*link_, std::string(kTrialColumns) + "WHERE NOT is_certified ORDER BY attempt",
                              trial_of);
}

Result<std::vector<TrialTally>> PostgresStore::tallies() {
  return collect<TrialTally>(*link_, "SELECT trial_id, resent_samples, duplicated_samples FROM trial_tallies",
                             [](const pqxx::row& row) {
                               return TrialTally{sql::id(row[0]), sql::natural(row[1]), sql::natural(row[2])};
                             });
}

Result<std::vector<SessionCertificate>> PostgresStore::session_certificates() {
  return collect<SessionCertificate>(
      *link_,
      "SELECT session_id, rig_id, session_end, trials, incomplete_trials, certified_ns, expected_samples, "
      "received_samples, resent_samples, duplicated_samples, missing_samples FROM session_certificates "
      "ORDER BY certified_ns, session_id",
      [](const pqxx::row& row) {
        return SessionCertificate{sql::id(row[0]),        sql::id(row[1]),        sql::natural32(row[2]),
                                  sql::natural32(row[3]), sql::natural32(row[4]), counts_at(row, 6),
                                  sql::natural(row[5])};
      });
}

Result<std::vector<MessageDigest>> PostgresStore::newest_messages() {
  return collect<MessageDigest>(
      *link_,
      "SELECT DISTINCT ON (topic, key) topic, key, crc32c, octet_length(payload) FROM messages "
      "ORDER BY topic, key, message DESC",
      [](const pqxx::row& row) {
        return MessageDigest{sql::text(row[0].as<std::string>()), sql::id(row[1]), sql::natural32(row[2]),
                             sql::natural(row[3])};
      });
}

Result<void> PostgresStore::visit_blocks(const BlockQuery& query, const BlockVisitor& visit) {
  const std::uint64_t lowest = query.range.first < kLargestBlock ? 0 : query.range.first - kLargestBlock;
  const auto end = std::min<std::uint64_t>(query.range.end, std::numeric_limits<std::int64_t>::max());
  std::int64_t last_first = -1;
  std::int64_t last_number = 0;
  while (true) {
    std::vector<Block> page;
    auto fetched = link_->run([&](pqxx::transaction_base& transaction) {
      const auto rows = transaction.exec_params(
          "SELECT block, first_sequence, sample_count, session_id, trial_id, is_resent, received_ns, crc32c, "
          "payload FROM blocks WHERE stream = (SELECT stream FROM streams WHERE rig_id = $1 AND epoch = $2) "
          "AND first_sequence >= $3 AND first_sequence < $4 AND first_sequence + sample_count > $5 "
          "AND (first_sequence, block) > ($6, $7) AND is_auxiliary = $8 "
          "ORDER BY first_sequence, block LIMIT $9",
          sql::bytes(query.stream.rig), sql::number(query.stream.epoch), sql::number(lowest),
          sql::number(end), sql::number(query.range.first), last_first, last_number, query.is_auxiliary,
          kPage);
      for (const pqxx::row& row : rows) {
        last_number = row[0].as<std::int64_t>();
        last_first = row[1].as<std::int64_t>();
        page.push_back({query.stream, sql::natural(row[1]), sql::natural32(row[2]), sql::id(row[3]),
                        sql::id(row[4]), row[5].as<bool>(), sql::natural(row[6]), sql::natural32(row[7]),
                        sql::payload(row[8]), query.is_auxiliary});
      }
    });
    if (!fetched) return fetched;
    for (const Block& block : page) {
      if (auto good = check(block, name()); !good && !query.with_damaged) return good;
      TONUS_TRY(visit(block));
    }
    if (page.size() < kPage) return {};
  }
}

Result<void> PostgresStore::visit_messages(const MessageQuery& query, const MessageVisitor& visit) {
  std::int64_t last = 0;
  while (true) {
    std::vector<Message> page;
    auto fetched = link_->run([&](pqxx::transaction_base& transaction) {
      const auto rows = transaction.exec_params(
          "SELECT message, topic, key, session_id, received_ns, crc32c, payload FROM messages "
          "WHERE message > $1 AND ($2 = '' OR topic = $2) AND ($3 = FALSE OR key = $4) "
          "AND ($5 = FALSE OR session_id = $6) AND ($7 = FALSE OR message IN (SELECT max(message) FROM "
          "messages "
          "WHERE message < coalesce((SELECT min(message) FROM messages WHERE session_id = $8), "
          "9223372036854775807) AND ($2 = '' OR topic = $2) GROUP BY topic, key)) ORDER BY message LIMIT $9",
          last, query.topic, query.key.has_value(), sql::bytes(query.key.value_or(kNoId)),
          query.session.has_value(), sql::bytes(query.session.value_or(kNoId)), query.in_force_at.has_value(),
          sql::bytes(query.in_force_at.value_or(kNoId)), kPage);
      for (const pqxx::row& row : rows) {
        last = row[0].as<std::int64_t>();
        page.push_back({sql::text(row[1].as<std::string>()), sql::id(row[2]), sql::id(row[3]),
                        sql::natural(row[4]), sql::natural32(row[5]), sql::payload(row[6])});
      }
    });
    if (!fetched) return fetched;
    for (const Message& message : page) {
      if (auto good = check(message, name()); !good && !query.with_damaged) return good;
      TONUS_TRY(visit(message));
    }
    if (page.size() < kPage) return {};
  }
}

Result<StoreSpace> PostgresStore::space() {
  StoreSpace space;  // what is free on the server's disk cannot be asked for
  auto asked = link_->run([&space](pqxx::transaction_base& transaction) {
    const auto bytes = transaction.exec(
        "SELECT coalesce(sum(pg_total_relation_size(c.oid)), 0)::bigint FROM pg_class c "
        "JOIN pg_namespace n ON n.oid = c.relnamespace WHERE n.nspname = 'tonus' AND c.relkind = 'r'");
    space.used_bytes = sql::natural(bytes[0][0]);
  });
  if (!asked) return asked.error();
  return space;
}

}  // namespace tonus::store
