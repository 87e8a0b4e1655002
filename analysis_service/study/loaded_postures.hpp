#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "analysis_service/impedance/modulation.hpp"
#include "analysis_service/impedance/static_stiffness.hpp"

#include <idl/estimate.h>

/// What a loaded session shows beyond its estimates (method, section 8; Fig. 10).
namespace tonus::study {

/// One set under a bias force, against the unloaded posture. Vectors in S.
struct LoadedSet {
  std::int32_t set_number = 0;
  Eigen::Vector2d bias = Eigen::Vector2d::Zero();        ///< N, on the arm, as commanded.
  Eigen::Vector2d predicted = Eigen::Vector2d::Zero();   ///< m, (20): -K_unloaded^-1 F_bias.
  Eigen::Vector2d actual = Eigen::Vector2d::Zero();      ///< m, the set's own spring centre X0.
  Eigen::Vector2d actual_std = Eigen::Vector2d::Zero();  ///< m, standard error.
  impedance::SpringCentreComparison comparison;
  std::optional<impedance::Modulation> stiffness;  ///< None where a matrix is not positive definite.
  std::optional<impedance::Modulation> damping;
  Eigen::Vector2d sigma = Eigen::Vector2d::Zero();  ///< N, fitting error of the set.
};

struct LoadedPosture {
  std::string posture;
  std::uint32_t posture_index = 0;
  std::string method;
  Eigen::Matrix2d K_unloaded = Eigen::Matrix2d::Zero();      ///< N/m, mean of the first and last sets'.
  Eigen::Matrix2d B_unloaded = Eigen::Matrix2d::Zero();      ///< N s/m, likewise.
  Eigen::Vector2d sigma_unloaded = Eigen::Vector2d::Zero();  ///< N, mean of theirs.
  std::vector<LoadedSet> sets;                               ///< By number.
};

/// Of one session's estimates, those of the linear model with two axes: the loaded sets of every posture and
/// method, against the unloaded sets of the same posture and method. A posture without an unloaded set or
/// with a singular stiffness is left out; undetermined estimates are no sets.
[[nodiscard]] std::vector<LoadedPosture> loaded_postures(std::span<const v1::Estimate> estimates);

/// A table for a terminal.
[[nodiscard]] std::string as_text(const LoadedPosture& posture);

}  // namespace tonus::study
