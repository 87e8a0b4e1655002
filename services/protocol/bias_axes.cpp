#include "services/protocol/bias_axes.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <spdlog/fmt/fmt.h>

namespace tonus::protocol {
namespace {

/// The sense of a line that has an angle in (-90, 90] deg.
Eigen::Vector2d plus_sense(const Eigen::Vector2d& v) {
  return v.x() < 0.0 || (v.x() == 0.0 && v.y() < 0.0) ? Eigen::Vector2d(-v) : v;
}

}  // namespace

AxesFinding axes_of_stiffness(const Eigen::Matrix2d& stiffness) {
  AxesFinding finding;
  if (!stiffness.allFinite()) {
    finding.reason = "its stiffness is not finite";
    return finding;
  }
  const Eigen::Matrix2d symmetric = 0.5 * (stiffness + stiffness.transpose());
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(symmetric);  // eigenvalues ascending
  const Eigen::Vector2d& values = solver.eigenvalues();
  if (!(values[0] > 0.0)) {
    finding.reason =
        fmt::format("its stiffness is not positive definite, the eigenvalues are {:.1f} and {:.1f} N/m",
                    values[0], values[1]);
    return finding;
  }
  finding.axes = {plus_sense(solver.eigenvectors().col(1)), plus_sense(solver.eigenvectors().col(0))};
  finding.kind = AxesFinding::Kind::kSound;
  if (values[1] - values[0] < kRoundestEllipse * values[1]) {
    finding.kind = AxesFinding::Kind::kDoubtful;
    finding.reason = fmt::format(
        "its stiffness ellipse is a circle, the eigenvalues are {:.1f} and {:.1f} N/m", values[0], values[1]);
  }
  return finding;
}

AxesFinding axes_of_estimate(const v1::Estimate& estimate) {
  std::string reasons;
  for (const std::string& reason : estimate.reasons()) reasons += (reasons.empty() ? "" : ", ") + reason;
  if (estimate.status() == v1::ESTIMATE_UNDETERMINED) {
    AxesFinding finding;
    finding.reason = "it is undetermined" + (reasons.empty() ? "" : ": " + reasons);
    return finding;
  }
  const auto& k = estimate.stiffness_N_per_m().value();
  AxesFinding finding = axes_of_stiffness((Eigen::Matrix2d() << k[0], k[1], k[2], k[3]).finished());
  if (finding.kind == AxesFinding::Kind::kSound && estimate.status() == v1::ESTIMATE_SUSPECT) {
    finding.kind = AxesFinding::Kind::kDoubtful;
    finding.reason = "it is suspect" + (reasons.empty() ? "" : ": " + reasons);
  }
  return finding;
}

bool is_of_set_one(const v1::Estimate& estimate, const Id& session_id, std::uint32_t posture_index,
                   const std::string& method) {
  if (estimate.session_id() != session_id || estimate.posture_index() != posture_index) return false;
  if (estimate.method() != method || estimate.model() != "linear" || !estimate.instruction().empty())
    return false;
  if (estimate.set_number() != 0 && estimate.set_number() != 1) return false;
  // No protocol has a smaller bias; an estimate may state a measured one.
  return Eigen::Vector2d(estimate.bias_N()[0], estimate.bias_N()[1]).norm() < kSmallestBias;
}

std::size_t trials_left_out(const v1::Estimate& estimate, const std::set<std::uint32_t>& attempts) {
  std::size_t used = 0;
  for (const v1::TrialRange& trial : estimate.trials()) used += attempts.count(trial.attempt());
  return attempts.size() - std::min(used, attempts.size());
}

}  // namespace tonus::protocol
