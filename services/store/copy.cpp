#include "services/store/copy.hpp"

#include <algorithm>
#include <filesystem>
#include <set>
#include <spdlog/fmt/fmt.h>
#include <tuple>

#include "services/store/session_reader.hpp"
#include "services/store/sqlite_store.hpp"
#include "services/store/store_file.hpp"
#include "services/store/store_lock.hpp"

namespace tonus::store {
namespace {

namespace fs = std::filesystem;

/// Bytes of payload that become durable in one step.
constexpr std::size_t kBatchBytes = std::size_t{16} << 20U;

bool contains(const std::vector<Id>& ids, const Id& id) {
  return std::find(ids.begin(), ids.end(), id) != ids.end();
}

/// A stored message, told from all others.
using MessageIdentity = std::tuple<std::string, Id, std::uint64_t, std::uint32_t>;

MessageIdentity identity_of(const Message& message) {
  return {message.topic, message.key, message.received_ns, message.checksum};
}

class Copy {
 public:
  Copy(Store& from, Store& to, const CopySelection& selection, const Progress& progress)
      : from_(from), to_(to), selection_(selection), progress_(progress) {}

  Result<CopyCount> run() {
    TONUS_TRY(check_empty());
    TONUS_TRY(read_records());
    TONUS_TRY(note_what_was_in_force());
    TONUS_TRY(copy_blocks());
    TONUS_TRY(copy_messages());
    TONUS_TRY(to_.commit(last_));
    return count_;
  }

 private:
  bool takes(const Id& session) const {
    if (!selection_.only.empty() && !contains(selection_.only, session)) return false;
    return !contains(selection_.without, session);
  }

  Result<void> check_empty() {
    TONUS_TRY_ASSIGN(const auto streams, to_.streams());
    TONUS_TRY_ASSIGN(const auto sessions, to_.sessions());
    TONUS_TRY_ASSIGN(const auto messages, to_.newest_messages());
    if (streams.empty() && sessions.empty() && messages.empty()) return {};
    return fail(ErrorCode::kAlreadyExists, fmt::format("store '{}': holds {} sessions; expected an empty one",
                                                       to_.name(), sessions.size()));
  }

  /// Before any block is read: so what is certified or covered here is among the blocks that follow.
  Result<void> read_records() {
    TONUS_TRY_ASSIGN(streams_, from_.streams());
    TONUS_TRY_ASSIGN(const auto certificates, from_.session_certificates());
    for (const SessionCertificate& certificate : certificates)
      if (takes(certificate.session)) last_.certificates.push_back(certificate);
    TONUS_TRY_ASSIGN(const auto sessions, from_.sessions());
    for (const SessionRecord& session : sessions) {
      if (!takes(session.session)) continue;
      last_.sessions.push_back(session);
      TONUS_TRY_ASSIGN(const auto trials, from_.trials(session.session));
      last_.trials.insert(last_.trials.end(), trials.begin(), trials.end());
    }
    std::set<Id> tallied;
    for (const TrialRecord& trial : last_.trials)
      if (!trial.is_certified) tallied.insert(trial.trial);
    TONUS_TRY_ASSIGN(const auto tallies, from_.tallies());
    for (const TrialTally& tally : tallies)
      if (tallied.contains(tally.trial)) last_.tallies.push_back(tally);
    count_.sessions = last_.sessions.size();
    count_.trials = last_.trials.size();
    for (const TrialRecord& trial : last_.trials) samples_of_trials_ += trial.certificate.received;
    return {};
  }

  /// Messages of other sessions that say what held when a session that is copied began: its rig, its
  /// services.
  Result<void> note_what_was_in_force() {
    if (selection_.only.empty() && selection_.without.empty()) return {};
    for (const SessionRecord& session : last_.sessions) {
      for (const std::string_view topic : kSurroundingTopics) {
        const MessageQuery query{std::string(topic), {}, {}, false, session.session};
        TONUS_TRY(from_.visit_messages(query, [this](const Message& message) {
          in_force_.insert(identity_of(message));
          return Result<void>();
        }));
      }
    }
    return {};
  }

  Result<void> flush_if(bool is_due) {
    if (!is_due) return {};
    TONUS_TRY(to_.commit(batch_));
    batch_ = {};
    batch_bytes_ = 0;
    if (progress_) progress_(std::min(count_.samples, samples_of_trials_), samples_of_trials_);
    return {};
  }

  Result<void> copy_blocks() {
    for (const StreamRecord& stream : streams_) {
      StreamRecord bare = stream;
      bare.coverage = {};
      Coverage copied;
      const BlockQuery all{stream.key, {0, kLargestSequence}};
      TONUS_TRY(from_.visit_blocks(all, [&](const Block& block) -> Result<void> {
        if (!takes(block.session)) return {};
        if (batch_.streams.empty()) batch_.streams.push_back(bare);
        copied.add(block.range());
        ++count_.blocks;
        count_.samples += block.count;
        batch_bytes_ += block.payload->size();
        batch_.blocks.push_back(block);
        return flush_if(batch_bytes_ >= kBatchBytes);
      }));
      TONUS_TRY(flush_if(!batch_.blocks.empty()));
      keep_stream(stream, copied);
    }
    return {};
  }

