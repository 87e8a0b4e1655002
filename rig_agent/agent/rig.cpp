#include "rig_agent/agent/rig.hpp"

#include <spdlog/fmt/fmt.h>
#include <utility>

#include "rig_agent/drivers/replay.hpp"
#include "rig_agent/drivers/simulated.hpp"
#include "rig_agent/plant/profile.hpp"
#include "services/recording/dataset.hpp"

namespace tonus::rig {

void add_options(CLI::App& app, RigOptions& options) {
  app.add_option("--driver", options.driver, "hardware: simulated or replay")
      ->check(CLI::IsMember({"simulated", "replay"}))
      ->capture_default_str();
  app.add_option("--profile", options.profile, "TOML file of the simulated rig and subject")
      ->check(CLI::ExistingFile);
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
}

Result<Rig> Rig::create(const RigOptions& options, const std::string& name) {
  Rig rig;
  rig.names_.name = name;
  rig.names_.id = id_of("rig/" + name);
  rig.names_.driver = options.driver;
  auto config = options.driver == "replay" ? rig.open_replay(options) : rig.open_simulated(options);
  if (!config) return config.error();
  rig.names_.loop_rate = config->rate;
  rig.names_.sample_rate = config->rate / config->sample_divider;

  if (auto configured = rig.driver_->configure(1.0 / config->rate); !configured) return configured.error();
  if (auto active = rig.driver_->activate(); !active) return active.error();
  auto loop = control::RigLoop::create(*rig.driver_, *config);
  if (!loop) return loop.error();
  rig.loop_ = std::move(*loop);
  return rig;
}

Result<control::LoopConfig> Rig::open_simulated(const RigOptions& options) {
  plant::Profile profile;
  if (!options.profile.empty()) {
    auto loaded = plant::load_profile(options.profile);
    if (!loaded) return loaded.error();
    profile = *loaded;
  }
  if (options.seed) profile.seed = *options.seed;
  names_.home = profile.manipulandum.home;
  driver_ = std::make_unique<drivers::Simulated>(profile);
  return plant::loop_config(profile);
}

Result<control::LoopConfig> Rig::open_replay(const RigOptions& options) {
  if (options.dataset.empty()) {
    return fail(ErrorCode::kInvalidArgument,
                "--driver replay: --dataset is missing, a BIDS dataset is needed");
  }
  auto records = recording::read_dataset(options.dataset);
  if (!records) return records.error();
  if (options.force_sign != 0) {
    for (auto& record : *records) {
      if (auto stated = recording::state_force_sign(record, options.force_sign); !stated)
        return stated.error();
    }
  }
  auto trials = RecordedTrials::create(std::move(*records));
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
