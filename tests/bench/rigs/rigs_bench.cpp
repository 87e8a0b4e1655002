// Many rigs at 200 Hz into one identification service and one archive: is every estimate on time, is anything
// dropped, and how much of a core does it take, beside a program that only takes the blocks and answers them.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <spdlog/fmt/fmt.h>
#include <sstream>
#include <unistd.h>

#include "idl/topics.hpp"
#include "services/core/name.hpp"
#include "services/runtime/drain.hpp"
#include "tests/bench/bench_bus.hpp"
#include "tests/bench/rigs/bare_reader.hpp"
#include "tests/bench/rigs/simulated_rigs.hpp"
#include "tests/support/process.hpp"
#include "tests/support/temporary_folder.hpp"

namespace tonus::bench {
namespace {

constexpr char kLab[] = "lab";  // what the archive calls its rig: all of them also send there
constexpr std::chrono::seconds kReadyWithin{180};
constexpr std::chrono::seconds kAnsweredWithin{30};

struct Asked {
  std::string dds = "fastdds";
  int rigs = 64;
  std::uint32_t trials = 4;
  bool is_json = false;
  bool is_bare = false;
  int domain = 0;
};

std::vector<std::string> names_of(int rigs) {
  std::vector<std::string> names;
  for (int i = 1; i <= rigs; ++i) names.push_back(fmt::format("rig{:02}", i));
  return names;
}

/// Processor time of a process, s.
double processor_time(pid_t process) {
  std::ifstream file(fmt::format("/proc/{}/stat", process));
  std::string text((std::istreambuf_iterator<char>(file)), {});
  std::istringstream rest(text.substr(std::min(text.size(), text.rfind(')') + 1)));
  std::string word;
  double ticks = 0.0;
  for (int field = 3; rest >> word && field <= 15; ++field) {
    if (field >= 14) ticks += std::stod(word);
  }
  return ticks / static_cast<double>(sysconf(_SC_CLK_TCK));
}

double at(std::vector<double>& values, double share) {
  if (values.empty()) return std::nan("");
  const auto place =
      std::min(values.size() - 1, static_cast<std::size_t>(share * static_cast<double>(values.size())));
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(place), values.end());
  return values[place];
}

/// A child process and the processor time that it took since begin().
class Measured {
 public:
  Measured(const std::filesystem::path& program, const std::vector<std::string>& words,
           const std::filesystem::path& output)
      : process_(program, words, output) {}
  void begin() { before_ = processor_time(process_.id()); }
  void end() { taken_ = processor_time(process_.id()) - before_; }
  [[nodiscard]] double taken() const { return taken_; }

 private:
  testing::Process process_;
  double before_ = 0.0;
  double taken_ = 0.0;
};

/// What comes back from the services.
class Answers {
 public:
  Answers(bus::Bus& of_rigs, bus::Bus& of_lab, bus::Bus& of_bare,
          std::vector<std::unique_ptr<SimulatedRig>>& rigs, const std::shared_ptr<bus::Notifier>& notifier)
      : live_(reader(of_rigs, topics::kEstimateLive, notifier)),
        estimates_(reader(of_rigs, topics::kEstimateCondition, notifier)),
        verdicts_(reader(of_rigs, topics::kTrialVerdict, notifier)),
        healths_(reader(of_rigs, topics::kServiceHealth, notifier)),
        receipts_(reader(of_lab, topics::kArchiveReceipt, notifier)),
        lab_healths_(reader(of_lab, topics::kServiceHealth, notifier)),
        bare_(std::move(*of_bare.create_reader(answer_topic(), notifier))) {
    for (auto& rig : rigs) {
      by_session_[rig->session()] = rig.get();
      by_rig_[rig_id(rig->name())] = rig.get();
    }
  }

  void take() {
    for (const auto& each : runtime::drain(live_)) note_live(each);
    for (const auto& each : runtime::drain(verdicts_))
      note(each.value.session_id(), each.value.attempt(), each.sample.received_ns, judged_, verdict_ms);
    for (const auto& each : runtime::drain(estimates_))
      note(each.value.session_id(), each.value.trials_used(), each.sample.received_ns, estimated_,
           estimate_ms);
    for (const auto& each : runtime::drain(receipts_)) {
      if (each.value.kind() != v1::RECEIPT_TRIAL) continue;
      (each.value.missing_samples() == 0 ? stored_ : incomplete_).insert(each.value.subject_id());
    }
    for (const auto& each : runtime::drain(healths_)) note_health(each.value);
    for (const auto& each : runtime::drain(lab_healths_)) note_health(each.value);
    take_bare();
  }

