#include "services/exchange/recovery.hpp"

#include <algorithm>
#include <map>
#include <spdlog/fmt/fmt.h>

#include "idl/bounds.hpp"
#include "idl/topics.hpp"
#include "services/archive/block_header.hpp"
#include "services/archive/open_store.hpp"
#include "services/archive/wire.hpp"
#include "services/bus/typed.hpp"
#include "services/core/crc32c.hpp"
#include "services/exchange/sqlite_pages.hpp"

namespace tonus::exchange {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kBlockColumns = 10;
constexpr std::size_t kMessageColumns = 7;
constexpr std::size_t kTrialColumns = 21;
constexpr std::size_t kStreamColumns = 6;
constexpr std::size_t kRowsACommit = 128;

const std::vector<std::byte>* octets(const SqliteRow& row, std::size_t column, std::size_t size = 0) {
  const auto* value = std::get_if<std::vector<std::byte>>(&row.values[column]);
  return value != nullptr && (size == 0 || value->size() == size) ? value : nullptr;
}

std::optional<Id> id_at(const SqliteRow& row, std::size_t column) {
  const auto* bytes = octets(row, column, sizeof(Id));
  if (bytes == nullptr) return {};
  Id id;
  std::transform(bytes->begin(), bytes->end(), id.begin(),
                 [](std::byte b) { return std::to_integer<std::uint8_t>(b); });
  return id;
}

std::optional<std::uint64_t> whole_at(const SqliteRow& row, std::size_t column) {
  const auto* value = std::get_if<std::int64_t>(&row.values[column]);
  if (value == nullptr) return {};
  return static_cast<std::uint64_t>(*value);
}

bool begins_with_key(const SqliteRow& row) { return std::holds_alternative<std::monostate>(row.values[0]); }

/// A row of `blocks`; its checksum is not checked yet.
bool is_block(const SqliteRow& row) {
  return row.values.size() == kBlockColumns && begins_with_key(row) && whole_at(row, 2) && whole_at(row, 3) &&
         id_at(row, 4) && id_at(row, 5) && whole_at(row, 6) && whole_at(row, 7) && whole_at(row, 8) &&
         octets(row, 9) != nullptr;
}

bool is_message(const SqliteRow& row) {
  return row.values.size() == kMessageColumns && begins_with_key(row) &&
         std::holds_alternative<std::string>(row.values[1]) && id_at(row, 2) && id_at(row, 3) &&
         whole_at(row, 4) && whole_at(row, 5) && octets(row, 6) != nullptr;
}

/// None where its content is not what its checksum was made of, or not samples.
std::optional<archive::Block> block_of(const SqliteRow& row) {
  const auto* payload = octets(row, 9);
  if (crc32c(*payload) != *whole_at(row, 8)) return {};
  const auto wire = bus::decode<v1::SampleBlock>(*payload);
  if (!wire) return {};
  auto block = archive::read_block_header(*payload);
  if (!block) return {};
  block->session = *id_at(row, 4);
  block->trial = *id_at(row, 5);
  block->is_resent = *whole_at(row, 6) != 0;
  block->received_ns = *whole_at(row, 7);
  block->checksum = static_cast<std::uint32_t>(*whole_at(row, 8));
  block->payload = std::make_shared<const std::vector<std::byte>>(*payload);
  return std::move(*block);
}

std::optional<archive::Message> message_of(const SqliteRow& row) {
  const auto* payload = octets(row, 6);
  if (crc32c(*payload) != *whole_at(row, 5)) return {};
  return archive::Message{std::get<std::string>(row.values[1]),
                          *id_at(row, 2),
                          *id_at(row, 3),
                          *whole_at(row, 4),
                          static_cast<std::uint32_t>(*whole_at(row, 5)),
                          std::make_shared<const std::vector<std::byte>>(*payload)};
}

/// The places of the rows that are whole, by number.
struct Found {
  std::map<std::int64_t, SqliteCell> blocks;
  std::map<std::int64_t, SqliteCell> messages;
  std::map<std::int64_t, std::string> damaged_messages;  // by number: topic and key
  std::int64_t last_block = 0;
  std::int64_t last_message = 0;
  std::map<Id, archive::TrialRecord> trials;                    // counts that only the table has
  std::map<archive::StreamKey, archive::StreamRecord> streams;  // likewise

