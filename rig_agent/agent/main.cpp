// tonus-rig-agent: the program beside the hardware.

#include <CLI/CLI.hpp>
#include <cstdio>
#include <spdlog/spdlog.h>

#include "idl/topics.hpp"
#include "rig_agent/agent/agent.hpp"
#include "rig_agent/agent/calibrate_command.hpp"
#include "rig_agent/agent/emergency_signal.hpp"
#include "rig_agent/agent/loop_report.hpp"
#include "rig_agent/agent/loop_thread.hpp"
#include "rig_agent/agent/rig.hpp"
#include "rig_agent/agent/rig_folder.hpp"
#include "services/core/lifetime.hpp"
#include "services/runtime/health.hpp"
#include "services/runtime/loop.hpp"
#include "services/runtime/options.hpp"

namespace tonus {
namespace {

constexpr char kProgram[] = "tonus-rig-agent";

std::string state_line(const std::string& state, const std::string& refusal) {
  return refusal.empty() ? state : state + "; " + refusal;
}

Result<void> calibrate(const runtime::CommonOptions& common, const rig::RigOptions& rig_options,
                       const rig::CalibrateOptions& options, const rig::CalibrationStep& step) {
  const SystemClock clock;
  auto data = runtime::data_folder(common);
  if (!data) return data.error();
  auto folder = rig::RigFolder::take(*data, common.rig);
  if (!folder) return folder.error();
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
  auto folder = rig::RigFolder::take(*data, common.rig);
  if (!folder) return folder.error();
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
  auto endpoints = rig::AgentEndpoints::create(**bus, notifier);
  if (!endpoints) return endpoints.error();
  auto health = runtime::HealthReporter::create(**bus, clock, v1::ROLE_RIG, common, notifier);
  if (!health) return health.error();

  const std::uint64_t epoch = clock.utc_ns();
  rig::Publisher::Options publishing{.rig = rig->names().id, .epoch = epoch};
  if (!rig_options.is_paced()) publishing.patience = std::chrono::seconds(2);
  rig::Publisher publisher(publishing, *spool, std::move(*samples), clock);
  rig::Agent agent({rig->names(), epoch, rig_options.is_paced()}, rig->loop(), rig->recorded(), publisher,
                   *spool, *log, std::move(*endpoints), clock);
  agent.start(rig::describe(rig->names(), rig->driver().geometry()));
  rig::LoopThread loop_thread(rig->loop(), rig_options.is_paced(), rig_options.realtime());
  spdlog::log(loop_thread.refusal().empty() ? spdlog::level::info : spdlog::level::warn,
              "rig '{}': {} driver, {}", common.rig, rig->names().driver, loop_thread.statement());
  auto report = rig::LoopReport::create(
      **bus, {rig->names().id, epoch, loop_thread.statement(), loop_thread.pacer()}, rig->loop(), clock);
  if (!report) return report.error();

  runtime::run_loop(*notifier, stop, [&] {
    const auto due = std::min(agent.step(), report->step());
    const std::string why = agent.why_not_ready();
    health->set_state(why.empty(), state_line(why.empty() ? agent.activity() : why, loop_thread.refusal()));
    health->set_load(0.0, static_cast<std::uint32_t>(rig->loop().samples_waiting()),
                     publisher.blocks_refused());
    return std::min(due, health->publish_if_due());
  });
  loop_thread.stop();
  rig->driver().deactivate();
  return spool->sync();
}

}  // namespace
}  // namespace tonus

int main(int argc, char** argv) {
  using namespace tonus;
  runtime::CommonOptions common;
  rig::RigOptions rig_options;
  CLI::App app("Realtime control and acquisition beside the hardware.", kProgram);
  runtime::add_common_options(app, common);
  rig::add_options(app, rig_options);
  rig::CalibrateOptions calibration;
  rig::CalibrationStep calibration_step;
  rig::add_calibrate_command(app, calibration, calibration_step);
  if (const int code = runtime::parse_command_line(app, argc, argv); code >= 0) return code;
  runtime::start_log(kProgram, common.log_level);
  const auto outcome = calibration_step ? calibrate(common, rig_options, calibration, calibration_step)
                                        : run(common, rig_options);
  return outcome ? 0 : runtime::report(kProgram, outcome.error());
}
