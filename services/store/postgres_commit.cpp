#include <algorithm>
#include <map>
#include <span>
#include <spdlog/fmt/fmt.h>
#include <tuple>

#include "services/store/postgres_link.hpp"
#include "services/store/postgres_store.hpp"

namespace tonus::store {
namespace {

using StreamNumbers = std::map<StreamKey, std::int64_t>;

/// Octets as COPY takes them.
std::string hex(std::span<const std::byte> bytes) {
  static constexpr char kDigits[] = "0123456789abcdef";
  std::string text = "\\x";
  text.reserve(2 + 2 * bytes.size());
  for (const std::byte byte : bytes) {
    text += kDigits[std::to_integer<unsigned>(byte) >> 4U];
    text += kDigits[std::to_integer<unsigned>(byte) & 15U];
  }
  return text;
}

std::string hex(const Id& id) { return hex(std::as_bytes(std::span(id))); }

void write_coverage(pqxx::transaction_base& transaction, const std::string& table, std::int64_t stream,
                    const Coverage& coverage) {
  transaction.exec_params("DELETE FROM " + table + " WHERE stream = $1", stream);
  for (const SequenceRange& range : coverage.ranges()) {
    transaction.exec_params("INSERT INTO " + table + " VALUES ($1, $2, $3)", stream, sql::number(range.first),
                            sql::number(range.end - 1));
  }
}

StreamNumbers write_streams(pqxx::transaction_base& transaction, const Batch& batch) {
  StreamNumbers numbers;
  for (const StreamRecord& stream : batch.streams) {
    const auto row = transaction.exec_params1(
        "INSERT INTO streams (rig_id, epoch, origin_sequence, resent_samples, duplicated_samples, "
        "auxiliary_values) VALUES ($1, $2, $3, $4, $5, $6) ON CONFLICT (rig_id, epoch) DO UPDATE SET "
        "origin_sequence = excluded.origin_sequence, resent_samples = excluded.resent_samples, "
        "duplicated_samples = excluded.duplicated_samples, "
        "auxiliary_values = excluded.auxiliary_values RETURNING stream",
        sql::bytes(stream.key.rig), sql::number(stream.key.epoch), sql::number(stream.origin),
        sql::number(stream.resent), sql::number(stream.duplicated), stream.auxiliary_values);
    const auto number = row[0].as<std::int64_t>();
    numbers[stream.key] = number;
    write_coverage(transaction, "coverage", number, stream.coverage);
    write_coverage(transaction, "auxiliary_coverage", number, stream.auxiliary_coverage);
  }
  return numbers;
}

void write_blocks(pqxx::transaction_base& transaction, const Batch& batch, const StreamNumbers& numbers) {
  if (batch.blocks.empty()) return;
  pqxx::stream_to rows(
      transaction, "blocks",
      std::vector<std::string>{"stream", "first_sequence", "sample_count", "session_id", "trial_id",
                               "is_resent", "received_ns", "crc32c", "payload", "is_auxiliary"});
  for (const Block& block : batch.blocks) {
    rows << std::make_tuple(numbers.at(block.stream), sql::number(block.first_sequence), block.count,
                            hex(block.session), hex(block.trial), std::string(block.is_resent ? "t" : "f"),
                            sql::number(block.received_ns), block.checksum, hex(*block.payload),
                            std::string(block.is_auxiliary ? "t" : "f"));
  }
  rows.complete();
}

void write_messages(pqxx::transaction_base& transaction, const Batch& batch) {
  if (batch.messages.empty()) return;
  pqxx::stream_to rows(
      transaction, "messages",
      std::vector<std::string>{"topic", "key", "session_id", "received_ns", "crc32c", "payload"});
  for (const Message& message : batch.messages) {
    rows << std::make_tuple(sql::text(message.topic), hex(message.key), hex(message.session),
                            sql::number(message.received_ns), message.checksum, hex(*message.payload));
  }
  rows.complete();
}

void write_session(pqxx::transaction_base& transaction, const SessionRecord& session) {
  transaction.exec_params(
      "INSERT INTO sessions VALUES ($1, $2, $3, $4, $5, $6, $7, $8) ON CONFLICT (session_id) DO UPDATE SET "
      "rig_id = excluded.rig_id, subject = excluded.subject, protocol_name = excluded.protocol_name, "
      "seed = excluded.seed, planned_trials = excluded.planned_trials, started_at = excluded.started_at, "
      "software_version = excluded.software_version",
      sql::bytes(session.session), sql::bytes(session.rig), sql::text(session.subject),
      sql::text(session.protocol_name), sql::number(session.seed), session.planned_trials,
      sql::text(session.started_at), sql::text(session.software_version));
}

void write_trial(pqxx::transaction_base& transaction, const TrialRecord& trial) {
  const Certificate& counts = trial.certificate;
  transaction.exec_params("DELETE FROM trials WHERE trial_id = $1", sql::bytes(trial.trial));
  transaction.exec_params(
      "INSERT INTO trials VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9, $10, $11, $12, $13, "
      "$14, $15, $16, $17, $18, $19, $20, $21)",
      sql::bytes(trial.trial), sql::bytes(trial.session), sql::bytes(trial.stream.rig),
      sql::number(trial.stream.epoch), trial.attempt, trial.planned_index, sql::text(trial.posture),
      trial.set, trial.end, trial.has_samples, sql::number(trial.first_sequence),
      sql::number(trial.onset_sequence), sql::number(trial.last_sequence),
      fmt::format("{:.17g}", trial.sample_rate), trial.is_certified, sql::number(trial.certified_ns),
      sql::number(counts.expected), sql::number(counts.received), sql::number(counts.resent),
      sql::number(counts.duplicated), sql::number(counts.missing));
  if (trial.is_certified)
    transaction.exec_params("DELETE FROM trial_tallies WHERE trial_id = $1", sql::bytes(trial.trial));
}

void write_tally(pqxx::transaction_base& transaction, const TrialTally& tally) {
  transaction.exec_params(
      "INSERT INTO trial_tallies VALUES ($1, $2, $3) ON CONFLICT (trial_id) DO UPDATE SET "
      "resent_samples = excluded.resent_samples, duplicated_samples = excluded.duplicated_samples",
      sql::bytes(tally.trial), sql::number(tally.resent), sql::number(tally.duplicated));
}

void write_certificate(pqxx::transaction_base& transaction, const SessionCertificate& certificate) {
  const Certificate& sums = certificate.sums;
  transaction.exec_params("DELETE FROM session_certificates WHERE session_id = $1",
                          sql::bytes(certificate.session));
  transaction.exec_params(
      "INSERT INTO session_certificates VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9, $10, $11)",
      sql::bytes(certificate.session), sql::bytes(certificate.rig), certificate.end, certificate.trials,
      certificate.incomplete_trials, sql::number(sums.expected), sql::number(sums.received),
      sql::number(sums.resent), sql::number(sums.duplicated), sql::number(sums.missing),
      sql::number(certificate.certified_ns));
}

}  // namespace

Result<void> PostgresStore::commit(const Batch& batch) {
  if (!link_->is_for_writing())
    return link_->error(ErrorCode::kInternal, "is open for reading only: nothing can be committed");
  for (const Block& block : batch.blocks) {
    const bool is_there = std::any_of(batch.streams.begin(), batch.streams.end(),
                                      [&block](const auto& stream) { return stream.key == block.stream; });
    if (!is_there) return link_->error(ErrorCode::kInternal, "a block's stream is not in its batch");
  }
  return link_->run([&batch](pqxx::transaction_base& transaction) {
    const StreamNumbers numbers = write_streams(transaction, batch);
    write_blocks(transaction, batch, numbers);
    write_messages(transaction, batch);
    for (const SessionRecord& session : batch.sessions) write_session(transaction, session);
    for (const TrialTally& tally : batch.tallies) write_tally(transaction, tally);
    for (const TrialRecord& trial : batch.trials) write_trial(transaction, trial);
    for (const SessionCertificate& certificate : batch.certificates)
      write_certificate(transaction, certificate);
  });
}

}  // namespace tonus::store