  [[nodiscard]] std::size_t ready() const { return ready_.size(); }
  [[nodiscard]] std::size_t judged() const { return judged_.size(); }
  [[nodiscard]] std::size_t estimated() const { return estimated_.size(); }
  [[nodiscard]] std::size_t stored() const { return stored_.size(); }
  [[nodiscard]] std::uint64_t dropped() const { return dropped_; }

  std::vector<double> live_ms;
  std::vector<double> bare_ms;
  std::vector<double> verdict_ms;
  std::vector<double> estimate_ms;

 private:
  using Trials = std::set<std::pair<Id, std::uint32_t>>;

  template <typename T>
  static bus::TypedReader<T> reader(bus::Bus& bus, const bus::Topic<T>& topic,
                                    const std::shared_ptr<bus::Notifier>& notifier) {
    return bus::TypedReader<T>::create(bus, topic, notifier).value();
  }

  static double ms_between(Time begin, std::int64_t end_ns) {
    return static_cast<double>(end_ns - begin.time_since_epoch().count()) * 1e-6;
  }

  void note_live(const bus::Received<v1::Estimate>& each) {
    const auto rig = by_session_.find(each.value.session_id());
    if (rig == by_session_.end() || each.value.trials().empty()) return;
    if (const Time* sent = rig->second->sent(each.value.trials().back().last_sequence()))
      live_ms.push_back(ms_between(*sent, each.sample.received_ns));
  }

  void note(const Id& session, std::uint32_t attempt, std::int64_t received_ns, Trials& known,
            std::vector<double>& times) {
    const auto rig = by_session_.find(session);
    if (rig == by_session_.end() || attempt == 0 || attempt > rig->second->reported()) return;
    if (known.emplace(session, attempt).second)
      times.push_back(ms_between(rig->second->outcome_sent(attempt), received_ns));
  }

  void note_health(const v1::ServiceHealth& health) {
    if (health.role() == v1::ROLE_RIG) return;
    dropped_ = std::max<std::uint64_t>(dropped_, health.dropped());
    if (health.is_ready()) ready_.insert(health.instance_id());
  }

  void take_bare() {
    samples_.clear();
    while (bare_->take(samples_, 512) == 512) {
    }
    for (const bus::Sample& sample : samples_) {
      Id rig;
      std::copy(sample.key.begin(), sample.key.end(), rig.begin());
      std::uint64_t first = 0;
      std::memcpy(&first, sample.payload->data() + kNumberAt, sizeof first);
      const auto found = by_rig_.find(rig);
      if (found == by_rig_.end()) continue;
      if (const Time* sent = found->second->sent(first))
        bare_ms.push_back(ms_between(*sent, sample.received_ns));
    }
  }

