#include "services/cli/system.hpp"

#include <CLI/CLI.hpp>
#include <cstdio>
#include <utility>

#include "services/core/installation.hpp"

namespace tonus::cli {
namespace {

class Arguments {
 public:
  Arguments& add(const std::string& option, const std::string& value) {
    if (!value.empty()) {
      list_.push_back(option);
      list_.push_back(value);
    }
    return *this;
  }
  [[nodiscard]] std::vector<std::string> take() { return std::move(list_); }

 private:
  std::vector<std::string> list_;
};

Arguments common_arguments(const runtime::CommonOptions& common, const std::filesystem::path& data,
                           const std::string& dds) {
  Arguments arguments;
  arguments.add("--domain", std::to_string(common.domain))
      .add("--dds", dds)
      .add("--rig", common.rig)
      .add("--data", data.string())
      .add("--log", common.log_level)
      .add("--config", common.configuration_file);
  arguments.add("--security", common.security).add("--interface", common.interface);
  for (const auto& peer : common.peers) arguments.add("--peers", peer);
  for (const auto& server : common.discovery_servers) arguments.add("--discovery-servers", server);
  return arguments;
}

std::vector<ServiceCommand> services(const SystemOptions& o, const std::filesystem::path& data) {
  const auto folder = installation().programs;
  const auto common = [&] { return common_arguments(o.common, data, o.common.dds); };
  const std::string rig_dds = o.rig_dds.empty() ? o.common.dds : o.rig_dds;
  std::vector<ServiceCommand> all{
      {"archive", folder / "tonus-archive", common().add("--store", o.store).take(), true},
      {"identification", folder / "tonus-identification",
       common()
           .add("--natural-frequency", o.natural_frequency)
           .add("--damping-ratio", o.damping_ratio)
           .add("--window", o.window)
           .add("--method", o.method)
           .take()},
      {"scheduler", folder / "tonus-scheduler", common().take()},
      {"rig-agent", folder / "tonus-rig-agent",
       common_arguments(o.common, data, rig_dds)
           .add("--driver", o.driver)
           .add("--driver-file", o.driver_file)
           .add("--driver-options", o.driver_options)
           .add("--profile", o.profile)
           .add("--dataset", o.dataset)
           .add("--force-sign", o.force_sign)
           .add("--seed", o.seed)
           .add("--speed", o.speed)
           .add("--loop-cpu", o.loop_cpu)
           .add("--loop-priority", o.loop_priority)
           .take()},
  };
  if (o.resumes_unattended) all.back().arguments.emplace_back("--resume-unattended");
  if (o.has_dashboard) {
    auto dashboard = common();
    dashboard.add("--store", o.store)
        .add("--listen", o.dashboard_listen)
        .add("--tokens", o.dashboard_tokens)
        .add("--tls-certificate", o.dashboard_certificate)
        .add("--tls-key", o.dashboard_key);
    for (const auto& origin : o.dashboard_origins) dashboard.add("--allow-origin", origin);
    all.push_back({"dashboard", folder / "tonus-dashboard", dashboard.take()});
  }
  return all;
}

void add_rig_options(CLI::App& app, SystemOptions& o) {
  app.add_option("--rig-dds", o.rig_dds, "DDS implementation of the rig agent, where it differs")
      ->check(CLI::IsMember({"fastdds", "cyclonedds"}));
  app.add_option("--speed", o.speed, "real: by the clock; max: as fast as the services keep up")
      ->check(CLI::IsMember({"real", "max"}))
      ->capture_default_str();
  app.add_option("--driver", o.driver, "hardware of the rig: simulated, replay, library or comedi")
      ->check(CLI::IsMember({"simulated", "replay", "library", "comedi"}))
      ->capture_default_str();
  app.add_option("--driver-file", o.driver_file, "of the library and comedi drivers")
      ->check(CLI::ExistingFile);
  app.add_option("--driver-options", o.driver_options, "handed to the library driver");
  app.add_option("--profile", o.profile, "TOML file of the simulated rig and subject")
      ->check(CLI::ExistingFile);
  app.add_option("--dataset", o.dataset, "BIDS dataset to play")->check(CLI::ExistingDirectory);
  app.add_option("--force-sign", o.force_sign, "+1 or -1: sign of a one-axis dataset's force on the limb")
      ->check(CLI::IsMember({"-1", "1", "+1"}));
  app.add_option("--rig-seed", o.seed, "seed of the simulated rig's noise")->check(CLI::NonNegativeNumber);
  app.add_option("--loop-cpu", o.loop_cpu, "the one processor that the rig's loop runs on")
      ->check(CLI::Range(0, 1023));
  app.add_option("--loop-priority", o.loop_priority,
                 "SCHED_FIFO priority of the rig's loop; 0: the scheduling is left alone")
      ->check(CLI::Range(0, 99));
}

void add_unattended_option(CLI::App& app, SystemOptions& o) {
  app.add_flag("--resume-unattended", o.resumes_unattended,
               "after a fault or a restart go on without an operator; only with a driver that moves nothing "
               "real (simulated, replay)");
}

void add_identification_options(CLI::App& app, SystemOptions& o) {
  app.add_option("--natural-frequency", o.natural_frequency,
                 "of the state-variable filter, Hz; default: from the data")
      ->check(CLI::PositiveNumber);
  app.add_option("--damping-ratio", o.damping_ratio, "of the state-variable filter")
      ->check(CLI::PositiveNumber);
  app.add_option("--window", o.window, "s from onset that are fitted")->check(CLI::PositiveNumber);
  app.add_option("--method", o.method, "auto, lowpass, optimal, state_variable, refined, spectral or all");
}

void add_dashboard_options(CLI::App& app, SystemOptions& o) {
  auto* dashboard = app.add_flag("--dashboard", o.has_dashboard,
                                 "serve the pages, too: operator, results, subject, archive");
  app.add_option("--dashboard-listen", o.dashboard_listen, "its ADDRESS:PORT (default: 127.0.0.1:8765)")
      ->needs(dashboard);
  app.add_option("--dashboard-tokens", o.dashboard_tokens,
                 "who may view and operate, on a lab network: TOML file")
      ->needs(dashboard)
      ->check(CLI::ExistingFile);
  auto* certificate = app.add_option("--dashboard-tls-certificate", o.dashboard_certificate,
                                     "PEM file: certificate with its chain")
                          ->needs(dashboard)
                          ->check(CLI::ExistingFile);
  auto* key = app.add_option("--dashboard-tls-key", o.dashboard_key, "PEM file: its private key")
                  ->needs(certificate)
                  ->check(CLI::ExistingFile);
  certificate->needs(key);
  app.add_option("--dashboard-allow-origin", o.dashboard_origins,
                 "other pages that may connect, e.g. https://app.foxglove.dev")
      ->needs(dashboard);
}

}  // namespace

void add_system_options(CLI::App& app, SystemOptions& o) {
  runtime::add_common_options(app, o.common);
  add_rig_options(app, o);
  add_unattended_option(app, o);
  add_identification_options(app, o);
  app.add_option("--store", o.store, "archive: a file, or postgresql://USER@HOST/DATABASE");
  add_dashboard_options(app, o);
}

Result<System> System::start(const SystemOptions& options, const Clock& clock) {
  auto lock = MachineLock::take("domain " + std::to_string(options.common.domain));
  if (!lock) {
    return fail(lock.error().code, "--" + lock.error().message + "; expected another domain, from 0 to 232");
  }
  auto data = runtime::data_folder(options.common);
  if (!data) return data.error();
  auto supervisor = Supervisor::start(services(options, *data), *data / "logs", clock);
  if (!supervisor) return supervisor.error();
  return System(std::move(*lock), std::move(*data), std::move(*supervisor));
}

Result<void> System::supervise(const char* program) {
  auto news = supervisor_.poll();
  if (!news) return news.error();
  for (const auto& line : *news) std::fprintf(stderr, "%s: %s\n", program, line.c_str());
  return {};
}

}  // namespace tonus::cli
