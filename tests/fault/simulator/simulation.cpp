#include "tests/fault/simulator/simulation.hpp"

#include <algorithm>
#include <filesystem>
#include <map>
#include <memory>
#include <spdlog/fmt/fmt.h>
#include <spdlog/spdlog.h>
#include <utility>
#include <vector>

#include "idl/topics.hpp"
#include "services/contract/names.hpp"
#include "tests/fault/simulator/disk.hpp"
#include "tests/fault/simulator/network.hpp"
#include "tests/fault/simulator/operator.hpp"
#include "tests/fault/simulator/programs.hpp"
#include "tests/fault/simulator/store.hpp"
#include "tests/fault/simulator/witness.hpp"
#include "tests/support/short_session.hpp"

namespace tonus::simulator {
namespace {

constexpr std::chrono::seconds kSettling{8};
constexpr std::chrono::minutes kPatience{15};  // for a session, on top of what befalls it

Clock::Duration seconds(double value) {
  return std::chrono::nanoseconds(static_cast<std::int64_t>(1e9 * value));
}

/// A program's place on its machine: what it is now, and what outlives it.
struct Seat {
  std::string name;
  Disk disk;
  std::shared_ptr<Life> life;
  std::unique_ptr<Program> program;
  Time start_at{};
  Time paused_until{};
  std::chrono::milliseconds pause{200};  // before the next start, as the supervisor has it
  Time started{};
};

class World {
 public:
  World(const testing::Scenario& scenario, const SimulationOptions& options)
      : options_(options),
        random_(options.seed),
        scenario_(scenario),
        store_(random_, archive_disk_),
        witness_(store_),
        network_(now_, random_, drawn_network(),
                 [this](const Life& writer, const std::string& topic, std::span<const std::byte> payload) {
                   witness_.written(now_, writer.program, topic, payload);
                   say_reply(writer, topic, payload);
                 }),
        operator_life_(std::make_shared<Life>("operator", now_, utc_step_)) {
    std::filesystem::remove_all("world");
    std::filesystem::create_directories("world");
    write_profile(surroundings());
    testing::write_short_protocol("world/protocol.toml", options.trials, 1.5);
    operator_ = std::make_unique<Operator>(network_, operator_life_, random_, read("world/protocol.toml"),
                                           [this] { witness_.grant(); });
    operator_life_->tasks.push_back(
        {"operator", nullptr, [this] { return Result<Time>(operator_->step()); }});
    for (const char* name : {kArchive, kIdentification, kScheduler, kRig}) {
      seats_.emplace_back().name = name;
      seats_.back().start_at = now_ + seconds(random_.between(0.0, 0.3));
    }
  }

  ~World() {
    for (Seat& seat : seats_) die(seat);
    std::filesystem::remove_all("world");
  }

  Outcome run() {
    const Time limit = now_ + kPatience + seconds(60.0 * static_cast<double>(scenario_.size()));
    while (now_ < limit && !(over_at_ && now_ >= *over_at_ + kSettling)) {
      go_on();
      if (!over_at_ && operator_->is_over() && next_step_ == scenario_.size()) over_at_ = now_;
    }
    Outcome outcome;
    if (!over_at_) outcome.broken = "the session does not end: " + where_it_stands();
    const bool has_completed = over_at_ && operator_->session()->phase() == v1::SESSION_COMPLETED;
    if (over_at_) witness_.check_end(operator_->session_id(), has_completed, *over_at_);
    outcome.broken += witness_.broken();
    outcome.hash = witness_.hash();
    outcome.trials = witness_.counted();
    outcome.simulated = 1e-9 * static_cast<double>((now_ - Time(kBegin)).count());
    return outcome;
  }

 private:
  static constexpr std::chrono::seconds kBegin{1000};

  static std::string read(const std::filesystem::path& file) {
    std::string text(std::filesystem::file_size(file), '\0');
    std::unique_ptr<std::FILE, int (*)(std::FILE*)> from(std::fopen(file.c_str(), "r"), &std::fclose);
    text.resize(std::fread(text.data(), 1, text.size(), from.get()));
    return text;
  }

  Network::Options drawn_network() {
    Network::Options network;
    network.slow_share = random_.chance(0.5) ? 0.0 : random_.between(0.0, 0.05);
    network.slow = random_.between(0.01, 1.0);
    network.loss = random_.between(0.0, 0.2);
    network.discovery = random_.between(0.01, 1.0);
    return network;
  }

  Surroundings surroundings() { return {network_, random_, store_, "world"}; }

  Disk& disk_of(Seat& seat) { return seat.name == kArchive ? archive_disk_ : seat.disk; }

