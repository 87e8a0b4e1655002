// tonus-rig-agent: the program beside the hardware.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <spdlog/spdlog.h>

#include "idl/topics.hpp"
#include "rig_agent/agent/agent.hpp"
#include "rig_agent/agent/calibrate_command.hpp"
#include "rig_agent/agent/check_driver_command.hpp"
#include "rig_agent/agent/emergency_signal.hpp"
#include "rig_agent/agent/hold_reason.hpp"
#include "rig_agent/agent/loop_report.hpp"
#include "rig_agent/agent/loop_thread.hpp"
#include "rig_agent/agent/rig.hpp"
#include "rig_agent/agent/rig_folder.hpp"
#include "rig_agent/agent/safety_channel.hpp"
#include "rig_agent/agent/watchdog_process.hpp"
#include "rig_agent/control/realtime_setup.hpp"
#include "services/core/lifetime.hpp"
#include "services/core/machine_lock.hpp"
#include "services/runtime/health.hpp"
#include "services/runtime/loop.hpp"
#include "services/runtime/options.hpp"

namespace tonus {
namespace {

constexpr char kProgram[] = "tonus-rig-agent";

/// The rig under power: for as long as one lives, the latch on disk says so.
class Power {
 public:
  [[nodiscard]] static Result<Power> on(rig::HoldLatch& latch) {
    TONUS_TRY(latch.set_powered(true));
    return Power(latch);
  }
  Power(Power&& other) noexcept : latch_(std::exchange(other.latch_, nullptr)) {}
  Power& operator=(Power&&) = delete;
  ~Power() {
    if (latch_ == nullptr) return;
    if (auto off = latch_->set_powered(false); !off) spdlog::error("{}", off.error().message);
  }

