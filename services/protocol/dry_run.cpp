#include "services/protocol/dry_run.hpp"

#include <iterator>
#include <spdlog/fmt/fmt.h>

namespace tonus::protocol {
namespace {

std::string bias_text(const Block& block) {
  return block.axis == BiasAxis::kNone ? "-"
                                       : fmt::format("{:.2f} N {}", block.bias_force, axis_name(block.axis));
}

std::string or_dash(const std::string& text) { return text.empty() ? "-" : text; }

}  // namespace

Result<DryRun> dry_run(const Protocol& protocol, const RigFacts& facts, std::uint64_t seed) {
  if (protocol.kind == ProtocolKind::kStudy) {
    return refuse_value(protocol, "kind", "\"study\"",
                        "a protocol of one session; a study's parts are files of their own");
  }
  if (auto good = check_against_rig(protocol, facts); !good) return good.error();
  DryRun run{build_plan(protocol, seed), 0.0, extremes_of(protocol, facts)};
  bind_rig(run.plan, protocol, facts.rig_id, facts.home);
  for (const PlannedTrial& trial : run.plan.trials) run.duration += trial.duration;
  return run;
}

std::string to_text(const DryRun& run, const Protocol& protocol) {
  std::string text;
  auto out = std::back_inserter(text);
  const Extremes& e = run.extremes;
  fmt::format_to(out, "{} ({}): {} trials in {} sets, about {:.1f} min of experiment\n", protocol.name,
                 kind_name(protocol.kind), run.plan.trials.size(), run.plan.blocks.size(),
                 run.duration / 60.0);
  if (protocol.kind != ProtocolKind::kRecording) {
    fmt::format_to(out,
                   "workspace: handle {:.3f} to {:.3f} m from the robot's base, allowed {:.3f} to {:.3f} m\n",
                   e.nearest, e.farthest, e.nearest_allowed, e.farthest_allowed);
    if (e.from_centre_allowed > 0.0) {
      fmt::format_to(out, "           up to {:.3f} m from its centre; the rig stops at {:.3f} m\n",
                     e.from_centre, e.from_centre_allowed);
    }
    fmt::format_to(out,
                   "force: bias up to {:.2f} N, allowed {:.1f} N; in all up to {:.1f} N to expect, allowed "
                   "{:.1f} N\n",
                   e.bias, e.bias_allowed, e.force, e.force_allowed);
  }
  fmt::format_to(out, "\n{:<14} {:<14} {:>4} {:>7}  {}\n", "posture", "instruction", "set", "trials", "bias");
  for (const Block& block : run.plan.blocks) {
    const v1::TrialProgram& program = run.plan.trials[block.order.front()].program;
    fmt::format_to(out, "{:<14} {:<14} {:>4} {:>7}  {}\n", program.posture(), or_dash(program.instruction()),
                   block.set_number, block.order.size(), bias_text(block));
  }
  fmt::format_to(out, "\n{:>5}  {:<14} {:>4} {:>13} {:>12} {:>7} {:>7}\n", "trial", "posture", "set",
                 "direction_deg", "amplitude_m", "wait_s", "hold_s");
  for (const PlannedTrial& trial : run.plan.trials) {
    const v1::TrialProgram& p = trial.program;
    fmt::format_to(out, "{:>5}  {:<14} {:>4} {:>13.1f} {:>12.4f} {:>7.2f} {:>7.2f}\n", p.planned_index() + 1,
                   p.posture(), p.set_number(), p.direction_deg(), p.amplitude_m(), p.wait_s(), p.hold_s());
  }
  return text;
}

}  // namespace tonus::protocol