  [[nodiscard]] std::size_t rows() const { return blocks.size() + messages.size(); }
};

void take_trial(const SqliteRow& row, Found& found) {
  const auto id = id_at(row, 0);
  if (!id) return;
  archive::TrialRecord trial;
  trial.certified_ns = whole_at(row, 15).value_or(0);
  trial.certificate.resent = whole_at(row, 18).value_or(0);
  trial.certificate.duplicated = whole_at(row, 19).value_or(0);
  found.trials[*id] = trial;
}

void take_stream(const SqliteRow& row, Found& found) {
  const auto rig = id_at(row, 1);
  const auto epoch = whole_at(row, 2);
  if (!rig || !epoch || !begins_with_key(row)) return;
  archive::StreamRecord stream;
  stream.key = {*rig, *epoch};
  stream.origin = whole_at(row, 3).value_or(0);
  stream.resent = whole_at(row, 4).value_or(0);
  stream.duplicated = whole_at(row, 5).value_or(0);
  found.streams[stream.key] = stream;
}

Result<Found> find_rows(SqlitePages& pages, const Progress& progress) {
  Found found;
  const auto visited = pages.visit_rows(
      [&](const SqliteRow& row, const SqliteCell& cell) {
        if (is_block(row)) {
          found.last_block = std::max(found.last_block, row.rowid);
          if (block_of(row)) found.blocks.emplace(row.rowid, cell);
        } else if (is_message(row)) {
          found.last_message = std::max(found.last_message, row.rowid);
          if (message_of(row)) {
            found.messages.emplace(row.rowid, cell);
          } else {
            found.damaged_messages[row.rowid] =
                fmt::format("{}, key {}", std::get<std::string>(row.values[1]), to_hex(*id_at(row, 2)));
          }
        } else if (row.values.size() == kTrialColumns) {
          take_trial(row, found);
        } else if (row.values.size() == kStreamColumns) {
          take_stream(row, found);
        }
      },
      progress);
  if (!visited) return visited.error();
  return found;
}

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
  Rebuilder(SqlitePages& pages, const Found& found, archive::Store& store, const Progress& progress)
      : pages_(pages), found_(found), store_(store), progress_(progress) {}

  Result<void> copy(Recovery& recovery) {
    for (const auto& [number, cell] : found_.messages) {
      const auto row = pages_.read(cell);
      auto message = row && is_message(*row) ? message_of(*row) : std::nullopt;
      if (!message) continue;
      note(*message);
      batch_.messages.push_back(std::move(*message));
      ++recovery.messages;
      if (auto done = commit_if_full(); !done) return done;
    }
    for (const auto& [number, cell] : found_.blocks) {
      const auto row = pages_.read(cell);
      auto block = row && is_block(*row) ? block_of(*row) : std::nullopt;
      if (!block) continue;
      coverage_[block->stream].add(block->range());
      batch_.blocks.push_back(std::move(*block));
      ++recovery.blocks;
      if (auto done = commit_if_full(); !done) return done;
    }
    return finish(recovery);
  }

 private:
  void note(const archive::Message& message) {
    if (message.topic == topics::kSessionPlan.spec.name) {
      if (const auto wire = bus::decode<v1::SessionPlan>(*message.payload))
        sessions_[wire->session_id()] = archive::to_record(*wire);
    } else if (message.topic == topics::kTrialOutcome.spec.name) {
      const auto wire = bus::decode<v1::TrialOutcome>(*message.payload);
      if (!wire) return;
      auto record = archive::to_record(*wire);
      if (!record) return;
      record->certified_ns = message.received_ns;
      if (record->has_samples) note_frontier(record->stream, record->range().end);
      trials_[record->trial] = std::move(*record);
    } else if (message.topic == topics::kRigState.spec.name) {
      const auto wire = bus::decode<v1::RigState>(*message.payload);
      if (wire && wire->next_sequence() < (std::uint64_t{1} << 62U))
        note_frontier({wire->rig_id(), wire->epoch()}, wire->next_sequence());
    } else if (message.topic == topics::kSessionState.spec.name) {
      const auto wire = bus::decode<v1::SessionState>(*message.payload);
      if (wire && archive::has_ended(wire->phase())) ends_[wire->session_id()] = wire->phase();
    }
  }

