#pragma once

#include <memory>
#include <string>
#include <vector>

#include "services/store/store.hpp"

namespace tonus::store {

class PostgresLink;

/// A study in the schema `tonus` of a PostgreSQL database, for laboratories that keep their data on a server.
/// Tables and their versions are those of SqliteStore. Commits are acknowledged when the server has them on
/// its disk (synchronous_commit = on; a server with fsync = off is refused).
///
/// A connection that is lost is made anew by the next call, so a server may be restarted at any time: what
/// was not committed is refused with kIo and may be committed again. Every call waits for the server for 2 s
/// at most while it does not answer.
class PostgresStore final : public Store {
 public:
  enum class Access : std::uint8_t { kRead, kWrite };

  /// `url` as libpq takes it: postgresql://USER@HOST:PORT/DATABASE?PARAMETERS. A password belongs into the
  /// file ~/.pgpass or the environment (PGPASSWORD); one in the URL works and is never shown. kWrite makes
  /// the tables where they are missing and brings older ones up to date; one program at a time. kIo: the
  /// server cannot be reached or refuses. kInvalidArgument: a URL that is none, a server without fsync, a
  /// newer schema. kNotFound: to read, and there is no archive in the database. kUnavailable: another archive
  /// writes it.
  [[nodiscard]] static Result<std::unique_ptr<PostgresStore>> open(const std::string& url, Access access);
  ~PostgresStore() override;

  [[nodiscard]] Result<void> commit(const Batch& batch) override;
  [[nodiscard]] Result<std::vector<StreamRecord>> streams() override;
  [[nodiscard]] Result<std::vector<SessionRecord>> sessions() override;
  [[nodiscard]] Result<std::vector<TrialRecord>> trials(const Id& session) override;
  [[nodiscard]] Result<std::optional<TrialRecord>> find_trial(const Id& trial) override;
  [[nodiscard]] Result<std::vector<TrialRecord>> uncertified_trials() override;
  [[nodiscard]] Result<std::vector<TrialTally>> tallies() override;
  [[nodiscard]] Result<std::vector<SessionCertificate>> session_certificates() override;
  [[nodiscard]] Result<std::vector<MessageDigest>> newest_messages() override;
  [[nodiscard]] Result<void> visit_blocks(const BlockQuery& query, const BlockVisitor& visit) override;
  [[nodiscard]] Result<void> visit_messages(const MessageQuery& query, const MessageVisitor& visit) override;
  [[nodiscard]] Result<StoreSpace> space() override;
  [[nodiscard]] std::string name() const override;

 private:
  explicit PostgresStore(std::unique_ptr<PostgresLink> link);

  std::unique_ptr<PostgresLink> link_;
};

}  // namespace tonus::store