  bus::TypedReader<v1::Estimate> live_;
  bus::TypedReader<v1::Estimate> estimates_;
  bus::TypedReader<v1::TrialVerdict> verdicts_;
  bus::TypedReader<v1::ServiceHealth> healths_;
  bus::TypedReader<v1::ArchiveReceipt> receipts_;
  bus::TypedReader<v1::ServiceHealth> lab_healths_;
  std::unique_ptr<bus::Reader> bare_;
  std::vector<bus::Sample> samples_;
  std::map<Id, SimulatedRig*> by_session_;
  std::map<Id, SimulatedRig*> by_rig_;
  Trials judged_;
  Trials estimated_;
  std::set<Id> stored_;
  std::set<Id> incomplete_;
  std::set<Id> ready_;
  std::uint64_t dropped_ = 0;
};

using Rigs = std::vector<std::unique_ptr<SimulatedRig>>;

/// Every rig's next block when it is due, their times spread over a block's, until all are done; answers are
/// taken meanwhile. Returns by how much the latest block was late, ms: the load generator's own fault.
double run_rigs(Rigs& rigs, Answers& answers, bus::Notifier& notifier) {
  const Time begin = std::chrono::steady_clock::now();
  const auto due_of = [&](std::size_t i) -> Time {
    const auto part =
        std::chrono::nanoseconds(kBlockTime) * static_cast<int>(i) / static_cast<int>(rigs.size());
    return begin + part + kBlockTime * static_cast<std::int64_t>(rigs[i]->blocks());
  };
  Time health_due = begin;
  double latest = 0.0;
  while (true) {
    Time next = Time::max();
    for (std::size_t i = 0; i < rigs.size(); ++i) {
      if (rigs[i]->is_done()) continue;
      const Time now = std::chrono::steady_clock::now();
      if (due_of(i) <= now) {
        latest = std::max(latest, std::chrono::duration<double, std::milli>(now - due_of(i)).count());
        rigs[i]->send_block();
      }
      if (!rigs[i]->is_done()) next = std::min(next, due_of(i));
    }
    if (next == Time::max()) return latest;
    if (std::chrono::steady_clock::now() >= health_due) {
      for (auto& rig : rigs) rig->report_health();
      health_due = std::chrono::steady_clock::now() + std::chrono::milliseconds(250);
    }
    answers.take();
    (void)notifier.wait_until(next);
  }
}

/// Takes answers and reports health until `is_so`; false when `limit` is over.
template <typename Condition>
bool wait_for(Rigs& rigs, Answers& answers, bus::Notifier& notifier, std::chrono::seconds limit,
              Condition is_so) {
  const Time end = std::chrono::steady_clock::now() + limit;
  while (!is_so()) {
    if (std::chrono::steady_clock::now() > end) return false;
    for (auto& rig : rigs) rig->report_health();
    answers.take();
    (void)notifier.wait_until(std::chrono::steady_clock::now() + std::chrono::milliseconds(50));
  }
  return true;
}

nlohmann::json known(double value) { return std::isnan(value) ? nlohmann::json() : nlohmann::json(value); }

nlohmann::json spread(std::vector<double>& values) {
  return {{"count", values.size()},
          {"p50_ms", known(at(values, 0.5))},
          {"p99_ms", known(at(values, 0.99))},
          {"p99.9_ms", known(at(values, 0.999))}};
}

Result<nlohmann::json> measure(const Asked& asked) {
  const testing::TemporaryFolder folder;
  const auto names = names_of(asked.rigs);
  const std::vector<std::string> common{
      "--dds",    asked.dds, "--domain", std::to_string(asked.domain), "--data", folder.path().string(),
      "--config", "none"};
  const auto with = [&](std::vector<std::string> words) {
    words.insert(words.end(), common.begin(), common.end());
    return words;
  };
  Measured identification(testing::program("tonus-identification"),
                          with({"--rigs", fmt::format("{}", fmt::join(names, ","))}), folder / "said-i");
  Measured archive(testing::program("tonus-archive"), with({"--rig", kLab}), folder / "said-a");
  Measured bare("/proc/self/exe",
                {"--bare", "--dds", asked.dds, "--domain", std::to_string(asked.domain), "--rigs",
                 std::to_string(asked.rigs)},
                folder / "said-b");
  std::vector<bus::Partitions> places;
  for (const std::string& name : names) places.push_back({name, kLab});
  places.insert(places.end(), {names, {kLab}, {kAnswers}});
  TONUS_TRY_ASSIGN(const auto buses,
                   bus::create_buses(bench::bus_options(asked.dds, asked.domain, "rigs"), places));
  const SystemClock clock;
  const auto notifier = std::make_shared<bus::Notifier>();
  Rigs rigs;
  for (std::size_t i = 0; i < names.size(); ++i)
    rigs.push_back(std::make_unique<SimulatedRig>(*buses[i], clock, names[i], asked.dds, asked.trials));
  Answers answers(*buses[names.size()], *buses[names.size() + 1], *buses[names.size() + 2], rigs, notifier);
  for (auto& rig : rigs) rig->introduce();
  const Time begun = std::chrono::steady_clock::now();
  const bool are_ready = wait_for(rigs, answers, *notifier, kReadyWithin, [&] {
    return answers.ready() == names.size() + 1 &&
           std::all_of(rigs.begin(), rigs.end(), [](const auto& rig) { return rig->readers() == 3; });
  });
  if (!are_ready) {
    return fail(ErrorCode::kUnavailable,
                fmt::format("after {} s {} of {} services are ready, and not every rig has its readers",
                            kReadyWithin.count(), answers.ready(), names.size() + 1));
  }
  const double ready_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
  for (Measured* each : {&identification, &archive, &bare}) each->begin();
  const Time start = std::chrono::steady_clock::now();
  const double latest_ms = run_rigs(rigs, answers, *notifier);
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  for (Measured* each : {&identification, &archive, &bare}) each->end();

  const std::size_t trials = names.size() * asked.trials;
  (void)wait_for(rigs, answers, *notifier, kAnsweredWithin, [&] {
    return answers.judged() == trials && answers.estimated() == trials && answers.stored() == trials;
  });
  std::uint64_t refused = 0;
  std::uint64_t blocks = 0;
  for (const auto& rig : rigs) {
    refused += rig->refused();
    blocks += rig->blocks();
  }
  const auto late = std::count_if(answers.live_ms.begin(), answers.live_ms.end(), [](double ms) {
    return ms > std::chrono::duration<double, std::milli>(kBlockTime).count();
  });
  return nlohmann::json{{"dds", asked.dds},
                        {"rigs", names.size()},
                        {"seconds", seconds},
                        {"ready_s", ready_s},
                        {"blocks", blocks},
                        {"latest_block_ms", latest_ms},
                        {"refused_by_bus", refused},
                        {"dropped", answers.dropped()},
                        {"trials", trials},
                        {"judged", answers.judged()},
                        {"estimated", answers.estimated()},
                        {"stored_whole", answers.stored()},
                        {"live", spread(answers.live_ms)},
                        {"live_later_than_a_block", late},
                        {"verdict", spread(answers.verdict_ms)},
                        {"estimate", spread(answers.estimate_ms)},
                        {"bare", spread(answers.bare_ms)},
                        {"cores_identification", identification.taken() / seconds},
                        {"cores_archive", archive.taken() / seconds},
                        {"cores_bare", bare.taken() / seconds}};
}

std::string number(const nlohmann::json& value) {
  return value.is_null() ? "n/a" : fmt::format("{:.2f}", value.get<double>());
}

void print(const nlohmann::json& row) {
  const auto ms = [&](const char* name) {
    const auto& each = row[name];
    return fmt::format("{} (p50 {}, p99 {}, p99.9 {} ms)", each["count"].get<std::size_t>(),
                       number(each["p50_ms"]), number(each["p99_ms"]), number(each["p99.9_ms"]));
  };
  fmt::print(
      "{} rigs, {}, {:.1f} s, ready after {:.1f} s: {} blocks, the latest sent {:.1f} ms late; refused by "
      "the bus "
      "{}, dropped {}\n",
      row["rigs"].get<int>(), row["dds"].get<std::string>(), row["seconds"].get<double>(),
      row["ready_s"].get<double>(), row["blocks"].get<std::uint64_t>(), row["latest_block_ms"].get<double>(),
      row["refused_by_bus"].get<std::uint64_t>(), row["dropped"].get<std::uint64_t>());
  fmt::print("  of {} trials: {} judged, {} estimated, {} stored whole\n", row["trials"].get<int>(),
             row["judged"].get<int>(), row["estimated"].get<int>(), row["stored_whole"].get<int>());
  fmt::print("  live estimates {}, {} later than a block's time; bare answers {}\n", ms("live"),
             row["live_later_than_a_block"].get<int>(), ms("bare"));
  fmt::print("  verdicts {}; estimates {}\n", ms("verdict"), ms("estimate"));
  fmt::print("  cores: identification {:.2f}, archive {:.2f}, bare reader {:.2f}\n",
             row["cores_identification"].get<double>(), row["cores_archive"].get<double>(),
             row["cores_bare"].get<double>());
}

}  // namespace
}  // namespace tonus::bench

