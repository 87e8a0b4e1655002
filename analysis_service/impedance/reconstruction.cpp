#include "analysis_service/impedance/reconstruction.hpp"

#include <algorithm>
#include <cmath>
#include <spdlog/fmt/fmt.h>

#include "analysis_service/impedance/fit_signals.hpp"

namespace tonus::impedance {

Result<AxisVector> reconstruction_error(std::span<const Trial> trials, const Estimate& estimate,
                                        const Options& options) {
  if (estimate.status == Status::kUndetermined) {
    return fail(ErrorCode::kInvalidArgument,
                "reconstruction: an undetermined estimate is not allowed; expected a determined one");
  }
  Options lowpass = options;
  lowpass.method = Method::kLowpass;
  lowpass.model = estimate.model;
  lowpass.is_force_filtered = false;
  const Parameters& p = estimate.value;
  AxisVector squares = AxisVector::Zero(estimate.axes);
  Eigen::Index samples = 0;
  for (const Trial& trial : trials) {
    const auto& used = estimate.trials_used;
    if (std::find(used.begin(), used.end(), trial.number) == used.end()) continue;
    if (auto valid = validate(lowpass, trial.sample_period); !valid) return valid.error();
    const Eigen::Index first = trial.is_continuous ? 0 : trial.onset;
    const Eigen::Index rows = trial.is_continuous
                                  ? trial.samples()
                                  : std::min<Eigen::Index>(std::llround(options.window / trial.sample_period),
                                                           trial.samples() - first);
    const FitSignals s = fit_signals(trial, lowpass, 0.0);
    Eigen::MatrixXd error = s.force - s.acceleration * p.M.transpose() -
                            (s.displacement.rowwise() - p.X0.transpose()) * p.K.transpose();
    if (s.velocity_terms.cols() > 0) error -= s.velocity_terms * p.B.transpose();
    squares += error.middleRows(first, rows).colwise().squaredNorm().transpose();
    samples += rows;
  }
  if (samples == 0) {
    return fail(ErrorCode::kInvalidArgument,
                fmt::format("reconstruction: none of {} trials is one of the estimate's", trials.size()));
  }
  return AxisVector((squares / static_cast<double>(samples)).cwiseSqrt());
}

}  // namespace tonus::impedance
