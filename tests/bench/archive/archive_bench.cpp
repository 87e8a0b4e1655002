// How fast the archive makes samples durable, beside bare SQLite that inserts the same bytes as blobs and
// commits as often, with the same settings, on the same disk. The two take turns.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <spdlog/fmt/fmt.h>
#include <sqlite3.h>
#include <stdexcept>
#include <vector>

#include "idl/topics.hpp"
#include "services/archive/ingest.hpp"
#include "services/archive/wire.hpp"
#include "services/store/sqlite.hpp"
#include "services/store/sqlite_store.hpp"
#include "tests/fault/archive/made_up_rig.hpp"
#include "tests/support/temporary_folder.hpp"

namespace tonus::archive {
namespace {

using Seconds = std::chrono::duration<double>;
using testing::MadeUpRig;

constexpr double kRigRate = 4000.0;  // Hz

double now() { return Seconds(std::chrono::steady_clock::now().time_since_epoch()).count(); }

template <typename T>
T good(Result<T> result) {
  if (!result) throw std::runtime_error(result.error().message);
  return std::move(*result);
}
void good(const Result<void>& result) {
  if (!result) throw std::runtime_error(result.error().message);
}

/// A trial as it comes from the bus.
struct WireTrial {
  std::vector<bus::Sample> blocks;
  bus::Sample outcome;
};

template <typename T>
bus::Sample sample_of(const T& value) {
  bus::Sample sample;
  sample.payload = std::make_shared<const bus::Payload>(good(bus::encode(value)));
  std::copy_n(reinterpret_cast<const std::uint8_t*>(sample.payload->data()) + 4, sample.key.size(),
              sample.key.begin());
  return sample;
}

std::vector<WireTrial> make_trials(int count, std::uint32_t block_samples) {
  MadeUpRig rig(1);
  std::vector<WireTrial> trials;
  for (int i = 0; i < count; ++i) {
    const auto trial = rig.next_trial();
    WireTrial wire;
    for (std::uint64_t first = trial.range.first; first < trial.range.end; first += block_samples)
      wire.blocks.push_back(sample_of(rig.block(first, block_samples, false)));
    wire.outcome = sample_of(rig.outcome(trial));
    trials.push_back(std::move(wire));
  }
  return trials;
}

/// From the bus's bytes to the receipt: decoding, checksum, rules, commit.
class ArchiveSide {
 public:
  explicit ArchiveSide(const std::string& path)
      : store_(good(store::SqliteStore::open(path, store::SqliteStore::Access::kWrite))),
        ingest_(*store_, clock_) {
    good(ingest_.recover());
  }

  double take(const std::vector<WireTrial>& trials, std::size_t first, std::size_t end,
              std::size_t trials_a_commit) {
    const double start = now();
    for (std::size_t i = first; i < end; i += trials_a_commit) {
      for (std::size_t k = i; k < i + trials_a_commit; ++k) {
        for (const auto& block : trials[k].blocks) good(feed(ingest_, topics::kRigSamples.spec, block, 1));
        good(feed(ingest_, topics::kTrialOutcome.spec, trials[k].outcome, 1));
      }
      if (ingest_.step().trial_receipts.size() != trials_a_commit)
        throw std::runtime_error("a trial got no receipt");
    }
    return now() - start;
  }

 private:
  SystemClock clock_;
  std::unique_ptr<store::SqliteStore> store_;
  Ingest ingest_;
};

/// The yardstick: a table of numbered blobs.
class BareSide {
 public:
  explicit BareSide(const std::string& path)
      : database_(good(store::Database::open(path, store::Database::Mode::kReadWrite))), insert_([this] {
          good(database_.text("PRAGMA journal_mode = WAL"));
          good(
              database_.run("PRAGMA synchronous = FULL; "
                            "CREATE TABLE blobs (blob INTEGER PRIMARY KEY, payload BLOB NOT NULL)"));
          return good(store::Statement::prepare(database_, "INSERT INTO blobs (payload) VALUES (?)"));
        }()) {}

  double take(const std::vector<WireTrial>& trials, std::size_t first, std::size_t end,
              std::size_t trials_a_commit) {
    const double start = now();
    for (std::size_t i = first; i < end; i += trials_a_commit) {
      good(database_.run("BEGIN IMMEDIATE"));
      for (std::size_t k = i; k < i + trials_a_commit; ++k) {
        for (const auto& block : trials[k].blocks) put(block);
        put(trials[k].outcome);
      }
      good(database_.run("COMMIT"));
    }
    return now() - start;
  }

 private:
  void put(const bus::Sample& sample) {
    good(insert_.bind(0, std::span<const std::byte>(*sample.payload)).run(database_));
  }

  store::Database database_;
  store::Statement insert_;
};

void measure(std::uint32_t block_samples, std::size_t trials_a_commit, int rounds, int commits) {
  const int trials_a_round = commits * static_cast<int>(trials_a_commit);
  const tonus::testing::TemporaryFolder folder;
  const auto trials = make_trials(rounds * trials_a_round, block_samples);
  ArchiveSide archive(folder / "archive.sqlite");
  BareSide bare(folder / "bare.sqlite");
  std::vector<double> ratios;
  double archive_seconds = 0.0;
  double bare_seconds = 0.0;
  for (int round = 0; round < rounds; ++round) {
    const auto first = static_cast<std::size_t>(round * trials_a_round);
    const auto end = first + static_cast<std::size_t>(trials_a_round);
    const double bare_round = bare.take(trials, first, end, trials_a_commit);
    const double archive_round = archive.take(trials, first, end, trials_a_commit);
    ratios.push_back(bare_round / archive_round);
    bare_seconds += bare_round;
    archive_seconds += archive_round;
  }
  std::sort(ratios.begin(), ratios.end());
  const double all_commits = static_cast<double>(rounds) * commits;
  const double samples = all_commits * static_cast<double>(trials_a_commit * MadeUpRig::kTrialSamples);
  fmt::print("{:8} {:6} {:8.2f} {:8.2f} {:10.0f} {:10.0f} {:7.2f} {:5.2f}-{:4.2f} {:8.0f}\n",
             trials_a_commit * MadeUpRig::kTrialSamples, block_samples, 1e3 * archive_seconds / all_commits,
             1e3 * bare_seconds / all_commits, samples / archive_seconds, samples / bare_seconds,
             ratios[ratios.size() / 2], ratios.front(), ratios.back(), samples / archive_seconds / kRigRate);
}

}  // namespace
}  // namespace tonus::archive

int main(int argc, char** argv) {
  CLI::App app("The archive's durable ingest beside bare SQLite.", "archive_bench");
  int rounds = 61;
  int commits = 5;
  app.add_option("--rounds", rounds, "turns of each side")->check(CLI::PositiveNumber)->capture_default_str();
  app.add_option("--commits", commits, "in a turn")->check(CLI::PositiveNumber)->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  fmt::print(
      "share: rate of the archive over that of bare SQLite, median and range of {} turns; at least 0.7 is "
      "wanted, "
      "and\n100 times a rig of 4 kHz with trials of 7 s (28000 samples)\n"
      "samples samples       ms a commit        samples/s             share      times a\n"
      "a commit a block  archive    bare    archive       bare  median   range  4 kHz rig\n",
      rounds);
  try {
    for (const std::uint32_t block_samples : {20U, 100U, 250U})
      tonus::archive::measure(block_samples, 1, rounds, commits);
    tonus::archive::measure(100, 20, rounds, std::max(1, commits / 5));
  } catch (const std::exception& error) {
    fmt::print(stderr, "archive_bench: {}\n", error.what());
    return 1;
  }
  return 0;
}
