#include <array>

#include "services/store/sqlite_store.hpp"

namespace tonus::store {
namespace {

// In the order of SqliteStore::Write.
constexpr std::array kWriteSql{
    "INSERT INTO blocks (stream, first_sequence, sample_count, session_id, trial_id, is_resent, received_ns, "
    "crc32c, "
    "payload, is_auxiliary) VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?)",
    "INSERT INTO messages (topic, key, session_id, received_ns, crc32c, payload) VALUES (?, ?, ?, ?, ?, ?)",
    "INSERT OR REPLACE INTO sessions VALUES (?, ?, ?, ?, ?, ?, ?, ?)",
    "INSERT INTO streams (rig_id, epoch, origin_sequence, resent_samples, duplicated_samples, "
    "auxiliary_values) VALUES (?, ?, ?, ?, ?, ?) "
    "ON CONFLICT (rig_id, epoch) DO UPDATE SET origin_sequence = excluded.origin_sequence, "
    "resent_samples = excluded.resent_samples, duplicated_samples = excluded.duplicated_samples, "
    "auxiliary_values = excluded.auxiliary_values RETURNING stream",
    "DELETE FROM coverage WHERE stream = ?",
    "INSERT INTO coverage VALUES (?, ?, ?)",
    "DELETE FROM auxiliary_coverage WHERE stream = ?",
    "INSERT INTO auxiliary_coverage VALUES (?, ?, ?)",
    "INSERT OR REPLACE INTO trials VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)",
    "INSERT OR REPLACE INTO trial_tallies VALUES (?, ?, ?)",
    "DELETE FROM trial_tallies WHERE trial_id = ?",
    "INSERT OR REPLACE INTO session_certificates VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)",
};

}  // namespace

Result<void> SqliteStore::prepare_writing() {
  for (const char* sql : kWriteSql) {
    TONUS_TRY_ASSIGN(auto statement, Statement::prepare(database_, sql));
    writing_.push_back(std::move(statement));
  }
  return {};
}

Result<void> SqliteStore::commit(const Batch& batch) {
  if (writing_.empty()) {
    return fail(ErrorCode::kInternal,
                "store '" + name() + "': is open for reading only: nothing can be committed");
  }
  TONUS_TRY(check_file());
  TONUS_TRY(database_.run("BEGIN IMMEDIATE"));
  auto written = write(batch);
  if (written) written = database_.run("COMMIT");
  if (!written) {
    // What failed may have rolled back already; streams that this transaction made are gone with it.
    if (database_.is_in_transaction()) static_cast<void>(database_.run("ROLLBACK"));
    stream_numbers_.clear();
  }
  return written;
}

Result<void> SqliteStore::write(const Batch& batch) {
  // Streams first: the blocks name them.
  for (const StreamRecord& stream : batch.streams) {
    TONUS_TRY(write_stream(stream));
  }
  for (const Block& block : batch.blocks) {
    TONUS_TRY(write_block(block));
  }
  for (const Message& message : batch.messages) {
    TONUS_TRY(write_message(message));
  }
  for (const SessionRecord& session : batch.sessions) {
    TONUS_TRY(write_session(session));
  }
  for (const TrialTally& tally : batch.tallies) {
    TONUS_TRY(write_tally(tally));
  }
  for (const TrialRecord& trial : batch.trials) {
    TONUS_TRY(write_trial(trial));
  }
  for (const SessionCertificate& certificate : batch.certificates) {
    TONUS_TRY(write_certificate(certificate));
  }
  return {};
}

Result<void> SqliteStore::write_stream(const StreamRecord& stream) {
  Statement& put = writing_[kPutStream];
  put.bind(0, stream.key.rig).bind(1, stream.key.epoch).bind(2, stream.origin);
  put.bind(3, stream.resent).bind(4, stream.duplicated).bind(5, stream.auxiliary_values);
  const auto has_number = put.step(database_);
  const std::int64_t number = has_number && *has_number ? put.integer(0) : 0;
  put.reset();
  if (!has_number) return has_number.error();
  stream_numbers_[stream.key] = number;
  TONUS_TRY(write_coverage(kDropCoverage, kPutCoverage, number, stream.coverage));
  return write_coverage(kDropAuxiliaryCoverage, kPutAuxiliaryCoverage, number, stream.auxiliary_coverage);
}

Result<void> SqliteStore::write_coverage(Write drop, Write put, std::int64_t stream,
                                         const Coverage& coverage) {
  TONUS_TRY(writing_[drop].bind(0, stream).run(database_));
  for (const SequenceRange& range : coverage.ranges()) {
    auto done = writing_[put].bind(0, stream).bind(1, range.first).bind(2, range.end - 1).run(database_);
    if (!done) return done;
  }
  return {};
}

Result<std::int64_t> SqliteStore::stream_number(const StreamKey& key) {
  const auto known = stream_numbers_.find(key);
  if (known != stream_numbers_.end()) return known->second;
  return fail(ErrorCode::kInternal, "store '" + name() + "': a block's stream is not in its batch");
}

Result<void> SqliteStore::write_block(const Block& block) {
  TONUS_TRY_ASSIGN(const auto number, stream_number(block.stream));
  Statement& insert = writing_[kInsertBlock];
  insert.bind(0, number).bind(1, block.first_sequence).bind(2, block.count).bind(3, block.session);
  insert.bind(4, block.trial).bind(5, block.is_resent).bind(6, block.received_ns).bind(7, block.checksum);
  return insert.bind(8, std::span(*block.payload)).bind(9, block.is_auxiliary).run(database_);
}

Result<void> SqliteStore::write_message(const Message& message) {
  Statement& insert = writing_[kInsertMessage];
  insert.bind(0, message.topic).bind(1, message.key).bind(2, message.session).bind(3, message.received_ns);
  return insert.bind(4, message.checksum).bind(5, std::span(*message.payload)).run(database_);
}

Result<void> SqliteStore::write_session(const SessionRecord& session) {
  Statement& put = writing_[kPutSession];
  put.bind(0, session.session).bind(1, session.rig).bind(2, session.subject).bind(3, session.protocol_name);
  put.bind(4, session.seed).bind(5, session.planned_trials).bind(6, session.started_at);
  return put.bind(7, session.software_version).run(database_);
}

Result<void> SqliteStore::write_trial(const TrialRecord& trial) {
  Statement& put = writing_[kPutTrial];
  put.bind(0, trial.trial).bind(1, trial.session).bind(2, trial.stream.rig).bind(3, trial.stream.epoch);
  put.bind(4, trial.attempt).bind(5, trial.planned_index).bind(6, trial.posture).bind(7, trial.set);
  put.bind(8, trial.end)
      .bind(9, trial.has_samples)
      .bind(10, trial.first_sequence)
      .bind(11, trial.onset_sequence);
  put.bind(12, trial.last_sequence).bind(13, trial.sample_rate).bind(14, trial.is_certified);
  put.bind(15, trial.certified_ns).bind(16, trial.certificate.expected).bind(17, trial.certificate.received);
  put.bind(18, trial.certificate.resent)
      .bind(19, trial.certificate.duplicated)
      .bind(20, trial.certificate.missing);
  if (auto done = put.run(database_); !done || !trial.is_certified) return done;
  return writing_[kDropTally].bind(0, trial.trial).run(database_);
}

Result<void> SqliteStore::write_tally(const TrialTally& tally) {
  return writing_[kPutTally]
      .bind(0, tally.trial)
      .bind(1, tally.resent)
      .bind(2, tally.duplicated)
      .run(database_);
}

Result<void> SqliteStore::write_certificate(const SessionCertificate& certificate) {
  Statement& put = writing_[kPutCertificate];
  put.bind(0, certificate.session).bind(1, certificate.rig).bind(2, certificate.end);
  put.bind(3, certificate.trials).bind(4, certificate.incomplete_trials);
  put.bind(5, certificate.sums.expected).bind(6, certificate.sums.received).bind(7, certificate.sums.resent);
  put.bind(8, certificate.sums.duplicated).bind(9, certificate.sums.missing);
  return put.bind(10, certificate.certified_ns).run(database_);
}

}  // namespace tonus::store