  std::string where_it_stands() const {
    if (!operator_->session()) return "it was not seen\n";
    return fmt::format("phase {}, waits for '{}'; rig: {}\n", phase_name(operator_->session()->phase()),
                       operator_->session()->waiting_for(),
                       operator_->rig() ? operator_->rig()->held_because() : "not heard");
  }

  /// To the next thing that happens.
  void go_on() {
    Time next = std::min(network_.next(), next_change());
    for (const Task& task : operator_life_->tasks) next = std::min(next, task.due);
    for (const Seat& seat : seats_) next = std::min(next, next_of(seat));
    now_ = std::max(now_, next);
    network_.deliver();
    befall();
    for (Seat& seat : seats_) {
      if (!seat.program && now_ >= seat.start_at) start(seat);
    }
    run_tasks(*operator_life_, nullptr);
    const std::size_t first = random_.below(static_cast<unsigned>(seats_.size()));
    for (std::size_t i = 0; i < seats_.size(); ++i) {
      Seat& seat = seats_[(first + i) % seats_.size()];
      if (seat.program && now_ >= seat.paused_until) run_tasks(*seat.life, &seat);
    }
  }

  static Time next_of(const Seat& seat) {
    if (!seat.program) return seat.start_at;
    Time next = kNever;
    for (const Task& task : seat.life->tasks) next = std::min(next, std::max(task.due, task.busy_until));
    return std::max(next, seat.paused_until);
  }

  void run_tasks(Life& life, Seat* seat) {
    for (std::size_t i = 0; i < life.tasks.size(); ++i) {
      Task& task = life.tasks[i];
      if (std::max(task.due, task.busy_until) > now_) continue;
      if (!run_task(life, task, seat)) return;
    }
  }

  /// False where the life has ended in it.
  bool run_task(Life& life, Task& task, Seat* seat) {
    life.clock.begin_step();
    task.due = kNever;
    std::optional<Result<Time>> due;
    try {
      const Disk none;
      const WritesOf writes(life, seat != nullptr ? disk_of(*seat) : none);
      due = task.step();
    } catch (const Died&) {
      life.is_dead = true;
    }
    if (life.is_dead) {
      say(life, "dies in a write");
      if (seat->name == kRig) witness_.rig_lost_a_write();
      return take_back(*seat), die(*seat), false;
    }
    if (!*due) {
      say(life, (*due).error().message);
      take_back(*seat);
      return die(*seat), false;
    }
    task.due = std::min(task.due, **due);
    task.busy_until = life.clock.now() + seconds(random_.between(1e-5, 2e-4));
    if (seat != nullptr && seat->name == kRig) look_at_rig(*seat);
    return true;
  }

  void look_at_rig(Seat& seat) {
    const bool is_held = seat.program->is_held();
    if (is_held) witness_.take_back("the rig was held");
    if (seat.program->loop() != nullptr) witness_.saw_loop(now_, *seat.program->loop(), is_held);
  }

  void say(const Life& life, const std::string& what) const {
    if (!options_.is_quiet)
      std::fprintf(stderr, "%.3f %s: %s\n", 1e-9 * static_cast<double>(now_.time_since_epoch().count()),
                   life.program.c_str(), what.c_str());
  }

  void say_reply(const Life& writer, const std::string& topic, std::span<const std::byte> payload) const {
    if (options_.is_quiet) return;
    if (topic == topics::kSessionReply.spec.name) {
      if (const auto reply = bus::decode<v1::SessionReply>(payload)) say(writer, reply->message());
    } else if (topic == topics::kRigReply.spec.name) {
      if (const auto reply = bus::decode<v1::RigReply>(payload)) say(writer, reply->message());
    }
  }

  void take_back(const Seat& seat) {
    if (seat.name == kRig) witness_.take_back("an end of the rig's agent");
    if (seat.name == kScheduler) witness_.scheduler_ended(now_);
  }

  void start(Seat& seat) {
    seat.life = std::make_shared<Life>(seat.name, now_, utc_step_);
    if (seat.name == kArchive) store_.belong_to(seat.life.get());
    seat.started = now_;
    std::optional<Result<std::unique_ptr<Program>>> started;
    try {
      const WritesOf writes(*seat.life, disk_of(seat));
      started = start_program(seat.life, surroundings());
    } catch (const Died&) {
    }
    if (!started || !*started) {
      say(*seat.life, started ? (*started).error().message : "dies at its start");
      return die(seat);
    }
    seat.program = std::move(**started);
    for (Task& task : seat.life->tasks) task.due = now_;
    say(*seat.life, "starts");
    if (seat.name == kRig) witness_.rig_began(now_, seat.program->is_held());
  }

