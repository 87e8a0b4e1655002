#include "tests/fault/simulator/programs.hpp"

#include <cmath>
#include <optional>
#include <utility>

#include "analysis_service/service/command_line.hpp"
#include "analysis_service/service/service.hpp"
#include "rig_agent/agent/rig_folder.hpp"
#include "rig_agent/agent/rig_service.hpp"
#include "services/archive/archive_run.hpp"
#include "services/runtime/health.hpp"
#include "services/scheduler/scheduler_service.hpp"
#include "tests/support/short_session.hpp"

#include <idl/idl_hash.hpp>

namespace tonus::simulator {
namespace {

constexpr std::chrono::milliseconds kLoopPart{5};
constexpr double kCommandTimeout = 3.0;

std::filesystem::path profile_of(const Surroundings& around) { return around.data / "profile.toml"; }

using SharedNotifier = std::shared_ptr<bus::Notifier>;

Result<runtime::HealthReporter> reporter(bus::Bus& bus, const std::shared_ptr<Life>& life,
                                         v1::ServiceRole role, const SharedNotifier& notifier) {
  return runtime::HealthReporter::create(bus, life->clock, role, {}, notifier);
}

class RigProgram final : public Program {
 public:
  static Result<std::unique_ptr<Program>> start(const std::shared_ptr<Life>& life,
                                                const Surroundings& around) {
    TONUS_TRY_ASSIGN(auto folder, rig::RigFolder::take(around.data, "rig"));
    TONUS_TRY_ASSIGN(auto latch, rig::HoldLatch::open(folder.hold()));
    TONUS_TRY(latch.set_powered(true));
    rig::RigOptions options;
    options.profile = profile_of(around).string();
    options.seed = around.random.next();
    TONUS_TRY_ASSIGN(auto rig, rig::Rig::create(options, "rig", folder.calibration()));
    TONUS_TRY_ASSIGN(auto spool, rig::Spool::open({.folder = folder.spool(), .max_bytes = 8ULL << 20}));
    TONUS_TRY_ASSIGN(auto log, rig::TrialLog::open(folder.trial_log()));
    std::unique_ptr<RigProgram> program(new RigProgram(life, std::move(folder), std::move(latch),
                                                       std::move(rig), std::move(spool), std::move(log)));
    TONUS_TRY(program->wire(around));
    return std::unique_ptr<Program>(std::move(program));
  }

  void finish() override {
    rig_.driver().deactivate();
    (void)latch_.set_powered(false);
    (void)spool_.sync();
  }
  const control::LoopState* loop() const override { return &state_; }
  bool is_held() const override { return latch_.is_held(); }

 private:
  RigProgram(std::shared_ptr<Life> life, rig::RigFolder folder, rig::HoldLatch latch, rig::Rig rig,
             rig::Spool spool, rig::TrialLog log)
      : life_(std::move(life)),
        folder_(std::move(folder)),
        latch_(std::move(latch)),
        rig_(std::move(rig)),
        spool_(std::move(spool)),
        log_(std::move(log)) {}

  Result<void> wire(const Surroundings& around) {
    const auto notifier = std::make_shared<bus::Notifier>();
    bus_ = around.network.join(life_);
    TONUS_TRY_ASSIGN(auto health, reporter(*bus_, life_, v1::ROLE_RIG, notifier));
    TONUS_TRY_ASSIGN(service_,
                     rig::RigService::create(*bus_, around.network.join(life_), notifier, std::move(health),
                                             {rig_, spool_, log_, latch_, life_->clock},
                                             {.safety = rig::SafetyChannel::Works::kByStep}));
    service_->start();
    TONUS_TRY(service_->begin({"simulated", "", nullptr}));
    cycle_at_ = life_->clock.now();
    life_->tasks.push_back({"loop", nullptr, [this] { return Result<Time>(run_loop()); }});
    life_->tasks.push_back({"agent", notifier, [this] { return service_->step(); }});
    life_->tasks.push_back({"stop channel", service_->safety_channel().notifier(),
                            [this] { return Result<Time>(service_->safety_channel().step()); }});
    return {};
  }

  // The cycles since the last call. Where there are more than a call's worth, the others were missed.
  Time run_loop() {
    const std::chrono::nanoseconds period(std::llround(1e9 * rig_.loop().period()));
    const Time now = life_->clock.now();
    const auto behind = now - cycle_at_ - 2 * kLoopPart;
    const auto missed = behind.count() > 0 ? static_cast<unsigned>(behind / period) : 0U;
    cycle_at_ += missed * period;
    for (bool is_first = true; cycle_at_ + period <= now; is_first = false) {
      cycle_at_ += period;
      rig_.loop().step(cycle_at_.time_since_epoch().count(), is_first ? missed : 0U);
    }
    state_ = rig_.loop().state();
    return cycle_at_ + kLoopPart;
  }