  void note_frontier(const archive::StreamKey& stream, std::uint64_t end) {
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
    for (const auto& [key, coverage] : coverage_) {
      archive::StreamRecord stream;
      if (const auto known = found_.streams.find(key); known != found_.streams.end()) stream = known->second;
      stream.key = key;
      stream.coverage = coverage;
      batch_.streams.push_back(stream);
    }
  }

  void list_lost_samples(Recovery& recovery) const {
    for (const auto& stream : batch_.streams) {
      const auto frontier = frontiers_.find(stream.key);
      const std::uint64_t end =
          std::max(stream.coverage.end(), frontier == frontiers_.end() ? 0 : frontier->second);
      if (stream.origin >= end) continue;
      for (const auto& range : stream.coverage.missing({stream.origin, end}))
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
      counts.received = trial.has_samples ? coverage_[trial.stream].count_in(trial.range()) : 0;
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
      archive::SessionCertificate certificate;
      certificate.session = session;
      certificate.end = end;
      for (const auto& trial : batch_.trials) {
        if (trial.session != session) continue;
        ++certificate.trials;
        certificate.incomplete_trials += trial.is_certified ? 0 : 1;
        certificate.rig = trial.stream.rig;
        certificate.sums.expected += trial.certificate.expected;
        certificate.sums.received += trial.certificate.received;
        certificate.sums.resent += trial.certificate.resent;
        certificate.sums.duplicated += trial.certificate.duplicated;
        certificate.sums.missing += trial.certificate.missing;
        certificate.certified_ns = std::max(certificate.certified_ns, trial.certified_ns);
      }
      batch_.certificates.push_back(certificate);
    }
  }

  Result<void> finish(Recovery& recovery) {
    for (const auto& [key, end] : frontiers_) coverage_[key];
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
  const Found& found_;
  archive::Store& store_;
  const Progress& progress_;
  archive::Batch batch_;
  std::uint64_t done_ = 0;
  std::map<Id, archive::SessionRecord> sessions_;
  std::map<Id, archive::TrialRecord> trials_;
  std::map<Id, std::uint32_t> ends_;
  std::map<archive::StreamKey, archive::Coverage> coverage_;
  std::map<archive::StreamKey, std::uint64_t> frontiers_;
};

/// The page size that shows rows, where the header's own does not.
Result<std::pair<SqlitePages, Found>> look(const fs::path& damaged, const Progress& progress) {
  std::optional<std::pair<SqlitePages, Found>> best;
  for (const std::uint32_t size : {0U, 4096U, 1024U, 8192U, 2048U, 16384U, 32768U, 65536U, 512U}) {
    auto pages = SqlitePages::open(damaged, size == 0 ? std::nullopt : std::optional(size));
    if (!pages) return pages.error();
    auto found = find_rows(*pages, progress);
    if (!found) return found.error();
    const bool is_better = !best || found->rows() > best->second.rows();
    if (is_better) best.emplace(std::move(*pages), std::move(*found));
    if (best->second.rows() > 0) break;
  }
  return std::move(*best);
}

}  // namespace

Result<Recovery> recover_archive(const fs::path& damaged, const fs::path& target, const Progress& progress) {
  std::error_code ignored;
  if (fs::exists(target, ignored)) {
    return fail(ErrorCode::kAlreadyExists,
                fmt::format("'{}': is there already: a path that does not exist is needed", target.string()));
  }
  auto looked = look(damaged, progress);
  if (!looked) return looked.error();
  auto& [pages, found] = *looked;
  if (found.rows() == 0) {
    return fail(ErrorCode::kDataLoss,
                fmt::format("'{}': holds no block and no message of an archive of tonus", damaged.string()));
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
  auto store = archive::open_store_for_writing(target.string());
  if (!store) return store.error();
  if (auto copied = Rebuilder(pages, found, **store, progress).copy(recovery); !copied) {
    store->reset();
    for (const char* suffix : {"", "-wal", "-shm"}) fs::remove(target.string() + suffix, ignored);
    return copied.error();
  }
  return recovery;
}

}  // namespace tonus::exchange
