#include "services/cli/command_dry_run.hpp"

#include <Eigen/SVD>
#include <cstdio>

#include "rig_agent/plant/profile.hpp"
#include "services/scheduler/dry_run.hpp"
#include "services/scheduler/protocol_file.hpp"

namespace tonus::cli {
namespace {

constexpr double kHour = 3600.0;  // s

/// What a protocol has to respect of the simulated rig of a profile.
scheduler::RigFacts facts_of(const plant::Profile& profile) {
  const RigGeometry geometry = plant::rig_geometry(profile);
  scheduler::RigFacts facts;
  facts.name = "simulated";
  facts.kind = geometry.kind;
  facts.links = geometry.links;
  facts.home = profile.manipulandum.home;
  facts.force_limit = Eigen::JacobiSVD<Eigen::Matrix2d>(geometry.force_calibration).singularValues()[1] *
                      geometry.force_saturation_V;
  return facts;
}

/// A study's sessions one by one, in a line each.
Result<void> print_study(const scheduler::Protocol& study, const std::filesystem::path& folder,
                         const scheduler::RigFacts& facts) {
  double duration = 0.0;
  std::size_t trials = 0;
  std::printf("%s (study): %zu subjects\n\n", study.name.c_str(), study.subjects.size());
  std::printf("%-12s %-24s %7s %12s %20s %14s\n", "subject", "protocol", "trials", "minutes",
              "handle from base, m", "force up to, N");
  for (const auto& subject : study.subjects) {
    for (const std::string& file : {subject.unloaded, subject.loaded, subject.instruction}) {
      if (file.empty()) continue;
      const auto protocol = scheduler::load_protocol(folder / file);
      if (!protocol) return protocol.error();
      const auto run = scheduler::dry_run(*protocol, facts, subject.seed);
      if (!run) return run.error();
      std::printf("%-12s %-24s %7zu %12.1f %10.3f to %.3f %14.1f\n", subject.name.c_str(), file.c_str(),
                  run->plan.trials.size(), run->duration / 60.0, run->extremes.nearest,
                  run->extremes.farthest, run->extremes.force);
      duration += run->duration;
      trials += run->plan.trials.size();
    }
  }
  std::printf("\n%zu trials, about %.1f h of experiment\n", trials, duration / kHour);
  return {};
}

}  // namespace

Result<void> print_dry_run(const RunOptions& options) {
  const auto protocol = scheduler::load_protocol(options.protocol);
  if (!protocol) return protocol.error();
  plant::Profile profile;
  if (!options.profile.empty()) {
    auto loaded = plant::load_profile(options.profile);
    if (!loaded) return loaded.error();
    profile = *loaded;
  }
  const scheduler::RigFacts facts = facts_of(profile);
  if (protocol->kind == scheduler::ProtocolKind::kStudy) {
    return print_study(*protocol, std::filesystem::path(options.protocol).parent_path(), facts);
  }
  const auto run = scheduler::dry_run(*protocol, facts, options.seed);
  if (!run) return run.error();
  std::fputs(scheduler::to_text(*run, *protocol).c_str(), stdout);
  return {};
}

}  // namespace tonus::cli
