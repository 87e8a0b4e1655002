#include "rig_agent/agent/rig.hpp"

#include <CLI/CLI.hpp>
#include <spdlog/fmt/fmt.h>
#include <spdlog/spdlog.h>
#include <utility>

#include "rig_agent/control/validation.hpp"
#include "rig_agent/drivers/calibrated.hpp"
#ifdef TONUS_HAS_COMEDI
#include "rig_agent/drivers/comedi.hpp"
#endif
#include "rig_agent/drivers/library.hpp"
#include "rig_agent/drivers/replay.hpp"
#include "rig_agent/drivers/simulated.hpp"
#include "services/core/folder.hpp"
#include "services/core/name.hpp"
#include "services/core/places.hpp"
#include "services/core/text.hpp"
#include "services/recording/dataset.hpp"
#include "services/simulation/profile.hpp"

namespace tonus::rig {
namespace {

Result<simulation::Profile> profile_of(const RigOptions& options) {
  if (options.profile.empty()) return simulation::Profile{};
  return simulation::load_profile(options.profile);
}

Error missing_driver_file(const char* driver, const char* what) {
  return fail(ErrorCode::kInvalidArgument,
              fmt::format("--driver {}: --driver-file is missing; expected {}", driver, what));
}

}  // namespace

control::RealtimeRequest RigOptions::realtime() const {
  control::RealtimeRequest request;
  if (fifo_priority == 0) request.fifo_priority.reset();
  if (fifo_priority != 0) request.fifo_priority = fifo_priority;
  request.cpu = loop_cpu;
  return request;
}

Result<std::filesystem::path> RigOptions::own_folder(const std::string& rig) const {
  if (!folder.empty()) return absolute_path(folder);
  if (driver == "simulated" || driver == "replay") return std::filesystem::path();
  return default_rig_folder(rig);
}

void add_options(CLI::App& app, RigOptions& options) {
  app.add_option("--driver", options.driver, "hardware: simulated, replay, library or comedi")
      ->check(CLI::IsMember({"simulated", "replay", "library", "comedi"}))
      ->capture_default_str();
  app.add_option("--profile", options.profile,
                 "TOML file of the rig (loop, limits, control, masses, sensors) and of the simulated subject")
      ->check(CLI::ExistingFile);
  app.add_option("--driver-file", options.driver_file,
                 "library: the shared library; comedi: the TOML file of what is connected")
      ->check(CLI::ExistingFile);
  app.add_option("--driver-options", options.driver_options, "text that is handed to the shared library");
  app.add_option("--dataset", options.dataset, "BIDS dataset that the replay driver plays")
      ->check(CLI::ExistingDirectory);
  app.add_option("--force-sign", options.force_sign,
                 "+1 or -1: sign of a one-axis dataset's force on the limb")
      ->check(CLI::IsMember({-1, 1}));
  app.add_option("--seed", options.seed, "seed of the simulation's noise");
  app.add_option("--speed", options.speed, "real: by the clock; max: as fast as consumers keep up")
      ->check(CLI::IsMember({"real", "max"}))
      ->capture_default_str();
  app.add_option("--spool-MB", options.spool_MB, "size at which no new trial is begun")
      ->check(CLI::Range(1, 1'000'000))
      ->capture_default_str();
  app.add_option(
         "--rig-folder", options.folder,
         "folder of the rig's calibration and hold (default: the machine's for this rig; of a rig that "
         "is simulated or replayed: in the data folder)")
      ->envname("TONUS_RIG_FOLDER");
  app.add_flag("--resume-unattended", options.resumes_unattended,
               "after a fault or a restart go on without an operator; only with a driver that moves nothing "
               "real (simulated, replay)");
  app.add_option("--loop-priority", options.fifo_priority,
                 "SCHED_FIFO priority of the loop; 0: the scheduling is left alone")
      ->check(CLI::Range(0, 99))
      ->capture_default_str();
  app.add_option("--loop-cpu", options.loop_cpu, "the one processor that the loop runs on")
      ->check(CLI::Range(0, 1023));
}

Result<Rig> Rig::create(const RigOptions& options, const std::string& name,
                        const std::filesystem::path& calibration) {
  Rig rig(options.driver);
  rig.names_.name = name;
  rig.names_.id = rig_id(name);
  rig.names_.driver = options.driver;
  auto config = rig.open(options);
  if (!config) return config.error();
  rig.names_.loop_rate = config->rate;
  rig.names_.sample_rate = config->rate / config->sample_divider;
  if (options.driver != "replay") {
    if (auto calibrated = rig.calibrate(calibration); !calibrated) return calibrated.error();
  }

  if (auto configured = rig.driver_->configure(1.0 / config->rate); !configured) return configured.error();
  if (!options.is_paced() && !rig.driver_->capabilities().has_own_clock) {
    return fail(ErrorCode::kInvalidArgument,
                "--speed: max is not allowed; expected real: this driver's clock is not its own");
  }
  if (options.resumes_unattended && !rig.driver_->capabilities().moves_nothing_real) {
    return fail(
        ErrorCode::kInvalidArgument,
        fmt::format("--resume-unattended: driver {} is not allowed; expected one that moves nothing real",
                    options.driver));
  }
  rig.names_.limits_off = control::limits_off(config->limits);
  const auto driver = rig.driver_->capabilities();
  if (driver.actuates) rig.names_.limits = config->limits;
  rig.names_.watchdog = driver.can_disable && !driver.moves_nothing_real ? config->limits.watchdog : 0.0;
  const auto channels = rig.driver_->auxiliary_channels();
  rig.names_.auxiliary_channels.assign(channels.begin(), channels.end());
  rig.names_.marks_onset = driver.marks_onset;
  rig.names_.moves_nothing_real = rig.driver_->capabilities().moves_nothing_real;
  rig.names_.resumes_unattended = options.resumes_unattended;
  if (auto active = rig.driver_->activate(); !active) return active.error();
  auto loop = control::RigLoop::create(*rig.driver_, *config);
  if (!loop) return loop.error();
  rig.loop_ = std::move(*loop);
  return rig;
}

Result<void> Rig::calibrate(const std::filesystem::path& file) {
  if (file.empty()) return {};
  auto calibration = calibration::Calibration::load(file, names_.driver);
  if (!calibration) return calibration.error();
  calibration_ = std::move(*calibration);
  names_.calibrated_at = calibration_.at();
  names_.calibrated_by = calibration_.by();
  names_.calibration_toml = calibration_.text();
  driver_ = std::make_unique<drivers::Calibrated>(
      std::move(driver_),
      [calibration = calibration_](const RigGeometry& geometry) { return calibration.applied_to(geometry); });
  return {};
}

Result<control::LoopConfig> Rig::open(const RigOptions& options) {
  if (options.driver == "replay") return open_replay(options);
  if (options.driver == "library") return open_library(options);
  if (options.driver == "comedi") return open_comedi(options);
  return open_simulated(options);
}

Result<control::LoopConfig> Rig::open_simulated(const RigOptions& options) {
  auto profile = profile_of(options);
  if (!profile) return profile.error();
  if (options.seed) profile->seed = *options.seed;
  names_.home = profile->manipulandum.home;
  driver_ = std::make_unique<drivers::Simulated>(*profile);
  return simulation::loop_config(*profile);
}

Result<control::LoopConfig> Rig::open_library(const RigOptions& options) {
  if (options.driver_file.empty()) return missing_driver_file("library", "a shared library");
  auto profile = profile_of(options);
  if (!profile) return profile.error();
  auto library = drivers::Library::load(options.driver_file, options.driver_options);
  if (!library) return library.error();
  names_.home = profile->manipulandum.home;
  (*library)->state_auxiliary(profile->auxiliary);
  driver_ = std::move(*library);
  return simulation::loop_config(*profile);
}

#ifdef TONUS_HAS_COMEDI
Result<control::LoopConfig> Rig::open_comedi(const RigOptions& options) {
  if (options.driver_file.empty()) return missing_driver_file("comedi", "a TOML file of what is connected");
  auto profile = profile_of(options);
  if (!profile) return profile.error();
  auto wiring = drivers::load_comedi_config(options.driver_file);
  if (!wiring) return wiring.error();
  names_.home = profile->manipulandum.home;
  driver_ =
      std::make_unique<drivers::Comedi>(*wiring, simulation::rig_geometry(*profile), profile->auxiliary);
  return simulation::loop_config(*profile);
}
#else
Result<control::LoopConfig> Rig::open_comedi(const RigOptions&) {
  return fail(ErrorCode::kUnavailable, "--driver comedi: this program was built without libcomedi");
}
#endif

Result<control::LoopConfig> Rig::open_replay(const RigOptions& options) {
  if (options.dataset.empty()) {
    return fail(ErrorCode::kInvalidArgument,
                "--driver replay: --dataset is missing; expected a BIDS dataset");
  }
  TONUS_TRY_ASSIGN(auto usable, recording::read_usable(options.dataset));
  TONUS_TRY(recording::keep_what_counts(usable));
  if (options.force_sign != 0) TONUS_TRY(recording::state_force_sign(usable, options.force_sign));
  for (const auto& item : usable.left_out) spdlog::warn("left out: {}", shown(item));
  auto trials = RecordedTrials::create(std::move(usable.recordings));
  if (!trials) return trials.error();
  recorded_ = std::make_unique<RecordedTrials>(std::move(*trials));
  names_.displacement_unit = recorded_->displacement_unit();
  names_.force_unit = recorded_->force_unit();
  names_.home = recorded_->home();
  control::LoopConfig config;
  config.rate = recorded_->rate();
  config.sample_divider = 1;
  driver_ = std::make_unique<drivers::Replay>(recorded_->take_recording());
  return config;
}

}  // namespace tonus::rig
