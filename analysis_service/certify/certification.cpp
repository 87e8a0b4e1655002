#include "analysis_service/certify/certification.hpp"

#include <Eigen/Dense>
#include <atomic>
#include <cmath>
#include <iterator>
#include <limits>
#include <mutex>
#include <random>
#include <spdlog/fmt/fmt.h>
#include <tuple>
#include <utility>

#include "analysis_service/certify/bound.hpp"
#include "analysis_service/certify/imperfect_arm.hpp"
#include "analysis_service/impedance/ellipse.hpp"
#include "analysis_service/impedance/identification.hpp"
#include "analysis_service/impedance/method_bias.hpp"
#include "analysis_service/impedance/parameters.hpp"
#include "analysis_service/impedance/refined_identification.hpp"
#include "analysis_service/impedance/uncertainty.hpp"
#include "analysis_service/statistics/distributions.hpp"
#include "services/core/parallel.hpp"

namespace tonus::certify {
namespace {

constexpr Eigen::Index kElements = 14;  // M, B, K column by column, X0

Eigen::Index matrix_of(Eigen::Index element) { return element / 4; }  // 12 and 13: X0

/// A condition of known truth, and what bounds its errors.
struct Simulated {
  std::vector<impedance::Trial> trials;
  impedance::CartesianImpedance arm;
  impedance::CartesianImpedance slow;
  Eigen::VectorXd bound;  // 12; 0: not known
  double window = 1.0;
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();  // m
};

/// One method's result in one condition.
struct Outcome {
  bool is_determined = false;
  bool is_suspect = false;
  Eigen::VectorXd error;          // as a share of the largest element; m for X0
  Eigen::VectorXd bound;          // 12, alike
  Eigen::VectorXd inside;         // 1 or 0
  Eigen::VectorXd inside_secant;  // of K
  bool is_right = false;
  bool is_right_slow = false;
  Eigen::VectorXd half;
  Eigen::Matrix<double, 4, 3> inside_ellipse;  // by number, of M, B, K: 1, 0; not finite: no interval
};

double is_inside(const impedance::Interval& interval, double truth) {
  if (!std::isfinite(interval.low) || !std::isfinite(interval.high))
    return std::numeric_limits<double>::quiet_NaN();
  return interval.low <= truth && truth <= interval.high ? 1.0 : 0.0;
}

Eigen::Vector4d inside_ellipse(const std::optional<impedance::EllipseIntervals>& intervals,
                               const Eigen::Matrix2d& truth) {
  const auto ellipse = impedance::ellipse_of(truth);
  const auto curl = impedance::curl_of(truth);
  if (!intervals || !ellipse || !curl)
    return Eigen::Vector4d::Constant(std::numeric_limits<double>::quiet_NaN());
  const impedance::Interval& turned = intervals->orientation;
  const double middle = 0.5 * (turned.low + turned.high);
  const double orientation = middle + impedance::rotation_between(middle, ellipse->orientation);
  // A curl or shape at the end of what is possible is met to rounding.
  constexpr double kRounding = 1e-9;
  return {is_inside(intervals->size, ellipse->size),
          is_inside({intervals->shape.low - kRounding, intervals->shape.high}, ellipse->shape),
          is_inside(turned, orientation),
          is_inside({intervals->curl.low - kRounding, intervals->curl.high}, curl->p_mean)};
}

/// Whether all of M, B, K lie in their 99.9 % intervals.
bool is_right(const impedance::Estimate& estimate, const impedance::CartesianImpedance& truth) {
  const auto holds = [&](impedance::AxisMatrix impedance::Parameters::*matrix,
                         const Eigen::Matrix2d& expected) {
    const double freedom = impedance::uncertainty_of(estimate, matrix).freedom;
    const double wider =
        0.5 *
        (statistics::student_t_factor(0.999, freedom) / statistics::student_t_factor(0.95, freedom) - 1.0);
    const Eigen::Array22d low = (estimate.low.*matrix).array();
    const Eigen::Array22d high = (estimate.high.*matrix).array();
    const Eigen::Array22d more = wider * (high - low);
    return (low - more <= expected.array()).all() && (expected.array() <= high + more).all();
  };
  return holds(&impedance::Parameters::M, truth.M) && holds(&impedance::Parameters::B, truth.B) &&
         holds(&impedance::Parameters::K, truth.K);
}

Outcome outcome_of(const impedance::Estimate& estimate, const Simulated& simulated) {
  const impedance::CartesianImpedance& arm = simulated.arm;
  Outcome outcome;
  outcome.is_determined = estimate.status != impedance::Status::kUndetermined;
  outcome.is_suspect = estimate.status == impedance::Status::kSuspect;
  if (!outcome.is_determined) return outcome;
  Eigen::VectorXd expected = Eigen::VectorXd::Zero(kElements);
  expected << arm.M.reshaped(), arm.B.reshaped(), arm.K.reshaped(), simulated.centre;
  Eigen::VectorXd scale = Eigen::VectorXd::Ones(kElements);
  for (Eigen::Index matrix = 0; matrix < 3; ++matrix)
    scale.segment(4 * matrix, 4).setConstant(expected.segment(4 * matrix, 4).cwiseAbs().maxCoeff());
  const Eigen::VectorXd low = impedance::flatten(estimate.low);
  const Eigen::VectorXd high = impedance::flatten(estimate.high);
  outcome.error = (impedance::flatten(estimate.value) - expected).cwiseQuotient(scale);
  outcome.half = (0.5 * (high - low)).cwiseQuotient(scale);
  outcome.bound = simulated.bound.cwiseQuotient(scale.head(12));
  outcome.inside = (low.array() <= expected.array() && expected.array() <= high.array()).cast<double>();
  outcome.is_right = is_right(estimate, arm);
  outcome.is_right_slow = is_right(estimate, simulated.slow);
  const Eigen::ArrayXd stiffness = simulated.slow.K.reshaped();
  outcome.inside_secant =
      (low.segment(8, 4).array() <= stiffness && stiffness <= high.segment(8, 4).array()).cast<double>();
  outcome.inside_ellipse << inside_ellipse(estimate.uncertainty.M.ellipse, arm.M),
      inside_ellipse(estimate.uncertainty.B.ellipse, arm.B),
      inside_ellipse(estimate.uncertainty.K.ellipse, arm.K);
  return outcome;
}

/// Share of the elements of all conditions that an ok estimate's interval misses.
template <typename Inside>
double wrong_and_ok(const std::vector<Outcome>& outcomes, const Inside& inside) {
  double sum = 0.0;
  for (const Outcome& outcome : outcomes)
    sum += outcome.is_determined && !outcome.is_suspect ? 1.0 - inside(outcome).mean() : 0.0;
  return outcomes.empty() ? 0.0 : sum / static_cast<double>(outcomes.size());
}

/// Mean over conditions of `value(outcome)`, and its standard error.
template <typename Value>
std::pair<double, double> mean_of(const std::vector<Outcome>& outcomes, const Value& value) {
  double sum = 0.0;
  double squares = 0.0;
  double count = 0.0;
  for (const Outcome& outcome : outcomes) {
    if (!outcome.is_determined) continue;
    const double v = value(outcome);
    if (!std::isfinite(v)) continue;
    sum += v;
    squares += v * v;
    count += 1.0;
  }
  if (count < 2.0) return {0.0, 0.0};
  const double mean = sum / count;
  return {mean, std::sqrt(std::max(0.0, squares / count - mean * mean) / (count - 1.0))};
}

MatrixWorth worth_of(const std::vector<Outcome>& outcomes, Eigen::Index matrix) {
  const Eigen::Index first = 4 * matrix;
  const Eigen::Index size = std::min<Eigen::Index>(4, kElements - first);
  MatrixWorth worth;
  double squares = 0.0;
  double ratios = 0.0;
  for (Eigen::Index i = first; i < first + size; ++i) {
    const auto [bias, error] = mean_of(outcomes, [&](const Outcome& o) { return o.error[i]; });
    if (std::abs(bias) >= std::abs(worth.bias)) {
      worth.bias = bias;
      worth.bias_error = error;
    }
    const double square = mean_of(outcomes, [&](const Outcome& o) { return o.error[i] * o.error[i]; }).first;
    squares += square / static_cast<double>(size);
    if (matrix_of(i) == 3) continue;
    const double limit = mean_of(outcomes, [&](const Outcome& o) { return o.bound[i] * o.bound[i]; }).first;
    const double ratio = limit > 0.0 ? std::sqrt(square / limit) : 0.0;
    ratios += ratio / static_cast<double>(size);
    worth.worst_over_bound = std::max(worth.worst_over_bound, ratio);
  }
  worth.rmse = std::sqrt(squares);
  worth.over_bound = ratios;
  std::tie(worth.coverage, worth.coverage_error) =
      mean_of(outcomes, [&](const Outcome& o) { return o.inside.segment(first, size).mean(); });
  worth.half_width =
      mean_of(outcomes, [&](const Outcome& o) { return o.half.segment(first, size).mean(); }).first;
  worth.wrong_and_ok =
      wrong_and_ok(outcomes, [&](const Outcome& o) { return o.inside.segment(first, size); });
  return worth;
}

EllipseWorth worth_of_number(const std::vector<Outcome>& outcomes, Eigen::Index number, Eigen::Index matrix) {
  const auto inside = [&](const Outcome& o) { return o.inside_ellipse(number, matrix); };
  EllipseWorth worth;
  std::tie(worth.coverage, worth.coverage_error) = mean_of(outcomes, inside);
  worth.determined =
      mean_of(outcomes, [&](const Outcome& o) { return std::isfinite(inside(o)) ? 1.0 : 0.0; }).first;
  return worth;
}

std::vector<impedance::Options> analyses_of(double window) {
  std::vector<impedance::Options> analyses;
  for (const auto method : impedance::kPerturbationMethods) {
    analyses.emplace_back();
    analyses.back().method = method;
    analyses.back().window = window;
    analyses.back().has_trace = false;
  }
  return analyses;
}

MethodWorth worth_of_method(impedance::Method method, const std::vector<Outcome>& outcomes) {
  MethodWorth worth;
  worth.method = method;
  worth.conditions = outcomes.size();
  for (const Outcome& outcome : outcomes) {
    worth.undetermined += outcome.is_determined ? 0 : 1;
    worth.suspect += outcome.is_suspect ? 1 : 0;
    const bool is_refused = !outcome.is_determined || outcome.is_suspect;
    worth.refused += is_refused ? 1 : 0;
    if (is_refused) continue;
    worth.right += outcome.is_right || outcome.is_right_slow ? 1 : 0;
    worth.right_slow += !outcome.is_right && outcome.is_right_slow ? 1 : 0;
    worth.wrong += !outcome.is_right && !outcome.is_right_slow ? 1 : 0;
  }
  for (Eigen::Index matrix = 0; matrix < 4; ++matrix)
    worth.matrices[static_cast<std::size_t>(matrix)] = worth_of(outcomes, matrix);
  for (std::size_t matrix = 0; matrix < worth.ellipses.size(); ++matrix) {
    for (std::size_t number = 0; number < kEllipseNumbers.size(); ++number)
      worth.ellipses[matrix][number] =
          worth_of_number(outcomes, static_cast<Eigen::Index>(number), static_cast<Eigen::Index>(matrix));
  }
  worth.wrong_and_ok_secant = wrong_and_ok(outcomes, [](const Outcome& o) { return o.inside_secant; });
  return worth;
}

/// Identifies so many conditions, simulate(i), by every method. On all processors.
template <typename Simulate>
std::vector<MethodWorth> certified(std::size_t conditions, const Progress& progress,
                                   const Simulate& simulate) {
  constexpr std::size_t kMethods = std::size(impedance::kPerturbationMethods);
  std::vector<std::vector<Outcome>> outcomes(kMethods, std::vector<Outcome>(conditions));
  std::atomic<std::uint64_t> done{0};
  std::mutex shown;
  for_each_in_parallel(conditions, [&](std::size_t i) {
    const Simulated simulated = simulate(i);
    const auto estimates = impedance::identify_each(simulated.trials, analyses_of(simulated.window));
    for (std::size_t m = 0; m < kMethods; ++m) {
      if (estimates[m]) outcomes[m][i] = outcome_of(*estimates[m], simulated);
    }
    const std::uint64_t count = ++done;
    if (!progress) return;
    const std::lock_guard lock(shown);
    progress(count, conditions);
  });
  std::vector<MethodWorth> all;
  for (std::size_t m = 0; m < kMethods; ++m)
    all.push_back(worth_of_method(impedance::kPerturbationMethods[m], outcomes[m]));
  return all;
}

/// From the estimate and its covariance.
impedance::Parameters drawn_impedance(const refined::Estimate& found, const impedance::Parameters& like,
                                      std::mt19937_64& random) {
  const Eigen::MatrixXd V = found.covariance->covariance();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> modes(V);
  std::normal_distribution<double> normal(0.0, 1.0);
  Eigen::VectorXd drawn(V.rows());
  for (double& value : drawn) value = normal(random);
  drawn = modes.eigenvectors() * modes.eigenvalues().cwiseMax(0.0).cwiseSqrt().cwiseProduct(drawn);
  const Eigen::MatrixXd theta = found.theta + drawn.reshaped(found.theta.rows(), found.theta.cols());
  impedance::Parameters parameters = like;
  const impedance::Parameters all = impedance::parameters_from(theta, static_cast<int>(theta.cols()));
  parameters.M = all.M;
  parameters.B = all.B;
  parameters.K = all.K;
  return parameters;
}

}  // namespace

const std::vector<NamedError>& model_errors() {
  static const std::vector<NamedError> all = {
      {"none", {}},
      {"reflex 15 %", {.reflex = 0.15}},
      {"reflex 40 %", {.reflex = 0.4}},
      {"reflex 60 ms", {.reflex = 0.4, .reflex_delay = 0.06}},
      {"slack 0.3 mm", {.slack = 3e-4}},
      {"slack 1 mm", {.slack = 1e-3}},
      {"hardening 10 %", {.hardening = 0.1}},
      {"hardening 30 %", {.hardening = 0.3}},
      {"friction 0.1 N", {.friction = 0.1}},
      {"friction 0.3 N", {.friction = 0.3}},
  };
  return all;
}

std::vector<MethodWorth> certify(const Cell& cell, const Progress& progress) {
  return certified(cell.conditions, progress, [&](std::size_t i) {
    std::mt19937_64 random(cell.seed * 1'000'003 + i);
    const Truth truth = draw_truth(static_cast<int>(i % 5), random);
    const auto trials = simulate_condition(truth, cell.design, cell.setting, random);
    return Simulated{trials,
                     truth.arm,
                     slow_impedance(truth, cell.setting.error),
                     bound_of(truth, cell.design, cell.setting),
                     cell.design.window,
                     Eigen::Vector2d::Zero()};
  });
}

Result<std::vector<MethodWorth>> certify_like(std::span<const impedance::Trial> measured,
                                              const Likeness& likeness, const Progress& progress) {
  std::vector<const impedance::Trial*> trials;
  for (const impedance::Trial& trial : measured) {
    if (trial.is_continuous || trial.commanded.rows() != trial.samples())
      return fail(
          ErrorCode::kInvalidArgument,
          "certify: a condition without recorded commands is not allowed; expected perturbations whose "
          "commanded displacement is recorded");
    trials.push_back(&trial);
  }
  if (trials.size() < refined::kFewestTrials)
    return fail(ErrorCode::kInvalidArgument,
                fmt::format("certify: {} trials are not allowed; expected {} or more", trials.size(),
                            refined::kFewestTrials));
  impedance::Options options;
  options.window = likeness.window;
  const refined::Estimate found = impedance::find_refined(trials, options);
  if (found.shortage != refined::Shortage::kNone || found.motion.rest == 0)
    return fail(ErrorCode::kInvalidArgument,
                "certify: a condition in which method refined finds no numbers is not allowed; expected one "
                "that tonus identify --method refined identifies");
  if (found.theta.cols() != 2)
    return fail(ErrorCode::kInvalidArgument, "certify: one axis is not allowed; expected two");
  const impedance::ResampledCondition condition(trials, found);
  return certified(likeness.conditions, progress, [&](std::size_t i) {
    std::mt19937_64 random(likeness.seed * 1'000'003 + i);
    const impedance::Parameters drawn = drawn_impedance(found, condition.impedance(), random);
    Simulated simulated{{},
                        {drawn.M, drawn.B, drawn.K},
                        {drawn.M, drawn.B, drawn.K},
                        Eigen::VectorXd::Zero(12),
                        likeness.window,
                        Eigen::Vector2d::Zero()};
    simulated.centre = -Eigen::Matrix2d(drawn.K).inverse() * Eigen::Vector2d(condition.offset());
    std::uniform_int_distribution<std::size_t> any(0, condition.size() - 1);
    for (std::size_t j = 0; j < condition.size(); ++j) {
      const double sign = (random() & 1U) != 0U ? 1.0 : -1.0;
      simulated.trials.push_back(condition.trial(j, any(random), sign, drawn));
    }
    return simulated;
  });
}

}  // namespace tonus::certify