 private:
  explicit Power(rig::HoldLatch& latch) : latch_(&latch) {}
  rig::HoldLatch* latch_;
};

/// One agent of a rig on this machine and domain, whatever its data folder and user.
Result<MachineLock> lock_rig(const runtime::CommonOptions& common) {
  return MachineLock::take("domain " + std::to_string(common.domain) + " rig " + common.rig);
}

/// A computed rig is held up by the machine, not by a device.
Clock::Duration longest_cycle(const drivers::Capabilities& driver) {
  return driver.moves_nothing_real ? std::chrono::milliseconds(5000) : std::chrono::milliseconds(100);
}

/// Null where nothing real moves, or where the driver cannot be disabled from outside.
Result<std::unique_ptr<rig::WatchdogProcess>> start_watchdog(rig::Rig& rig, const rig::RigOptions& options,
                                                             const Clock& clock) {
  const auto driver = rig.driver().capabilities();
  if (driver.moves_nothing_real || !driver.can_disable || !driver.actuates)
    return std::unique_ptr<rig::WatchdogProcess>();
  auto started = rig::WatchdogProcess::start({.limit = rig.loop().config().limits.watchdog,
                                              .fifo_priority = std::min(options.fifo_priority + 1, 99),
                                              .driver = options.driver,
                                              .driver_file = options.driver_file,
                                              .driver_options = options.driver_options},
                                             clock);
  if (started) rig.loop().set_pulse(&(*started)->pulse());
  return started;
}

std::vector<std::string> warnings_of(const rig::RigNames& names, const drivers::Capabilities& driver) {
  std::vector<std::string> warnings;
  if (names.resumes_unattended) warnings.emplace_back("goes on by itself after a fault or a restart");
  if (driver.actuates && !driver.moves_nothing_real && !driver.can_disable)
    warnings.emplace_back("no watchdog: the driver cannot be disabled from outside (version 1)");
  for (const auto& limit : names.limits_off) warnings.push_back("limit " + limit + " is off");
  return warnings;
}

std::string state_line(const std::string& state, const std::string& refusal) {
  return refusal.empty() ? state : state + "; " + refusal;
}

Result<void> calibrate(const runtime::CommonOptions& common, const rig::RigOptions& rig_options,
                       const rig::CalibrateOptions& options, const rig::CalibrationStep& step) {
  const SystemClock clock;
  auto data = runtime::data_folder(common);
  if (!data) return data.error();
  TONUS_TRY_ASSIGN(const auto lock, lock_rig(common));
  TONUS_TRY_ASSIGN(const auto own_folder, rig_options.own_folder(common.rig));
  auto folder = rig::RigFolder::take(*data, common.rig, own_folder);
  if (!folder) return folder.error();
  TONUS_TRY_ASSIGN(auto latch, rig::HoldLatch::open(folder->hold()));
  if (latch.is_held()) {
    return fail(ErrorCode::kUnavailable, "the rig is held: " + latch.because() +
                                             "; start the agent without 'calibrate' and clear it first");
  }
  TONUS_TRY_ASSIGN(const auto power, Power::on(latch));
  auto rig = rig::Rig::create(rig_options, common.rig, folder->calibration());
  if (!rig) return rig.error();
  if (!rig->driver().capabilities().actuates)
    return fail(ErrorCode::kInvalidArgument, "calibrate: a recording cannot be calibrated");
  const rig::EmergencySignal emergency_signal(rig->loop());
  if (!rig->driver().capabilities().has_own_clock)
    spdlog::info("{}", control::set_up_realtime(rig_options.realtime()).statement);
  auto line = step(*rig, *folder, options, clock);
  rig->driver().deactivate();
  if (!line) return line.error();
  std::printf("%s\n", line->c_str());
  return {};
}

Result<void> run(const runtime::CommonOptions& common, const rig::RigOptions& rig_options) {
  auto notifier = std::make_shared<bus::Notifier>();
  const StopSignal stop([notifier] { notifier->notify(); });
  const SystemClock clock;

  auto data = runtime::data_folder(common);
  if (!data) return data.error();
  TONUS_TRY_ASSIGN(const auto lock, lock_rig(common));
  TONUS_TRY_ASSIGN(const auto own_folder, rig_options.own_folder(common.rig));
  auto folder = rig::RigFolder::take(*data, common.rig, own_folder);
  if (!folder) return folder.error();
  TONUS_TRY_ASSIGN(auto latch, rig::HoldLatch::open(folder->hold()));
  TONUS_TRY_ASSIGN(const auto power, Power::on(latch));
  auto rig = rig::Rig::create(rig_options, common.rig, folder->calibration());
  if (!rig) return rig.error();
  const rig::EmergencySignal emergency_signal(rig->loop());
  auto spool = rig::Spool::open(
      {.folder = folder->spool(), .max_bytes = static_cast<std::uint64_t>(rig_options.spool_MB) << 20});
  if (!spool) return spool.error();
  auto log = rig::TrialLog::open(folder->trial_log());
  if (!log) return log.error();

  auto bus = runtime::open_bus(common, kProgram);
  if (!bus) return bus.error();
  auto samples = (*bus)->create_writer(topics::kRigSamples.spec);
  if (!samples) return samples.error();
  TONUS_TRY_ASSIGN(auto auxiliary, (*bus)->create_writer(topics::kRigAuxiliary.spec));
  auto endpoints = rig::AgentEndpoints::create(**bus, notifier);
  if (!endpoints) return endpoints.error();
  auto health = runtime::HealthReporter::create(**bus, clock, v1::ROLE_RIG, common, notifier);
  if (!health) return health.error();
  TONUS_TRY(runtime::listen_for_others(*health, common, clock, *notifier, stop));

  const std::uint64_t epoch = clock.utc_ns();
  rig::Publisher::Options publishing{
      .rig = rig->names().id, .epoch = epoch, .auxiliary_values = rig->loop().auxiliary_values()};
  if (!rig_options.is_paced()) publishing.patience = std::chrono::seconds(2);
  rig::Publisher publisher(publishing, *spool, std::move(*samples), std::move(auxiliary), clock);
  rig::Lease lease(rig->names().id, epoch);
  rig::StopRequests stops;
  TONUS_TRY_ASSIGN(auto safety_bus, runtime::open_bus(common, std::string(kProgram) + " stop"));
  TONUS_TRY_ASSIGN(const auto safety_channel,
                   rig::SafetyChannel::create(std::move(safety_bus), rig->names().id, rig->loop(), lease,
                                              stops, clock, notifier));
  rig::Agent agent(
      {.names = rig->names(),
       .epoch = epoch,
       .is_paced = rig_options.is_paced(),
       .resumes_unattended = rig_options.resumes_unattended,
       .longest_cycle = longest_cycle(rig->driver().capabilities())},
      {rig->loop(), rig->driver(), rig->recorded(), publisher, *spool, *log, latch, lease, stops},
      std::move(*endpoints), clock);
  agent.start(rig::describe(rig->names(), rig->driver().geometry()));
  TONUS_TRY_ASSIGN(const auto watchdog, start_watchdog(*rig, rig_options, clock));
  if (watchdog) watchdog->set_powered(true);
  rig::LoopThread loop_thread(rig->loop(), rig_options.is_paced(), rig_options.realtime());
  spdlog::log(loop_thread.refusal().empty() ? spdlog::level::info : spdlog::level::warn,
              "rig '{}': {} driver, {}", common.rig, rig->names().driver, loop_thread.statement());
  auto report = rig::LoopReport::create(
      **bus, {rig->names().id, epoch, loop_thread.statement(), loop_thread.pacer()}, rig->loop(), clock);
  if (!report) return report.error();

  health->set_warnings(warnings_of(rig->names(), rig->driver().capabilities()));
  const auto ended = runtime::run_loop_until_error(*notifier, stop, [&]() -> Result<Clock::TimePoint> {
    TONUS_TRY(health->check_alone());
    if (const std::string problem = watchdog ? watchdog->problem() : ""; !problem.empty())
      agent.hold(problem, true);
    if (const std::string doubled = health->other(); !doubled.empty())
      agent.hold(std::string(rig::phrase_of(rig::HoldReason::kSecondAgent)) + ": " + doubled, true);
    const auto due = std::min(agent.step(), report->step());
    const std::string why = agent.why_not_ready();
    health->set_state(why.empty(), state_line(why.empty() ? agent.activity() : why, loop_thread.refusal()));
    health->set_load(0.0, static_cast<std::uint32_t>(rig->loop().samples_waiting()),
                     publisher.blocks_refused() + agent.replies_dropped());
    return std::min(due, health->publish_if_due());
  });
  if (watchdog) watchdog->set_powered(false);
  if (!loop_thread.stop()) {
    // The driver hangs in the loop's thread: nothing of this program can be taken down in order. The latch
    // says that the rig was under power, and holds it at the next start.
    const bool is_off = rig->driver().disable();
    spdlog::critical("the driver does not return; the torque is {}", is_off ? "off" : "not known to be off");
    std::_Exit(EXIT_FAILURE);
  }
  rig->driver().deactivate();
  TONUS_TRY(spool->sync());
  return ended;
}

}  // namespace
}  // namespace tonus

int main(int argc, char** argv) {
  using namespace tonus;
  runtime::begin_program();
  control::keep_stacks_small();
  runtime::CommonOptions common;
  rig::RigOptions rig_options;
  CLI::App app("Realtime control and acquisition beside the hardware.", kProgram);
  runtime::add_common_options(app, common);
  rig::add_options(app, rig_options);
  rig::CalibrateOptions calibration;
  rig::CalibrationStep calibration_step;
  rig::add_calibrate_command(app, calibration, calibration_step);
  rig::CheckDriverOptions driver_check;
  rig::add_check_driver_command(app, driver_check);
  runtime::set_example(app, "tonus-rig-agent --driver simulated --profile deploy/profiles/default.toml");
  if (const int code = runtime::parse_command_line(app, argc, argv); code >= 0) return code;
  if (!driver_check.file.empty())
    return runtime::report(std::string(kProgram) + " check-driver", rig::check_driver(driver_check));
  runtime::start_log(kProgram, common);
  const auto outcome = calibration_step ? calibrate(common, rig_options, calibration, calibration_step)
                                        : run(common, rig_options);
  return runtime::end_program(kProgram, outcome ? 0 : runtime::report(kProgram, outcome.error()));
}