  void keep_stream(const StreamRecord& stream, const Coverage& copied) {
    if (selection_.only.empty()) {
      last_.streams.push_back(stream);
    } else if (!copied.ranges().empty()) {
      StreamRecord part = stream;
      part.coverage = copied;
      last_.streams.push_back(part);
    }
  }

  Result<void> copy_messages() {
    TONUS_TRY(from_.visit_messages({}, [this](const Message& message) -> Result<void> {
      if (!takes(message.session) && !in_force_.contains(identity_of(message))) return {};
      ++count_.messages;
      batch_bytes_ += message.payload->size();
      batch_.messages.push_back(message);
      return flush_if(batch_bytes_ >= kBatchBytes);
    }));
    return flush_if(!batch_.messages.empty());
  }

  Store& from_;
  Store& to_;
  const CopySelection& selection_;
  const Progress& progress_;
  std::vector<StreamRecord> streams_;
  std::set<MessageIdentity> in_force_;
  Batch batch_;
  std::size_t batch_bytes_ = 0;
  std::uint64_t samples_of_trials_ = 0;  ///< What there is to copy, but for some outside of trials.
  Batch last_;  ///< Records, coverage and certificates: true only when all else is there.
  CopyCount count_;
};

}  // namespace

Result<CopyCount> copy_store(Store& from, Store& to, const CopySelection& selection,
                             const Progress& progress) {
  return Copy(from, to, selection, progress).run();
}

namespace {

/// Every payload once more, as it is on the disk.
Result<void> check_all(Store& store, const CopyCount& expected) {
  CopyCount found;
  TONUS_TRY_ASSIGN(const auto streams, store.streams());
  for (const StreamRecord& stream : streams) {
    TONUS_TRY(store.visit_blocks({stream.key, {0, kLargestSequence}}, [&found](const Block&) {
      ++found.blocks;
      return Result<void>();
    }));
  }
  TONUS_TRY(store.visit_messages({}, [&found](const Message&) {
    ++found.messages;
    return Result<void>();
  }));
  if (found.blocks == expected.blocks && found.messages == expected.messages) return {};
  return fail(ErrorCode::kDataLoss,
              fmt::format("store '{}': holds {} blocks and {} messages; expected {} and {}", store.name(),
                          found.blocks, found.messages, expected.blocks, expected.messages));
}

}  // namespace

Result<CopyCount> copy_to_sqlite(Store& from, const std::string& path, const CopySelection& selection,
                                 const Progress& progress) {
  CopyCount count;
  TONUS_TRY(make_store_file(path, [&](const std::string& partial) -> Result<void> {
    {
      TONUS_TRY_ASSIGN(const auto to, SqliteStore::open(partial, SqliteStore::Access::kWrite));
      TONUS_TRY_ASSIGN(count, copy_store(from, *to, selection, progress));
    }  // closed, it rests in one file
    TONUS_TRY_ASSIGN(const auto made, SqliteStore::open(partial, SqliteStore::Access::kRead));
    return check_all(*made, count);
  }));
  return count;
}

namespace {

bool has_log(const std::string& path) {
  std::error_code error;
  return fs::file_size(path + "-wal", error) > 0 && !error;
}

/// What a crash left in the log goes into the file, so that one file is all there is.
Result<void> empty_log(const std::string& path) {
  if (has_log(path)) TONUS_TRY(SqliteStore::open(path, SqliteStore::Access::kWrite));
  return {};
}

}  // namespace

Result<CopyCount> prune_sqlite(const std::string& path, const std::vector<Id>& sessions,
                               const Progress& progress) {
  TONUS_TRY(SqliteStore::open(path, SqliteStore::Access::kRead));
  TONUS_TRY(empty_log(path));
  TONUS_TRY_ASSIGN(const auto lock, StoreLock::take(path));
  if (has_log(path))
    return fail(ErrorCode::kUnavailable, fmt::format("store '{}': was written meanwhile", path));
  const std::string pruned = path + ".pruned";
  std::error_code error;
  fs::remove(pruned, error);  // of a run that was killed
  TONUS_TRY_ASSIGN(const auto count, [&]() -> Result<CopyCount> {
    TONUS_TRY_ASSIGN(const auto from, SqliteStore::open(path, SqliteStore::Access::kRead));
    return copy_to_sqlite(*from, pruned, {.only = {}, .without = sessions}, progress);
  }());
  for (const char* suffix : {"-wal", "-shm"}) fs::remove(path + suffix, error);  // empty, and of the old file
  TONUS_TRY(replace_store_file(path, pruned));
  return count;
}

}  // namespace tonus::store