int main(int argc, char** argv) {
  using namespace tonus;
  CLI::App app("Many rigs into one identification service and one archive, beside a bare reader.",
               "rigs_bench");
  bench::Asked asked;
  app.add_option("--dds", asked.dds, "fastdds or cyclonedds")
      ->check(CLI::IsMember({"fastdds", "cyclonedds"}))
      ->capture_default_str();
  app.add_option("--rigs", asked.rigs, "simulated rigs at 200 Hz")
      ->check(CLI::Range(1, 64))
      ->capture_default_str();
  app.add_option("--trials", asked.trials, "of each rig, 3.25 s each")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  app.add_flag("--json", asked.is_json, "one object instead of the lines");
  app.add_flag("--bare", asked.is_bare)->group("");
  app.add_option("--domain", asked.domain)->group("");
  CLI11_PARSE(app, argc, argv);
  if (asked.is_bare)
    return bench::answer_every_block(bench::bus_options(asked.dds, asked.domain, "bare-reader"),
                                     bench::names_of(asked.rigs));
  asked.domain = testing::own_domain();
  const auto row = bench::measure(asked);
  if (!row) {
    fmt::print(stderr, "rigs_bench: {}\n", row.error().message);
    return 1;
  }
  if (asked.is_json)
    fmt::print("{}\n", row->dump());
  else
    bench::print(*row);
  return 0;
}
