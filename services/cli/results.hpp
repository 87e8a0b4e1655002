#pragma once

#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "analysis_service/study/loaded_postures.hpp"
#include "services/simulation/true_impedance.hpp"

#include <idl/estimate.h>

/// Estimates as a person reads them, and as programs do.
namespace tonus::cli {

/// The truth of a simulated posture, where there is one.
using Truth = std::function<std::optional<simulation::CartesianImpedance>(const v1::Estimate&)>;

/// A block of lines: matrices with standard errors and, where known, the simulated truth beside them;
/// ellipses, curl, spring centre, fitting error.
[[nodiscard]] std::string as_text(const v1::Estimate& estimate, const Truth& truth);

/// One object for each posture and method that was measured under bias forces, with its sets: actual and
/// predicted spring centres, modulation of K and B. Units in the keys.
[[nodiscard]] nlohmann::json as_json(const std::vector<study::LoadedPosture>& postures);

}  // namespace tonus::cli
