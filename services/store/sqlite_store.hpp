#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "services/store/sqlite.hpp"
#include "services/store/store.hpp"
#include "services/store/store_lock.hpp"

namespace tonus::store {

/// A study in one SQLite file: write-ahead log, every commit synced (synchronous = FULL), tables versioned.
/// May be read by other programs, of any make, while it is written.
///
/// While it is written, a mark in the file (user_version) says that the newest is in the log beside it
/// (-wal): a file that was copied without its log is refused, and not taken for an old or an empty archive.
/// An orderly end takes the mark away and leaves one file, which is read without a lock and without the right
/// to write. After a crash the log remains; then only the file's owner, who may write beside it, reads it, as
/// a log's index that belongs to another user would keep the owner out.
class SqliteStore final : public Store {
 public:
  enum class Access : std::uint8_t { kRead, kWrite };

  /// kWrite makes the file where it is missing (not its folder) and brings older tables up to date; one
  /// program at a time. A file that was not there before is removed again if it cannot be used. kNotFound: no
  /// such file or folder. kInvalidArgument: a folder, another program's file, or a newer schema. kIo: no
  /// permission, read-only, disk. kUnavailable: another archive writes it. kDataLoss: damaged.
  [[nodiscard]] static Result<std::unique_ptr<SqliteStore>> open(const std::string& path, Access access);
  ~SqliteStore() override;

  /// What opening the file for writing would change in its tables, a step each ("2: certificates of
  /// sessions"); empty: nothing, or there is no such file. Changes nothing. Errors as open().
  [[nodiscard]] static Result<std::vector<std::string>> pending_upgrade(const std::string& path);

  /// Copies the whole archive, as it is at this moment, to a new file that is there whole or not at all, is
  /// synced, and rests: one file that is read without the right to write. Its archive may write meanwhile and
  /// waits for nothing. `progress` is told pages done and in all. kAlreadyExists: `target` exists. kDataLoss:
  /// the copy does not hang together, so the archive itself is damaged. kIo: the disk.
  [[nodiscard]] Result<void> copy_to(const std::string& target,
                                     const std::function<void(std::uint64_t, std::uint64_t)>& progress);

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
  [[nodiscard]] std::string name() const override { return database_.path(); }

 private:
  [[nodiscard]] Result<void> copy_pages(Database& copy,
                                        const std::function<void(std::uint64_t, std::uint64_t)>& progress);
  struct FileIdentity {
    std::uint64_t device = 0;
    std::uint64_t inode = 0;
    bool operator==(const FileIdentity&) const = default;
  };
  /// What a commit needs, prepared once: places in `writing_`.
  enum Write : std::uint8_t {
    kInsertBlock,
    kInsertMessage,
    kPutSession,
    kPutStream,
    kDropCoverage,
    kPutCoverage,
    kDropAuxiliaryCoverage,
    kPutAuxiliaryCoverage,
    kPutTrial,
    kPutTally,
    kDropTally,
    kPutCertificate,
  };

  SqliteStore(std::optional<StoreLock> lock, Database database);
  [[nodiscard]] Result<void> begin_writing(bool is_new);
  [[nodiscard]] Result<void> check_resting() const;
  [[nodiscard]] static Result<std::unique_ptr<SqliteStore>> open_for_writing(const std::string& path);
  [[nodiscard]] static Result<std::unique_ptr<SqliteStore>> open_for_reading(const std::string& path);
  [[nodiscard]] static std::optional<FileIdentity> identify(const std::string& path);
  [[nodiscard]] Result<void> prepare_writing();
  [[nodiscard]] Result<void> check_file() const;
  [[nodiscard]] Result<void> write(const Batch& batch);
  [[nodiscard]] Result<void> write_block(const Block& block);
  [[nodiscard]] Result<void> write_message(const Message& message);
  [[nodiscard]] Result<void> write_session(const SessionRecord& session);
  [[nodiscard]] Result<void> write_stream(const StreamRecord& stream);
  [[nodiscard]] Result<void> write_coverage(Write drop, Write put, std::int64_t stream,
                                            const Coverage& coverage);
  [[nodiscard]] static Result<Coverage> read_coverage(Database& database, Statement& ranges,
                                                      std::int64_t stream);
  [[nodiscard]] Result<void> write_trial(const TrialRecord& trial);
  [[nodiscard]] Result<void> write_tally(const TrialTally& tally);
  [[nodiscard]] Result<void> write_certificate(const SessionCertificate& certificate);
  [[nodiscard]] Result<std::int64_t> stream_number(const StreamKey& key);
  [[nodiscard]] Result<std::vector<TrialRecord>> read_trials(Statement& statement);

  std::optional<StoreLock> lock_;  ///< Goes after the connection that it protects.
  Database database_;
  std::optional<FileIdentity> identity_;
  std::optional<std::filesystem::file_time_type> rests_since_;  ///< Where it is read as a resting file.
  std::vector<Statement> writing_;                              ///< Empty where the store is only read.
  std::optional<Statement> find_trial_;                         ///< Asked for each outcome.
  std::map<StreamKey, std::int64_t> stream_numbers_;
};

}  // namespace tonus::store
