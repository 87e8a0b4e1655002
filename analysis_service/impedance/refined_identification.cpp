#include "analysis_service/impedance/refined_identification.hpp"

#include <algorithm>
#include <cmath>
#include <spdlog/fmt/fmt.h>
#include <utility>

#include "analysis_service/impedance/force_lag.hpp"
#include "analysis_service/impedance/parameters.hpp"
#include "analysis_service/impedance/student_t.hpp"
#include "analysis_service/impedance/verdict.hpp"
#include "analysis_service/refined/identification.hpp"

namespace tonus::impedance {
namespace {

constexpr double kSignificance = 0.01 / 4.0;  // Four tests: 1 % over all of them.
constexpr double kLargestEffect = 1.0;        // Of a term, in 95 % half-widths of what it changes.
constexpr double kLargestMisfit = 0.05;       // Of the mean response's force.

refined::Trial input_of(const Trial& trial) {
  return {trial.displacement,       trial.force,      trial.commanded, trial.onset,
          trial.displacement_taken, trial.force_taken};
}

std::optional<Reason> failure_of(refined::Shortage shortage) {
  switch (shortage) {
    case refined::Shortage::kNone:
      return std::nullopt;
    case refined::Shortage::kTooFewTrials:
      return Reason::kTooFewTrials;
    case refined::Shortage::kTooFewRows:
      return Reason::kTooFewSamples;
    case refined::Shortage::kNoCommand:
      return Reason::kNoCommand;
    case refined::Shortage::kSingleDirection:
      return Reason::kSingleDirection;
    case refined::Shortage::kNoResponse:
      return Reason::kNoMotion;
    case refined::Shortage::kSingular:
      return Reason::kRankDeficient;
  }
  return Reason::kRankDeficient;
}

void set_numbers(const refined::Estimate& found, Estimate& estimate) {
  const auto axes = static_cast<int>(found.theta.cols());
  const Eigen::Index q = found.theta.rows();
  estimate.value = parameters_from(found.theta, axes);
  estimate.value.X0 = found.X0;
  estimate.covariance = found.covariance->covariance();
  estimate.std = estimate.low = estimate.high = estimate.value;
  const auto set = [&](AxisMatrix Parameters::*matrix, Eigen::Index first) {
    for (Eigen::Index i = 0; i < axes; ++i) {
      for (Eigen::Index j = 0; j < axes; ++j) {
        const auto spread = found.covariance->spread_of(Eigen::VectorXd::Unit(q * axes, i * q + first + j));
        const double half = student_t_factor(0.95, spread.freedom) * spread.std;
        (estimate.std.*matrix)(i, j) = spread.std;
        (estimate.low.*matrix)(i, j) = (estimate.value.*matrix)(i, j) - half;
        (estimate.high.*matrix)(i, j) = (estimate.value.*matrix)(i, j) + half;
      }
    }
  };
  set(&Parameters::M, 0);
  set(&Parameters::B, axes);
  set(&Parameters::K, Eigen::Index{2} * axes);
  estimate.std.X0 = found.X0_std;
  const double factor = student_t_factor(0.95, std::max(1.0, found.X0_freedom));
  estimate.low.X0 = found.X0 - factor * found.X0_std;
  estimate.high.X0 = found.X0 + factor * found.X0_std;
}

struct Finding {
  FitTest test = FitTest::kBands;
  Reason reason = Reason::kMisfit;
  const char* what = "";
};

Finding finding_of(refined::Alternative alternative) {
  switch (alternative) {
    case refined::Alternative::kReflex:
      return {FitTest::kReflex, Reason::kReflex, "a force that follows the velocity of 40 ms ago"};
    case refined::Alternative::kHardening:
      return {FitTest::kHardening, Reason::kHardening, "a force that follows the cube of the displacement"};
    case refined::Alternative::kFriction:
      break;
  }
  return {FitTest::kFriction, Reason::kFriction, "a force that follows the direction of the velocity"};
}

void add_check(FitTest test, double value, double limit, bool is_passed, Reason reason, std::string detail,
               Estimate& estimate) {
  estimate.checks.push_back({test, value, limit, is_passed});
  if (is_passed) return;
  estimate.reasons.push_back(reason);
  estimate.details[reason] = std::move(detail);
}

void check_model(const refined::Estimate& found, Estimate& estimate) {
  const bool is_misfit = found.misfit.p < kSignificance && found.misfit.share > kLargestMisfit;
  add_check(FitTest::kBands, found.misfit.share, kLargestMisfit, !is_misfit, Reason::kMisfit,
            fmt::format("the model leaves {:.3g} % of the force's mean response, at most {:.3g} %",
                        100.0 * found.misfit.share, 100.0 * kLargestMisfit),
            estimate);
  for (const refined::AlternativeTest& test : found.alternatives) {
    const Finding finding = finding_of(test.alternative);
    const bool is_found = test.p < kSignificance && test.effect > kLargestEffect;
    // Without significance the effect is that of noise; the check states it at its limit then.
    const double value = is_found ? test.effect : std::min(test.effect, kLargestEffect);
    add_check(
        finding.test, value, kLargestEffect, !is_found, finding.reason,
        fmt::format("{} is significant and changes an element by {:.2f} of its 95 % half-width, at most "
                    "{:.2f}",
                    finding.what, test.effect, kLargestEffect),
        estimate);
  }
}

void check_data(const Diagnosis& diagnosis, Estimate& estimate) {
  const double explained = estimate.explained.minCoeff();
  add_check(FitTest::kExplainedShare, explained, kLeastExplained, explained >= kLeastExplained,
            Reason::kUnexplained,
            fmt::format("the model explains {:.3g} % of the force, at least {:.3g} %", 100.0 * explained,
                        100.0 * kLeastExplained),
            estimate);
  if (diagnosis.is_lag_examined) {
    const double lag = diagnosis.force_lag.cwiseAbs().maxCoeff();
    const bool is_passed = !diagnosis.is_force_shifted;
    estimate.checks.push_back(
        {FitTest::kLag, lag, is_passed ? std::max(kLagTolerated, lag) : kLagTolerated, is_passed});
  }
  add_check(FitTest::kUnits, static_cast<double>(estimate.units), kFewestUnits,
            estimate.units >= kFewestUnits, Reason::kFewUnits,
            fmt::format("{} independent units, at least {}", estimate.units, kFewestUnits), estimate);
}

}  // namespace

std::optional<Reason> identify_refined(std::span<const Trial* const> trials, const Options& options,
                                       const Diagnosis& diagnosis, Estimate& estimate) {
  std::vector<refined::Trial> inputs;
  for (const Trial* trial : trials) inputs.push_back(input_of(*trial));
  const refined::Settings settings{trials.front()->sample_period, options.window,
                                   trials.front()->handle_mass};
  const refined::Estimate found = refined::identify(inputs, settings);
  estimate.units = trials.size();
  if (const auto failure = failure_of(found.shortage)) return failure;
  estimate.samples = found.rows;
  estimate.condition_number = found.condition;
  if (!(found.condition * options.rank_margin < 1.0)) return Reason::kRankDeficient;
  estimate.sigma = found.sigma;
  estimate.explained = found.explained;
  set_numbers(found, estimate);
  check_data(diagnosis, estimate);
  check_model(found, estimate);
  return std::nullopt;
}

}  // namespace tonus::impedance
