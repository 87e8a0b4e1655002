#include "analysis_service/certify/certification.hpp"

#include <Eigen/Dense>
#include <atomic>
#include <cmath>
#include <iterator>
#include <mutex>
#include <tuple>
#include <utility>

#include "analysis_service/certify/bound.hpp"
#include "analysis_service/certify/imperfect_arm.hpp"
#include "analysis_service/impedance/identification.hpp"
#include "analysis_service/impedance/parameters.hpp"
#include "services/core/parallel.hpp"

namespace tonus::certify {
namespace {

constexpr Eigen::Index kElements = 14;  // M, B, K column by column, X0

Eigen::Index matrix_of(Eigen::Index element) { return element / 4; }  // 12 and 13: X0

/// One method's result in one condition.
struct Outcome {
  bool is_determined = false;
  bool is_suspect = false;
  Eigen::VectorXd error;          // as a share of the largest element; m for X0
  Eigen::VectorXd bound;          // 12, alike
  Eigen::VectorXd inside;         // 1 or 0
  Eigen::VectorXd inside_secant;  // of K
  Eigen::VectorXd half;
};

Outcome outcome_of(const impedance::Estimate& estimate, const Truth& truth, const Eigen::Matrix2d& secant,
                   const Eigen::VectorXd& bound) {
  Outcome outcome;
  outcome.is_determined = estimate.status != impedance::Status::kUndetermined;
  outcome.is_suspect = estimate.status == impedance::Status::kSuspect;
  if (!outcome.is_determined) return outcome;
  Eigen::VectorXd expected = Eigen::VectorXd::Zero(kElements);
  expected << truth.arm.M.reshaped(), truth.arm.B.reshaped(), truth.arm.K.reshaped(), 0.0, 0.0;
  Eigen::VectorXd scale = Eigen::VectorXd::Ones(kElements);
  for (Eigen::Index matrix = 0; matrix < 3; ++matrix)
    scale.segment(4 * matrix, 4).setConstant(expected.segment(4 * matrix, 4).cwiseAbs().maxCoeff());
  const Eigen::VectorXd low = impedance::flatten(estimate.low);
  const Eigen::VectorXd high = impedance::flatten(estimate.high);
  outcome.error = (impedance::flatten(estimate.value) - expected).cwiseQuotient(scale);
  outcome.half = (0.5 * (high - low)).cwiseQuotient(scale);
  outcome.bound = bound.cwiseQuotient(scale.head(12));
  outcome.inside = (low.array() <= expected.array() && expected.array() <= high.array()).cast<double>();
  const Eigen::ArrayXd stiffness = secant.reshaped();
  outcome.inside_secant =
      (low.segment(8, 4).array() <= stiffness && stiffness <= high.segment(8, 4).array()).cast<double>();
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

}  // namespace

const std::vector<NamedError>& model_errors() {
  static const std::vector<NamedError> all = {
      {"none", {}},
      {"reflex 15 %", {.reflex = 0.15}},
      {"reflex 40 %", {.reflex = 0.4}},
      {"slack 0.3 mm", {.slack = 3e-4}},
      {"slack 1 mm", {.slack = 1e-3}},
      {"hardening 10 %", {.hardening = 0.1}},
      {"hardening 30 %", {.hardening = 0.3}},
  };
  return all;
}

std::vector<MethodWorth> certify(const Cell& cell, const Progress& progress) {
  constexpr std::size_t kMethods = std::size(impedance::kPerturbationMethods);
  std::vector<std::vector<Outcome>> outcomes(kMethods, std::vector<Outcome>(cell.conditions));
  std::atomic<std::uint64_t> done{0};
  std::mutex shown;
  for_each_in_parallel(cell.conditions, [&](std::size_t i) {
    std::mt19937_64 random(cell.seed * 1'000'003 + i);
    const Truth truth = draw_truth(static_cast<int>(i % 5), random);
    const auto trials = simulate_condition(truth, cell.design, cell.setting, random);
    const Eigen::VectorXd bound = bound_of(truth, cell.design, cell.setting);
    const Eigen::Matrix2d secant = secant_stiffness(truth, cell.setting.error);
    std::vector<impedance::Options> analyses;
    for (const auto method : impedance::kPerturbationMethods) {
      analyses.emplace_back();
      analyses.back().method = method;
      analyses.back().window = cell.design.window;
      analyses.back().has_trace = false;
    }
    const auto estimates = impedance::identify_each(trials, analyses);
    for (std::size_t m = 0; m < kMethods; ++m) {
      if (estimates[m]) outcomes[m][i] = outcome_of(*estimates[m], truth, secant, bound);
    }
    const std::uint64_t count = ++done;
    if (!progress) return;
    const std::lock_guard lock(shown);
    progress(count, cell.conditions);
  });
  std::vector<MethodWorth> all;
  for (std::size_t m = 0; m < kMethods; ++m) {
    MethodWorth worth;
    worth.method = impedance::kPerturbationMethods[m];
    worth.conditions = cell.conditions;
    for (const Outcome& outcome : outcomes[m]) {
      worth.undetermined += outcome.is_determined ? 0 : 1;
      worth.suspect += outcome.is_suspect ? 1 : 0;
    }
    for (Eigen::Index matrix = 0; matrix < 4; ++matrix)
      worth.matrices[static_cast<std::size_t>(matrix)] = worth_of(outcomes[m], matrix);
    worth.wrong_and_ok_secant = wrong_and_ok(outcomes[m], [](const Outcome& o) { return o.inside_secant; });
    all.push_back(worth);
  }
  return all;
}

}  // namespace tonus::certify
