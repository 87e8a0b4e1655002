#include <algorithm>
#include <stdexcept>

#include "services/archive/ingest.hpp"
#include "services/store/sample_reader.hpp"
#include "services/store/sqlite.hpp"
#include "services/store/sqlite_store.hpp"
#include "tests/fuzz/target.hpp"

namespace tonus::fuzz {
namespace {

using store::Store;

/// No more of a damaged stream's range is asked for at once.
constexpr std::uint64_t kMostSamples = 10'000;

class StoreTarget final : public Target {
 public:
  explicit StoreTarget(const std::filesystem::path& folder) : path_((folder / "damaged.sqlite").string()) {
    const std::string whole = (folder / "whole.sqlite").string();
    if (auto made = make_store(whole); !made) throw std::runtime_error(made.error().message);
    whole_ = read_bytes(whole);
  }

  [[nodiscard]] std::string name() const override { return "stores"; }

  Result<bool> run(Damage& damage) override {
    for (const char* suffix : {"-wal", "-shm", "-journal"}) std::filesystem::remove(path_ + suffix);
    Bytes bytes = whole_;
    const bool is_made_up = damage.draw(0, 2) == 0;
    if (!is_made_up) damage.apply(bytes);
    write_bytes(path_, bytes);
    if (is_made_up) write_nonsense(damage);
    bool is_refused = false;
    for (const auto access : {store::SqliteStore::Access::kRead, store::SqliteStore::Access::kWrite}) {
      auto store = store::SqliteStore::open(path_, access);
      auto used =
          store ? use(**store, access == store::SqliteStore::Access::kWrite) : Result<void>(store.error());
      if (used) continue;
      is_refused = true;
      if (auto good = check_message(used.error().message); !good) return good.error();
    }
    return is_refused;
  }

 private:
  /// A sound file whose cells hold what no archive writes.
  void write_nonsense(Damage& damage) const {
    auto database = store::Database::open(path_, store::Database::Mode::kReadWrite);
    if (!database) return;
    static const std::vector<std::string> kColumns{"streams.epoch",
                                                   "streams.origin_sequence",
                                                   "streams.rig_id",
                                                   "coverage.first_sequence",
                                                   "coverage.last_sequence",
                                                   "blocks.first_sequence",
                                                   "blocks.sample_count",
                                                   "blocks.payload",
                                                   "blocks.crc32c",
                                                   "blocks.stream",
                                                   "messages.topic",
                                                   "messages.payload",
                                                   "messages.key",
                                                   "trials.first_sequence",
                                                   "trials.last_sequence",
                                                   "trials.epoch",
                                                   "trials.is_certified",
                                                   "trials.has_samples",
                                                   "trials.attempt",
                                                   "sessions.started_at",
                                                   "sessions.session_id",
                                                   "trials.sample_rate_Hz",
                                                   "schema_migrations.version",
                                                   "trials.expected_samples"};
    static const std::vector<std::string> kValues{
        "-1",      "0",     "9223372036854775807", "-9223372036854775808", "'text'", "x''",
        "x'00ff'", "1e300", "zeroblob(70000)"};
    for (auto times = damage.draw(1, 3); times > 0; --times) {
      const std::string& column = kColumns[damage.draw(0, kColumns.size() - 1)];
      const auto dot = column.find('.');
      const std::string statement = "UPDATE OR IGNORE " + column.substr(0, dot) + " SET " +
                                    column.substr(dot + 1) + " = " +
                                    kValues[damage.draw(0, kValues.size() - 1)] + " WHERE rowid % 3 < " +
                                    std::to_string(damage.draw(1, 3));
      static_cast<void>(database->run(statement.c_str()));
    }
  }

  /// Reads everything; then, to write, what an archive does that is started on it.
  static Result<void> use(Store& store, bool is_to_write) {
    const auto streams = store.streams();
    if (!streams) return streams.error();
    for (const auto& stream : *streams) {
      for (const auto& range : stream.coverage.ranges()) {
        const std::uint64_t end = std::min(range.end, range.first + kMostSamples);
        if (auto samples = store::read_samples(store, stream.key, {range.first, end}); !samples)
          return samples.error();
      }
    }
    auto visited = store.visit_messages({}, [](const auto&) -> Result<void> { return {}; });
    if (!visited) return visited;
    const auto sessions = store.sessions();
    if (!sessions) return sessions.error();
    for (const auto& session : *sessions) {
      if (auto trials = store.trials(session.session); !trials) return trials.error();
    }
    if (auto certificates = store.session_certificates(); !certificates) return certificates.error();
    return is_to_write ? go_on(store) : Result<void>();
  }

  static Result<void> go_on(Store& store) {
    ManualClock clock;
    archive::Ingest ingest(store, clock);
    if (auto recovered = ingest.recover(); !recovered) return recovered;
    for (int i = 0; i < 4; ++i) {
      clock.advance(std::chrono::seconds(4));
      static_cast<void>(ingest.step());
      static_cast<void>(ingest.status());
    }
    return ingest.finish();
  }

  std::string path_;
  Bytes whole_;
};

}  // namespace

std::unique_ptr<Target> make_store_target(const std::filesystem::path& folder) {
  return std::make_unique<StoreTarget>(folder);
}

}  // namespace tonus::fuzz
