#include "services/cli/command_dry_run.hpp"

#include <Eigen/SVD>
#include <cstdio>

#include "services/cli/expected_trials.hpp"
#include "services/protocol/dry_run.hpp"
#include "services/protocol/protocol_file.hpp"
#include "services/simulation/profile.hpp"

namespace tonus::cli {
namespace {

constexpr double kHour = 3600.0;  // s

/// What a protocol has to respect of the simulated rig of a profile, its limits included.
protocol::RigFacts facts_of(const simulation::Profile& profile) {
  const RigGeometry geometry = simulation::rig_geometry(profile);
  protocol::RigFacts facts;
  facts.name = "simulated";
  facts.kind = geometry.kind;
  facts.links = geometry.links;
  facts.home = profile.manipulandum.home;
  facts.force_limit = Eigen::JacobiSVD<Eigen::Matrix2d>(geometry.force_calibration).singularValues()[1] *
                      geometry.force_saturation_V;
  facts.stops_at = {profile.limits.workspace_centre, profile.limits.workspace_radius, profile.limits.force};
  return facts;
}

/// A study's sessions one by one, in a line each.
Result<void> print_study(const protocol::Protocol& study, const std::filesystem::path& folder,
                         const protocol::RigFacts& facts) {
  double duration = 0.0;
  std::size_t trials = 0;
  std::printf("%s (study): %zu subjects\n\n", study.name.c_str(), study.subjects.size());
  std::printf("%-12s %-24s %7s %12s %20s %14s\n", "subject", "protocol", "trials", "minutes",
              "handle from base, m", "force up to, N");
  for (const auto& subject : study.subjects) {
    for (const std::string& file : {subject.unloaded, subject.loaded, subject.instruction}) {
      if (file.empty()) continue;
      const auto protocol = protocol::load_protocol(folder / file);
      if (!protocol) return protocol.error();
      const auto run = protocol::dry_run(*protocol, facts, subject.seed);
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

/// How many trials a protocol with stop_when is expected to take.
Result<void> print_expected(const RunOptions& options, const protocol::Protocol& protocol,
                            const protocol::Plan& plan, const simulation::Profile& profile) {
  if (!protocol.stop_when) {
    if (options.like.empty()) return {};
    return fail(ErrorCode::kInvalidArgument,
                "--like " + options.like + ": is not allowed; expected a protocol with stop_when");
  }
  if (options.like.empty()) {
    const auto expected = expected_by_simulation(protocol, plan, profile, options.seed);
    std::fputs(to_text(expected, protocol, plan).c_str(), stdout);
    return {};
  }
  TONUS_TRY_ASSIGN(const auto store, open_to_read(options.archive));
  TONUS_TRY_ASSIGN(const auto session, store::read_found_session(*store, options.like));
  std::fputs(to_text(expected_from(protocol, plan, session), protocol, plan).c_str(), stdout);
  return {};
}

}  // namespace

Result<void> print_dry_run(const RunOptions& options) {
  const auto protocol = protocol::load_protocol(options.protocol);
  if (!protocol) return protocol.error();
  simulation::Profile profile;
  if (!options.profile.empty()) {
    auto loaded = simulation::load_profile(options.profile);
    if (!loaded) return loaded.error();
    profile = *loaded;
  }
  const protocol::RigFacts facts = facts_of(profile);
  if (protocol->kind == protocol::ProtocolKind::kStudy) {
    return print_study(*protocol, std::filesystem::path(options.protocol).parent_path(), facts);
  }
  const auto run = protocol::dry_run(*protocol, facts, options.seed);
  if (!run) return run.error();
  std::fputs(protocol::to_text(*run, *protocol).c_str(), stdout);
  return print_expected(options, *protocol, run->plan, profile);
}

}  // namespace tonus::cli
