#pragma once

#include <Eigen/Core>
#include <set>
#include <string>

#include "services/core/id.hpp"
#include "services/protocol/plan.hpp"

#include <idl/estimate.h>

namespace tonus::protocol {

/// Two eigenvalues closer than this share of the larger give no axes: the ellipse is a circle (method,
/// section 5).
inline constexpr double kRoundestEllipse = 0.01;

/// Whether set one's stiffness tells where the bias forces have to point.
struct AxesFinding {
  enum class Kind : std::uint8_t {
    kSound,     ///< Use the axes.
    kDoubtful,  ///< The axes may be used if the operator says so; the reason says why he has to be asked.
    kNone,      ///< There are no axes, for this reason.
  };
  Kind kind = Kind::kNone;
  BiasAxes axes;
  std::string reason;
};

/// Axes of the ellipse of K's symmetric part, Ks = (K + K') / 2: eigenvectors, major that of the larger
/// eigenvalue. `stiffness` in N/m, row by row in S. kNone where K is not finite or Ks not positive definite;
/// kDoubtful for a circle.
[[nodiscard]] AxesFinding axes_of_stiffness(const Eigen::Matrix2d& stiffness);

/// axes_of_stiffness of an estimate, with its status: undetermined gives none, suspect is doubtful.
[[nodiscard]] AxesFinding axes_of_estimate(const v1::Estimate& estimate);

/// True if the estimate is that of set one at a posture of this session, or of all sets without bias there,
/// which is the same until the last set: linear model, of `method`, without bias or instruction.
[[nodiscard]] bool is_of_set_one(const v1::Estimate& estimate, const Id& session_id,
                                 std::uint32_t posture_index, const std::string& method);

/// How many of `attempts` (the trials that count) the estimate was made without.
[[nodiscard]] std::size_t trials_left_out(const v1::Estimate& estimate,
                                          const std::set<std::uint32_t>& attempts);

}  // namespace tonus::protocol
