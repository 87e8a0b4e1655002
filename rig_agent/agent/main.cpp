// tonus-rig-agent: the program beside the hardware.

#include <spdlog/spdlog.h>
#include <thread>

#include "idl/topics.hpp"
#include "rig_agent/agent/agent.hpp"
#include "rig_agent/agent/loop_thread.hpp"
#include "rig_agent/agent/rig.hpp"
#include "services/core/lifetime.hpp"
#include "services/runtime/health.hpp"
#include "services/runtime/loop.hpp"
#include "services/runtime/options.hpp"

namespace tonus {
namespace {

constexpr char kProgram[] = "tonus-rig-agent";

Result<void> run(const runtime::CommonOptions& common, const rig::RigOptions& rig_options) {
  auto notifier = std::make_shared<bus::Notifier>();
  const StopSignal stop([notifier] { notifier->notify(); });
  const SystemClock clock;

  auto rig = rig::Rig::create(rig_options, common.rig);
  if (!rig) return rig.error();
  auto folder = runtime::data_folder(common);
  if (!folder) return folder.error();
  auto spool = rig::Spool::open({.folder = *folder / "rig" / common.rig / "spool",
                                 .max_bytes = static_cast<std::uint64_t>(rig_options.spool_MB) << 20});
  if (!spool) return spool.error();
  auto log = rig::TrialLog::open(*folder / "rig" / common.rig / "trials.log");
  if (!log) return log.error();

  auto bus = runtime::open_bus(common, kProgram);
  if (!bus) return bus.error();
  auto samples = (*bus)->create_writer(topics::kRigSamples.spec);
  if (!samples) return samples.error();
  auto endpoints = rig::AgentEndpoints::create(**bus, notifier);
  if (!endpoints) return endpoints.error();
  auto health = runtime::HealthReporter::create(**bus, clock, v1::ROLE_RIG, common);
  if (!health) return health.error();

  const std::uint64_t epoch = clock.utc_ns();
  rig::Publisher::Options publishing{.rig = rig->names().id, .epoch = epoch};
  if (!rig_options.is_paced()) publishing.patience = std::chrono::seconds(2);
  rig::Publisher publisher(publishing, *spool, std::move(*samples), clock);
  rig::Agent agent({rig->names(), epoch, rig_options.is_paced()}, rig->loop(), rig->recorded(), publisher,
                   *spool, *log, std::move(*endpoints), clock);
  agent.start(rig::describe(rig->names(), rig->driver().geometry()));
  rig::LoopThread loop_thread(rig->loop(), rig_options.is_paced());
  spdlog::info("rig '{}': {} driver, {}", common.rig, rig->names().driver, loop_thread.statement());

  runtime::run_loop(*notifier, stop, [&] {
    const auto due = agent.step();
    const std::string why = agent.why_not_ready();
    health->set_state(why.empty(), why.empty() ? agent.activity() : why);
    health->set_load(0.0, static_cast<std::uint32_t>(rig->loop().samples_waiting()),
                     publisher.blocks_refused());
    return std::min(due, health->publish_if_due());
  });
  loop_thread.stop();
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
  if (const int code = runtime::parse_command_line(app, argc, argv); code >= 0) return code;
  runtime::start_log(kProgram, common.log_level);
  const auto outcome = run(common, rig_options);
  return outcome ? 0 : runtime::report(kProgram, outcome.error());
}
