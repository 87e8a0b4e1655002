#include "services/protocol/rig_facts.hpp"

#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <spdlog/fmt/fmt.h>

#include "services/contract/rig.hpp"

namespace tonus::protocol {
namespace {

/// The largest amplitude that the protocol may command, m, and the key that has it.
struct LargestAmplitude {
  double value = 0.0;
  const char* key = nullptr;
};

LargestAmplitude largest_amplitude(const Protocol& protocol) {
  const Perturbation& p = protocol.perturbation;
  if (protocol.stop_when && protocol.stop_when->amplitude_most > p.amplitude)
    return {protocol.stop_when->amplitude_most, "stop_when.amplitude_most_m"};
  if (p.second_amplitude && *p.second_amplitude > p.amplitude)
    return {*p.second_amplitude, "perturbation.second_amplitude_m"};
  return {p.amplitude, "perturbation.amplitude_m"};
}

bool stops_before_the_sensor(const RigFacts& facts) {
  return facts.stops_at && facts.stops_at->force < facts.force_limit;
}

std::string expected_bias(const RigFacts& facts, double allowed) {
  if (facts.stops_at && kBiasShare * facts.stops_at->force < facts.force_limit) {
    return fmt::format("less: rig '{}' takes biases up to {:g} N, half of the force at which it stops",
                       facts.name, allowed);
  }
  return fmt::format("less: rig '{}' measures up to {:g} N", facts.name, allowed);
}

}  // namespace

Result<RigFacts> facts_of(const v1::RigDescription& description) {
  RigFacts facts;
  facts.rig_id = description.rig_id();
  facts.name = description.name();
  facts.kind = contract::kind_of(description.kind()).value_or(RigKind::kTwoLink);
  facts.links = {description.link_lengths_m()[0], description.link_lengths_m()[1]};
  facts.home = {description.home_m()[0], description.home_m()[1]};
  const auto& c = description.force_calibration_N_per_V();
  const Eigen::Matrix2d calibration = (Eigen::Matrix2d() << c[0], c[1], c[2], c[3]).finished();
  const Eigen::Vector2d scales = Eigen::JacobiSVD<Eigen::Matrix2d>(calibration).singularValues();
  const double worst = facts.kind == RigKind::kOneAxis ? std::abs(c[0]) : scales[1];
  facts.force_limit = worst * description.force_saturation_V();
  if (!description.limits().empty()) {
    const v1::RigLimits& limits = description.limits().front();
    facts.stops_at = {{limits.workspace_centre_m()[0], limits.workspace_centre_m()[1]},
                      limits.workspace_radius_m(),
                      limits.force_N()};
  }

  if (facts.kind != RigKind::kTwoLink) {
    // A replayed recording may state no saturation; what it holds was measured already.
    if (!(facts.force_limit > 0.0)) facts.force_limit = std::numeric_limits<double>::infinity();
    return facts;
  }
  const auto refuse = [&](const char* what, double value, const std::string& allowed) {
    return fail(ErrorCode::kInvalidArgument, fmt::format("rig '{}': {}: {:g} is not allowed; expected {}",
                                                         facts.name, what, value, allowed));
  };
  for (const double length : description.link_lengths_m()) {
    if (!(length > 0.0 && length < 10.0))
      return refuse("link_lengths_m", length, "more than 0, less than 10 m");
  }
  if (!facts.links.reaches(facts.home)) {
    return refuse("distance of home_m from the base", facts.home.norm(),
                  fmt::format("{:g} to {:g} m", std::abs(facts.links.l1 - facts.links.l2),
                              facts.links.l1 + facts.links.l2));
  }
  if (!(facts.force_limit > 0.0)) return refuse("force full scale", facts.force_limit, "more than 0 N");
  return facts;
}

Eigen::Vector2d shoulder_origin(const Eigen::Vector2d& home, double angle, const Eigen::Vector2d& position) {
  return home - Eigen::Rotation2Dd(angle) * position;
}

Extremes extremes_of(const Protocol& protocol, const RigFacts& facts) {
  Extremes e;
  e.nearest_allowed = std::abs(facts.links.l1 - facts.links.l2) + facts.margin;
  e.farthest_allowed = facts.links.l1 + facts.links.l2 - facts.margin;
  e.force_allowed = facts.force_limit;
  e.bias_allowed = facts.force_limit;
  if (facts.stops_at) {
    e.force_allowed = std::min(e.force_allowed, facts.stops_at->force);
    e.bias_allowed = std::min(e.bias_allowed, kBiasShare * facts.stops_at->force);
    e.from_centre_allowed = facts.stops_at->workspace_radius;
  }
  e.nearest = e.farthest = facts.home.norm();
  if (protocol.kind == ProtocolKind::kRecording || protocol.kind == ProtocolKind::kStudy) return e;

  const Perturbation& p = protocol.perturbation;
  const double excursion = kExcursionOverAmplitude * largest_amplitude(protocol).value;
  for (int k = 0; k < p.directions; ++k) {
    const double direction =
        (p.first_direction + 360.0 * k / p.directions) * std::numbers::pi / 180.0 + protocol.shoulder_angle;
    const Eigen::Vector2d reached =
        facts.home + excursion * Eigen::Vector2d(std::cos(direction), std::sin(direction));
    e.nearest = std::min(e.nearest, reached.norm());
    e.farthest = std::max(e.farthest, reached.norm());
  }
  if (facts.stops_at) e.from_centre = (facts.home - facts.stops_at->workspace_centre).norm() + excursion;
  e.bias = protocol.bias ? protocol.bias->force.high : 0.0;
  e.force = e.bias + kStiffestArm * excursion;
  return e;
}

Result<void> check_against_rig(const Protocol& protocol, const RigFacts& facts) {
  if (protocol.kind == ProtocolKind::kRecording || protocol.kind == ProtocolKind::kStudy) return {};
  const Extremes e = extremes_of(protocol, facts);
  const Perturbation& p = protocol.perturbation;
  const auto [amplitude, amplitude_key] = largest_amplitude(protocol);
  if (facts.kind == RigKind::kOneAxis) {
    if (p.directions > 2) {
      return refuse_value(protocol, "perturbation.directions", std::to_string(p.directions),
                          fmt::format("1 to 2 on the one-axis rig '{}'", facts.name));
    }
    if (protocol.bias) {
      return refuse_value(
          protocol, "kind", "\"loaded\"",
          fmt::format("unloaded: rig '{}' has one axis, and its stiffness no ellipse", facts.name));
    }
    return {};  // its units may be rad and N m: no force to expect
  }
  if (facts.kind == RigKind::kTwoLink && (e.nearest < e.nearest_allowed || e.farthest > e.farthest_allowed)) {
    return refuse_value(
        protocol, amplitude_key, fmt::format("{:g}", amplitude),
        fmt::format("less: rig '{}' reaches {:.3f} to {:.3f} m from its base, and excursions of "
                    "{:g} m about its home take it from {:.3f} to {:.3f} m",
                    facts.name, e.nearest_allowed, e.farthest_allowed, kExcursionOverAmplitude * amplitude,
                    e.nearest, e.farthest));
  }
  if (facts.stops_at && e.from_centre > e.from_centre_allowed) {
    return refuse_value(
        protocol, amplitude_key, fmt::format("{:g}", amplitude),
        fmt::format(
            "less: rig '{}' stops at {:g} m from the centre of its workspace, and excursions of {:g} m "
            "about its home take it to {:.3f} m",
            facts.name, e.from_centre_allowed, kExcursionOverAmplitude * amplitude, e.from_centre));
  }
  if (e.bias > e.bias_allowed) {
    return refuse_value(protocol, "bias.force_N", fmt::format("{:g}", e.bias),
                        expected_bias(facts, e.bias_allowed));
  }
  if (e.force > e.force_allowed) {
    return refuse_value(protocol, amplitude_key, fmt::format("{:g}", amplitude),
                        fmt::format("less: rig '{}' {} {:g} N, and the force may reach {:g} N", facts.name,
                                    stops_before_the_sensor(facts) ? "stops at" : "measures up to",
                                    e.force_allowed, e.force));
  }
  return {};
}

}  // namespace tonus::protocol