  /// Without a word; the supervisor starts it anew.
  void die(Seat& seat) {
    if (!seat.life) return;
    if (seat.program && seat.name == kRig) witness_.rig_ended(seat.program->is_held(), true);
    seat.life->is_dead = true;
    network_.bury(*seat.life);
    gone(seat);
  }

  void gone(Seat& seat) {
    {
      const WritesOf writes(*seat.life, disk_of(seat));
      seat.life->is_taken_down = true;
      seat.program.reset();
    }
    seat.life->tasks.clear();
    if (seat.name == kArchive) store_.belong_to(nullptr);
    const bool was_short = now_ - seat.started < std::chrono::seconds(10);
    seat.pause = was_short ? std::min(2 * seat.pause, std::chrono::milliseconds(5000))
                           : std::chrono::milliseconds(200);
    seat.start_at = now_ + seat.pause;
    seat.paused_until = {};
  }

  void end_in_order(Seat& seat) {
    if (!seat.program) return;
    if (seat.name == kRig) witness_.rig_ended(seat.program->is_held(), false);
    try {
      const WritesOf writes(*seat.life, disk_of(seat));
      seat.life->clock.begin_step();
      seat.program->finish();
    } catch (const Died&) {
      take_back(seat);
      return die(seat);
    }
    gone(seat);
  }

  Seat& seat_of(const std::string& name) {
    return *std::find_if(seats_.begin(), seats_.end(), [&](const Seat& seat) { return seat.name == name; });
  }

  /// When the scenario's next step, or the end of one, is due. The first one counts from the first trial.
  Time next_change() {
    Time next = ends_.empty() ? kNever : ends_.begin()->first;
    if (next_step_ == scenario_.size()) return next;
    if (!step_from_ && (witness_.has_seen_trial() || operator_->is_over())) step_from_ = now_;
    return step_from_ ? std::min(next, *step_from_ + seconds(scenario_[next_step_].after)) : next;
  }

  void befall() {
    while (!ends_.empty() && ends_.begin()->first <= now_) {
      const auto end = std::move(ends_.begin()->second);
      ends_.erase(ends_.begin());
      end();
    }
    while (next_step_ < scenario_.size() && next_change() <= now_ && step_from_ &&
           *step_from_ + seconds(scenario_[next_step_].after) <= now_) {
      *step_from_ = now_;
      happen(scenario_[next_step_++]);
    }
  }

  void fill(Seat& seat, bool is_full) {
    disk_of(seat).is_full = is_full;
    if (seat.name == kRig) witness_.rig_disk(is_full);
  }

  void happen(const testing::Step& step) {
    using Act = testing::Step::Act;
    if (!options_.is_quiet) std::fprintf(stderr, "%s\n", testing::to_text({step}).c_str());
    Seat& seat = step.program.empty() ? seats_.front() : seat_of(step.program);
    const Time until = now_ + seconds(step.lasts);
    switch (step.act) {
      case Act::kKill:
        if (seat.program) take_back(seat), die(seat);
        return;
      case Act::kPause:
        seat.paused_until = until;
        return;
      case Act::kRestart:
        for (Seat& each : seats_) take_back(each), end_in_order(each);
        return;
      case Act::kStop:
        return operator_->stop();
      case Act::kTear:
        if (seat.life && !seat.life->is_dead) seat.life->acts_left = step.count;
        return;
      case Act::kCut:
        return network_.cut(step.program, until);
      case Act::kFillDisk:
        fill(seat, true);
        ends_.emplace(until, [&seat, this] { fill(seat, false); });
        return;
      case Act::kStepClock:
        utc_step_ += seconds(step.lasts);
        return;
      case Act::kPauseSession:
        return operator_->pause();
      case Act::kAbortSession:
        return operator_->abort();
    }
  }

  const SimulationOptions options_;
  Time now_{kBegin};
  Clock::Duration utc_step_{};
  Random random_;
  const testing::Scenario scenario_;
  Disk archive_disk_;
  LastingStore store_;
  Witness witness_;
  Network network_;
  std::shared_ptr<Life> operator_life_;
  std::unique_ptr<Operator> operator_;
  std::vector<Seat> seats_;
  std::multimap<Time, std::function<void()>> ends_;
  std::size_t next_step_ = 0;
  std::optional<Time> step_from_;
  std::optional<Time> over_at_;
};

}  // namespace

Outcome simulate(const testing::Scenario& scenario, const SimulationOptions& options) {
  return World(scenario, options).run();
}

}  // namespace tonus::simulator