  std::shared_ptr<Life> life_;
  rig::RigFolder folder_;
  rig::HoldLatch latch_;
  rig::Rig rig_;
  rig::Spool spool_;
  rig::TrialLog log_;
  std::unique_ptr<bus::Bus> bus_;
  std::unique_ptr<rig::RigService> service_;
  Time cycle_at_{};
  control::LoopState state_;
};

class SchedulerProgram final : public Program {
 public:
  static Result<std::unique_ptr<Program>> start(const std::shared_ptr<Life>& life,
                                                const Surroundings& around) {
    auto program = std::make_unique<SchedulerProgram>();
    const auto notifier = std::make_shared<bus::Notifier>();
    TONUS_TRY_ASSIGN(auto folder, scheduler::SessionFolder::open(around.data / "sessions", v1::kIdlHash));
    program->bus_ = around.network.join(life);
    TONUS_TRY_ASSIGN(auto endpoints, scheduler::SchedulerEndpoints::create(*program->bus_, notifier));
    TONUS_TRY_ASSIGN(auto health, reporter(*program->bus_, life, v1::ROLE_SCHEDULER, notifier));
    TONUS_TRY_ASSIGN(auto roster, runtime::Roster::create(*program->bus_, life->clock, notifier));
    TONUS_TRY_ASSIGN(auto lease, scheduler::LeaseSender::create(around.network.join(life), life->clock,
                                                                scheduler::LeaseSender::Works::kByStep));
    auto& sender = *lease;
    Random& random = around.random;
    const auto new_id = [&random] {
      Id id;
      for (auto& byte : id) byte = static_cast<std::uint8_t>(random.next());
      return id;
    };
    TONUS_TRY_ASSIGN(program->service_, scheduler::SchedulerService::create(
                                            std::move(endpoints), std::move(health), std::move(roster),
                                            std::move(folder), std::move(lease), "rig", life->clock, new_id));
    life->tasks.push_back(
        {"scheduler", notifier, [service = program->service_.get()] { return service->step(); }});
    life->tasks.push_back({"lease", nullptr, [&sender] { return Result<Time>(sender.step()); }});
    return std::unique_ptr<Program>(std::move(program));
  }

 private:
  std::unique_ptr<bus::Bus> bus_;
  std::unique_ptr<scheduler::SchedulerService> service_;
};

class IdentificationProgram final : public Program {
 public:
  static Result<std::unique_ptr<Program>> start(const std::shared_ptr<Life>& life,
                                                const Surroundings& around) {
    auto program = std::make_unique<IdentificationProgram>();
    const auto notifier = std::make_shared<bus::Notifier>();
    TONUS_TRY_ASSIGN(const auto settings, identification::CommandLine{}.settings("rig"));
    program->bus_ = around.network.join(life);
    TONUS_TRY_ASSIGN(auto endpoints, identification::ServiceEndpoints::create(*program->bus_, notifier));
    TONUS_TRY_ASSIGN(auto health, reporter(*program->bus_, life, v1::ROLE_IDENTIFICATION, notifier));
    TONUS_TRY_ASSIGN(auto roster, runtime::Roster::create(*program->bus_, life->clock, notifier));
    auto& service = program->service_.emplace(settings, std::move(endpoints), std::move(health),
                                              std::move(roster), life->clock);
    life->tasks.push_back({"identification", notifier, [&service]() -> Result<Time> {
                             TONUS_TRY(service.check_alone());
                             return service.step();
                           }});
    return std::unique_ptr<Program>(std::move(program));
  }
  void finish() override { service_->finish(); }

 private:
  std::unique_ptr<bus::Bus> bus_;
  std::optional<identification::IdentificationService> service_;
};

class ArchiveProgram final : public Program {
 public:
  static Result<std::unique_ptr<Program>> start(const std::shared_ptr<Life>& life,
                                                const Surroundings& around) {
    auto program = std::make_unique<ArchiveProgram>();
    const auto notifier = std::make_shared<bus::Notifier>();
    program->bus_ = around.network.join(life);
    TONUS_TRY_ASSIGN(auto health, reporter(*program->bus_, life, v1::ROLE_ARCHIVE, notifier));
    TONUS_TRY_ASSIGN(program->run_, archive::ArchiveRun::create(*program->bus_, around.store, life->clock,
                                                                notifier, std::move(health), {}));
    life->tasks.push_back({"archive", notifier, [run = program->run_.get()] { return run->step(); }});
    return std::unique_ptr<Program>(std::move(program));
  }
  void finish() override {
    (void)run_->take_the_rest();
    (void)run_->finish();
  }

 private:
  std::unique_ptr<bus::Bus> bus_;
  std::unique_ptr<archive::ArchiveRun> run_;
};

}  // namespace

void write_profile(const Surroundings& around) {
  testing::write_patient_profile(profile_of(around), kCommandTimeout);
}

Result<std::unique_ptr<Program>> start_program(const std::shared_ptr<Life>& life,
                                               const Surroundings& around) {
  if (life->program == kRig) return RigProgram::start(life, around);
  if (life->program == kScheduler) return SchedulerProgram::start(life, around);
  if (life->program == kIdentification) return IdentificationProgram::start(life, around);
  return ArchiveProgram::start(life, around);
}

}  // namespace tonus::simulator
