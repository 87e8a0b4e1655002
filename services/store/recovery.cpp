#include "services/store/recovery.hpp"

#include <algorithm>
#include <map>
#include <spdlog/fmt/fmt.h>

#include "idl/topics.hpp"
#include "services/contract/names.hpp"
#include "services/core/folder.hpp"
#include "services/store/block_header.hpp"
#include "services/store/open_store.hpp"
#include "services/store/recovered_rows.hpp"
#include "services/store/sqlite_pages.hpp"
#include "services/store/stored_message.hpp"
#include "services/store/wire.hpp"

namespace tonus::store {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kRowsACommit = 128;

/// Numbers 1 to `last` that are not there. A number beyond all sense is damage of its own.
std::vector<RowRange> gaps(const std::map<std::int64_t, SqliteCell>& rows, std::int64_t last) {
  std::vector<RowRange> all;
  std::int64_t next = 1;
  for (const auto& [number, cell] : rows) {
    if (number > next) all.push_back({next, number - 1});
    next = number + 1;
  }
  if (last >= next) all.push_back({next, last});
  return all;
}

/// Copies rows to the new archive and makes its other tables from them.
class Rebuilder {
 public:
  Rebuilder(SqlitePages& pages, const RecoveredRows& found, Store& store, const Progress& progress)
      : pages_(pages), found_(found), store_(store), progress_(progress) {}

  Result<void> copy(Recovery& recovery) {
    for (const auto& [number, cell] : found_.messages) {
      auto message = read_message(pages_, cell);
      if (!message) continue;
      note(*message);
      batch_.messages.push_back(std::move(*message));
      ++recovery.messages;
      TONUS_TRY(commit_if_full());
    }
    for (const auto& [number, cell] : found_.blocks) {
      auto block = read_block(pages_, cell);
      if (!block) continue;
      note(*block);
      batch_.blocks.push_back(std::move(*block));
      ++recovery.blocks;
      TONUS_TRY(commit_if_full());
    }
    return finish(recovery);
  }

 private:
  void note(const Message& message) {
    if (message.topic == topics::kSessionPlan.spec.name) {
      if (const auto wire = decode_stored<v1::SessionPlan>(*message.payload))
        sessions_[wire->session_id()] = to_record(*wire);
    } else if (message.topic == topics::kTrialOutcome.spec.name) {
      const auto wire = decode_stored<v1::TrialOutcome>(*message.payload);
      if (!wire) return;
      auto record = to_record(*wire);
      if (!record) return;
      record->certified_ns = message.received_ns;
      if (record->has_samples) note_frontier(record->stream, record->range().end);
      trials_[record->trial] = std::move(*record);
    } else if (message.topic == topics::kRigState.spec.name) {
      const auto wire = decode_stored<v1::RigState>(*message.payload);
      if (wire && wire->next_sequence() <= kLargestSequence)
        note_frontier({wire->rig_id(), wire->epoch()}, wire->next_sequence());
    } else if (message.topic == topics::kSessionState.spec.name) {
      const auto wire = decode_stored<v1::SessionState>(*message.payload);
      if (wire && v1::is_over(wire->phase())) ends_[wire->session_id()] = wire->phase();
    }
  }

  void note(const Block& block) {
    StreamRecord& stream = stream_of(block.stream);
    (block.is_auxiliary ? stream.auxiliary_coverage : stream.coverage).add(block.range());
    if (!block.is_auxiliary || stream.auxiliary_values != 0) return;
    if (const auto header = read_auxiliary_header(*block.payload))
      stream.auxiliary_values = header->values_per_sample;
  }

  /// What only the table has comes from there, where it is left.
  StreamRecord& stream_of(const StreamKey& key) {
    const auto [place, is_new] = streams_.try_emplace(key);
    if (!is_new) return place->second;
    if (const auto known = found_.streams.find(key); known != found_.streams.end())
      place->second = known->second;
    place->second.key = key;
    return place->second;
  }

  void note_frontier(const StreamKey& stream, std::uint64_t end) {
    auto& frontier = frontiers_[stream];
    frontier = std::max(frontier, end);
  }

  Result<void> commit_if_full() {
    if (batch_.blocks.size() + batch_.messages.size() < kRowsACommit) return {};
    done_ += batch_.blocks.size() + batch_.messages.size();
    if (progress_) progress_(done_, found_.rows());
    add_streams();
    auto committed = store_.commit(batch_);
    batch_ = {};
    return committed;
  }

  /// As far as they are known by now.
  void add_streams() {
    for (const auto& [key, stream] : streams_) batch_.streams.push_back(stream);
  }

  void list_lost_samples(Recovery& recovery) const {
    for (const auto& stream : batch_.streams) {
      const auto frontier = frontiers_.find(stream.key);
      const std::uint64_t end =
          std::max(stream.coverage.end(), frontier == frontiers_.end() ? 0 : frontier->second);
      if (stream.origin >= end) continue;
      for (const auto& range : stream.whole().missing({stream.origin, end}))
        recovery.lost_samples.push_back({stream.key, range});
    }
  }

