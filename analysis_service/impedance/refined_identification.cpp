#include "analysis_service/impedance/refined_identification.hpp"

#include <algorithm>
#include <cmath>
#include <spdlog/fmt/fmt.h>
#include <utility>

#include "analysis_service/impedance/condition_response.hpp"
#include "analysis_service/impedance/model_tests.hpp"
#include "analysis_service/impedance/parameters.hpp"
#include "analysis_service/impedance/uncertainty.hpp"
#include "analysis_service/impedance/verdict.hpp"
#include "analysis_service/refined/identification.hpp"
#include "analysis_service/statistics/distributions.hpp"

namespace tonus::impedance {
namespace {

constexpr double kLargestWidth = 0.5;   // 95 % half-width, of the matrix's largest element.
constexpr double kNormalFactor = 1.96;  // 95 % of a normal distribution.

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
        const double half = statistics::student_t_factor(0.95, spread.freedom) * spread.std;
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
  const double factor = statistics::student_t_factor(0.95, std::max(1.0, found.X0_freedom));
  estimate.low.X0 = found.X0 - factor * found.X0_std;
  estimate.high.X0 = found.X0 + factor * found.X0_std;
  estimate.X0_covariance = found.X0_covariance;
  const auto spread_of = [&](const Eigen::VectorXd& weights) {
    const refined::Spread spread = found.covariance->spread_of(weights);
    return CombinationSpread{spread.std, spread.freedom};
  };
  set_uncertainty_of_theta(estimate.covariance, spread_of, estimate);
}

/// Force that follows no motion gives intervals as wide as the matrix.
void check_width(Estimate& estimate) {
  double widest = 0.0;
  for (AxisMatrix Parameters::*matrix : {&Parameters::M, &Parameters::B, &Parameters::K}) {
    const double half = 0.5 * (estimate.high.*matrix - estimate.low.*matrix).cwiseAbs().maxCoeff();
    widest = std::max(widest, half / (estimate.value.*matrix).cwiseAbs().maxCoeff());
  }
  add_check(FitTest::kWidth, widest, kLargestWidth, widest <= kLargestWidth, Reason::kWide,
            fmt::format("a 95 % half-width is {:.3g} % of the matrix's largest element, at most {:.3g} %; "
                        "measure more trials",
                        100.0 * widest, 100.0 * kLargestWidth),
            estimate);
}

/// What the trials scatter about the model is in the intervals: explained is asked of their mean response.
void check_data(const refined::Estimate& found, Estimate& estimate) {
  const double explained = estimate.explained.minCoeff();
  const bool is_explained = explained >= kLeastExplained || found.misfit.p >= kModelSignificance;
  add_check(FitTest::kExplainedShare, explained,
            is_explained ? std::min(kLeastExplained, explained) : kLeastExplained, is_explained,
            Reason::kUnexplained,
            fmt::format("the model explains {:.3g} % of the force's mean response, at least {:.3g} %",
                        100.0 * explained, 100.0 * kLeastExplained),
            estimate);
  check_width(estimate);
  add_check(FitTest::kUnits, static_cast<double>(estimate.units), kFewestUnits,
            estimate.units >= kFewestUnits, Reason::kFewUnits,
            fmt::format("{} independent units, at least {}", estimate.units, kFewestUnits), estimate);
}

}  // namespace

refined::Estimate find_refined(std::span<const Trial* const> trials, const Options& options) {
  std::vector<refined::Trial> inputs;
  for (const Trial* trial : trials) inputs.push_back(input_of(*trial));
  const refined::Settings settings{trials.front()->sample_period, options.window,
                                   trials.front()->handle_mass};
  return refined::identify(inputs, settings);
}

std::optional<refined::Estimate> tests_by_mean_motion(std::span<const Trial* const> trials,
                                                      const Options& options) {
  const bool is_testable =
      options.model == Model::kLinear && trials.size() >= kFewestTested &&
      std::ranges::none_of(trials, [](const Trial* trial) { return trial->is_continuous; });
  if (!is_testable) return std::nullopt;
  const Eigen::MatrixXd means = means_over_window(
      trials, options.window, [](const Trial& trial) -> const Signals& { return trial.displacement; });
  Eigen::Index rest = trials.front()->onset;
  Eigen::Index moving = trials.front()->samples() - rest;
  for (const Trial* trial : trials) {
    rest = std::min(rest, trial->onset);
    moving = std::min(moving, trial->samples() - trial->onset);
  }
  Eigen::VectorXd shape = Eigen::VectorXd::Zero(rest + moving);
  for (std::size_t g = 0; g < trials.size(); ++g)
    shape += trials[g]->displacement.middleRows(trials[g]->onset - rest, shape.size()) *
             means.row(static_cast<Eigen::Index>(g)).transpose();
  shape /= std::max(means.squaredNorm(), 1e-300);
  std::vector<refined::Trial> inputs;
  for (std::size_t g = 0; g < trials.size(); ++g) {
    inputs.push_back(input_of(*trials[g]));
    inputs.back().commanded = Signals::Zero(trials[g]->samples(), trials[g]->axes());
    inputs.back().commanded.middleRows(trials[g]->onset - rest, shape.size()) =
        shape * means.row(static_cast<Eigen::Index>(g));
  }
  refined::Estimate found =
      refined::identify(inputs, {trials.front()->sample_period, options.window, trials.front()->handle_mass});
  if (found.shortage != refined::Shortage::kNone) return std::nullopt;
  return found;
}

void widen_by_process(std::span<const Trial> trials, const Options& options, Estimate& estimate) {
  if (estimate.method != Method::kRefined || estimate.status == Status::kUndetermined) return;
  std::vector<const Trial*> used;
  for (const std::uint32_t number : estimate.trials_used) {
    const auto trial = std::ranges::find(trials, number, &Trial::number);
    if (trial != trials.end()) used.push_back(&*trial);
  }
  const refined::Estimate found = find_refined(used, options);
  if (!found.covariance) return;
  const Eigen::VectorXd half = kNormalFactor * found.covariance->model_covariance().diagonal().cwiseSqrt();
  const Eigen::Index axes = found.theta.cols();
  const auto widen = [&](AxisMatrix Parameters::*matrix, Eigen::Index first) {
    for (Eigen::Index i = 0; i < axes; ++i) {
      for (Eigen::Index j = 0; j < axes; ++j) {
        const double value = (estimate.value.*matrix)(i, j);
        const double by_process = half[i * found.theta.rows() + first + j];
        double& low = (estimate.low.*matrix)(i, j);
        double& high = (estimate.high.*matrix)(i, j);
        low = std::min(low, value - by_process);
        high = std::max(high, value + by_process);
      }
    }
  };
  widen(&Parameters::M, 0);
  widen(&Parameters::B, axes);
  widen(&Parameters::K, Eigen::Index{2} * axes);
}

std::optional<Reason> identify_refined(const refined::Estimate& found, std::size_t trials,
                                       const Options& options, Estimate& estimate) {
  estimate.units = trials;
  if (const auto failure = failure_of(found.shortage)) return failure;
  estimate.samples = found.rows;
  estimate.condition_number = found.condition;
  if (!(found.condition * options.rank_margin < 1.0)) return Reason::kRankDeficient;
  estimate.sigma = found.sigma;
  estimate.explained = found.misfit.explained;
  set_numbers(found, estimate);
  check_data(found, estimate);
  check_against_model(found, estimate);
  return std::nullopt;
}

}  // namespace tonus::impedance
