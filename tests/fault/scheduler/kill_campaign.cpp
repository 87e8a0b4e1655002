#include "tests/fault/scheduler/kill_campaign.hpp"

#include <algorithm>
#include <chrono>
#include <csignal>
#include <map>
#include <random>
#include <set>
#include <spdlog/fmt/fmt.h>
#include <thread>

#include "services/scheduler/journal.hpp"
#include "services/scheduler/ledger.hpp"
#include "services/store/open_store.hpp"
#include "services/store/session_reader.hpp"
#include "tests/support/process.hpp"
#include "tests/support/temporary_folder.hpp"

#include <idl/idl_hash.hpp>

namespace tonus::testing {
namespace {

using namespace std::chrono_literals;

constexpr double kLongestDelay = 1.2;  // s after the session's start or the last kill; a session takes 1.4 s.
constexpr auto kLimit = 240s;

/// A trial by its attempt: its place in the plan.
using Trials = std::map<std::uint32_t, std::uint32_t>;

Error wrong(const std::string& what) { return {ErrorCode::kInternal, what}; }

/// Kills the scheduler below `system` at moments of its own; how often, and the first delay.
KilledSession kill_schedulers(Process& system, std::uint64_t seed) {
  std::mt19937_64 draw(seed);
  std::uniform_real_distribution<double> delay(0.0, kLongestDelay);
  KilledSession report;
  const auto wanted = std::uniform_int_distribution<unsigned>(1, 3)(draw);
  for (unsigned i = 0; i < wanted; ++i) {
    const double wait = delay(draw);
    if (i == 0) report.first_kill_s = wait;
    // The moment is the point of this test, so it is waited for.
    std::this_thread::sleep_for(std::chrono::duration<double>(wait));
    const pid_t victim = child_named(system.id(), "tonus-scheduler");
    if (victim != 0 && kill(victim, SIGKILL) == 0) ++report.kills;
  }
  return report;
}

Result<Trials> counted_in_journal(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> finished;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().extension() == ".finished") finished.push_back(entry.path());
    if (entry.path().extension() == ".journal") return wrong("a journal was not put away");
  }
  if (finished.size() != 1) return wrong(fmt::format("{} finished journals, expected 1", finished.size()));
  auto storage = FileStorage::open(finished.front(), FileStorage::Mode::kOpen);
  if (!storage) return storage.error();
  auto opened = scheduler::Journal::open(std::move(*storage), v1::kIdlHash);
  if (!opened) return opened.error();

  scheduler::Ledger ledger;
  Trials commanded;
  Trials counted;
  for (const scheduler::Record& record : opened->records) {
    if (auto applied = ledger.apply(record); !applied) return applied.error();
    if (const auto* command = std::get_if<scheduler::record::Commanded>(&record))
      commanded[command->program.attempt()] = command->program.planned_index();
    if (const auto* count = std::get_if<scheduler::record::Counted>(&record)) {
      if (!counted.emplace(count->attempt, commanded.at(count->attempt)).second)
        return wrong(fmt::format("journal: trial {} counted twice", count->attempt));
    }
  }
  const auto& ended = ledger.state().ended;
  if (!ended || ended->phase != v1::SESSION_COMPLETED) return wrong("journal: the session is not completed");
  return counted;
}

Result<Trials> valid_in_archive(const std::filesystem::path& file) {
  auto store = store::open_store_for_reading(file.string());
  if (!store) return store.error();
  const auto record = store::find_session(**store, "last");
  if (!record) return record.error();
  const auto session = store::read_session(**store, record->session);
  if (!session) return session.error();
  Trials valid;
  for (const auto& trial : session->trials) {
    if (!trial.verdict || !trial.verdict->value.is_valid()) continue;
    valid[trial.attempt] = trial.verdict->value.planned_index();
    if (!trial.record || !trial.record->is_certified || trial.record->certificate.missing != 0)
      return wrong(fmt::format("archive: valid trial {} has no whole certificate", trial.attempt));
  }
  return valid;
}

Result<void> expect_each_planned_once(const Trials& trials, std::size_t planned, const char* where) {
  std::set<std::uint32_t> places;
  for (const auto& [attempt, place] : trials) places.insert(place);
  if (trials.size() == planned && places.size() == planned && *places.rbegin() == planned - 1) return {};
  return wrong(fmt::format("{}: {} trials at {} places of the plan, expected {} at {}", where, trials.size(),
                           places.size(), planned, planned));
}

Result<void> check(const std::filesystem::path& data, std::size_t planned) {
  const auto counted = counted_in_journal(data / "sessions");
  if (!counted) return counted.error();
  const auto valid = valid_in_archive(data / "archive.sqlite");
  if (!valid) return valid.error();
  if (auto good = expect_each_planned_once(*counted, planned, "journal"); !good) return good;
  for (const auto& [attempt, place] : *counted) {
    if (!valid->contains(attempt))
      return wrong(fmt::format("trial {} of {} counts in the journal and has no valid verdict in the archive",
                               attempt, counted->rbegin()->first));
  }
  if (auto good = expect_each_planned_once(*valid, planned, "archive"); !good) return good;
  return {};
}

}  // namespace

Result<KilledSession> run_killed_session(const std::filesystem::path& protocol, std::uint64_t seed) {
  constexpr std::size_t kPlanned = 80;  // of deploy/protocols/unloaded.toml
  TemporaryFolder folder;
  const auto data = folder / "data";
  Process system(program("tonus"),
                 {"demo", protocol.string(), "--domain", std::to_string(own_domain()), "--data",
                  data.string(), "--seed", std::to_string(seed), "--rig-seed", std::to_string(seed)},
                 folder / "output");
  if (!system.wait_for_output("session ", kLimit))
    return wrong("the session did not start: " + system.output());
  const KilledSession report = kill_schedulers(system, seed);
  const int code = system.wait(kLimit);
  if (code != 0) return wrong(fmt::format("exit code {}: {}", code, system.output()));
  if (auto good = check(data, kPlanned); !good) return good.error();
  return report;
}

}  // namespace tonus::testing