  void add_trials(Recovery& recovery) {
    for (auto& [id, trial] : trials_) {
      if (const auto known = found_.trials.find(id); known != found_.trials.end()) {
        trial.certificate = known->second.certificate;
        if (known->second.certified_ns != 0) trial.certified_ns = known->second.certified_ns;
      }
      auto& counts = trial.certificate;
      counts.expected = trial.range().count();
      counts.received = trial.has_samples ? stream_of(trial.stream).whole().count_in(trial.range()) : 0;
      counts.missing = counts.expected - counts.received;
      trial.is_certified = counts.missing == 0;
      if (!trial.is_certified) {
        trial.certified_ns = 0;
        recovery.incomplete_trials.push_back(fmt::format("session {}, trial {}: {} of {} samples missing",
                                                         to_hex(trial.session), trial.attempt, counts.missing,
                                                         counts.expected));
      }
      batch_.trials.push_back(trial);
    }
  }

  void add_certificates() {
    for (const auto& [session, end] : ends_) {
      SessionCertificate certificate;
      certificate.session = session;
      certificate.end = end;
      for (const auto& trial : batch_.trials) {
        if (trial.session != session) continue;
        certificate.add(trial);
        certificate.certified_ns = std::max(certificate.certified_ns, trial.certified_ns);
      }
      batch_.certificates.push_back(certificate);
    }
  }

  Result<void> finish(Recovery& recovery) {
    for (const auto& [key, end] : frontiers_) (void)stream_of(key);
    add_streams();
    list_lost_samples(recovery);
    add_trials(recovery);
    add_certificates();
    for (const auto& [id, session] : sessions_) batch_.sessions.push_back(session);
    recovery.sessions = sessions_.size();
    recovery.trials = trials_.size();
    if (progress_) progress_(found_.rows(), found_.rows());
    return store_.commit(batch_);
  }

  SqlitePages& pages_;
  const RecoveredRows& found_;
  Store& store_;
  const Progress& progress_;
  Batch batch_;
  std::uint64_t done_ = 0;
  std::map<Id, SessionRecord> sessions_;
  std::map<Id, TrialRecord> trials_;
  std::map<Id, std::uint32_t> ends_;
  std::map<StreamKey, StreamRecord> streams_;
  std::map<StreamKey, std::uint64_t> frontiers_;
};

/// The page size that shows rows, where the header's own does not.
Result<std::pair<SqlitePages, RecoveredRows>> look(const fs::path& damaged, const Progress& progress) {
  std::optional<std::pair<SqlitePages, RecoveredRows>> best;
  for (const std::uint32_t size : {0U, 4096U, 1024U, 8192U, 2048U, 16384U, 32768U, 65536U, 512U}) {
    TONUS_TRY_ASSIGN(auto pages, SqlitePages::open(damaged, size == 0 ? std::nullopt : std::optional(size)));
    TONUS_TRY_ASSIGN(auto found, find_rows(pages, progress));
    const bool is_better = !best || found.rows() > best->second.rows();
    if (is_better) best.emplace(std::move(pages), std::move(found));
    if (best->second.rows() > 0) break;
  }
  return std::move(*best);
}

}  // namespace

Result<Recovery> recover_archive(const fs::path& damaged, const fs::path& target, const Progress& progress) {
  std::error_code ignored;
  TONUS_TRY_ASSIGN(const bool is_there, is_present(target));
  if (is_there) {
    return fail(ErrorCode::kAlreadyExists,
                fmt::format("'{}': already exists; use a new path", target.string()));
  }
  TONUS_TRY_ASSIGN(auto looked, look(damaged, progress));
  auto& [pages, found] = looked;
  if (found.rows() == 0) {
    return fail(
        ErrorCode::kDataLoss,
        fmt::format("'{}': not an archive of tonus: no block and no message found", damaged.string()));
  }
  Recovery recovery;
  recovery.pages = pages.pages();
  recovery.pages_expected = pages.pages_in_header();
  recovery.pages_from_log = pages.pages_from_log();
  recovery.has_header = pages.has_header();
  recovery.unreadable_rows = pages.bad_cells();
  recovery.lost_blocks = gaps(found.blocks, found.last_block);
  recovery.lost_messages = gaps(found.messages, found.last_message);
  for (const auto& [number, what] : found.damaged_messages) {
    if (!found.messages.contains(number)) recovery.damaged_messages.push_back(what);
  }
  TONUS_TRY_ASSIGN(auto store, open_store_for_writing(target.string()));
  if (auto copied = Rebuilder(pages, found, *store, progress).copy(recovery); !copied) {
    store.reset();
    for (const char* suffix : {"", "-wal", "-shm"}) fs::remove(target.string() + suffix, ignored);
    return copied.error();
  }
  return recovery;
}

}  // namespace tonus::store
