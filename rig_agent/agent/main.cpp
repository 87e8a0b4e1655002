// tonus-rig-agent: the program beside the hardware.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <spdlog/spdlog.h>
#include <utility>

#include "rig_agent/agent/calibrate_command.hpp"
#include "rig_agent/agent/check_driver_command.hpp"
#include "rig_agent/agent/emergency_signal.hpp"
#include "rig_agent/agent/loop_thread.hpp"
#include "rig_agent/agent/rig.hpp"
#include "rig_agent/agent/rig_folder.hpp"
#include "rig_agent/agent/rig_service.hpp"
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

  TONUS_TRY_ASSIGN(const auto bus, runtime::open_bus(common, kProgram));
  TONUS_TRY_ASSIGN(auto health, runtime::HealthReporter::create(*bus, clock, v1::ROLE_RIG, common, notifier));
  TONUS_TRY(runtime::listen_for_others(health, common, clock, *notifier, stop));
  TONUS_TRY_ASSIGN(auto safety_bus, runtime::open_bus(common, std::string(kProgram) + " stop"));
  TONUS_TRY_ASSIGN(
      const auto service,
      rig::RigService::create(
          *bus, std::move(safety_bus), notifier, std::move(health), {*rig, *spool, *log, latch, clock},
          {.is_paced = rig_options.is_paced(), .resumes_unattended = rig_options.resumes_unattended}));
  service->start();
  TONUS_TRY_ASSIGN(const auto watchdog, start_watchdog(*rig, rig_options, clock));
  if (watchdog) watchdog->set_powered(true);
  rig::LoopThread loop_thread(rig->loop(), rig_options.is_paced(), rig_options.realtime());
  spdlog::log(loop_thread.refusal().empty() ? spdlog::level::info : spdlog::level::warn,
              "rig '{}': {} driver, {}", common.rig, rig->names().driver, loop_thread.statement());
  TONUS_TRY(service->begin({loop_thread.statement(), loop_thread.refusal(), loop_thread.pacer()}));

  auto ended = runtime::run_loop_until_error(
      *notifier, stop, [&] { return service->step(watchdog ? watchdog->problem() : ""); });
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
