#include "analysis_service/impedance/identification.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <spdlog/fmt/fmt.h>

#include "analysis_service/impedance/convergence.hpp"
#include "analysis_service/impedance/cross_check.hpp"
#include "analysis_service/impedance/diagnostics.hpp"
#include "analysis_service/impedance/fit_signals.hpp"
#include "analysis_service/impedance/method_bias.hpp"
#include "analysis_service/impedance/model_tests.hpp"
#include "analysis_service/impedance/pooled_fit.hpp"
#include "analysis_service/impedance/record_identification.hpp"
#include "analysis_service/impedance/refined_identification.hpp"
#include "analysis_service/impedance/sized.hpp"
#include "analysis_service/impedance/tuning.hpp"
#include "analysis_service/impedance/unit_factor.hpp"
#include "analysis_service/impedance/verdict.hpp"

namespace tonus::impedance {
namespace {

using TrialPointers = std::vector<const Trial*>;

Error refuse(const Trial& trial, const std::string& what) {
  return fail(ErrorCode::kInvalidArgument, fmt::format("trial {}: {}", trial.number, what));
}

Result<void> check(const Trial& trial, const Trial& first) {
  if (trial.axes() != 1 && trial.axes() != 2)
    return refuse(trial, fmt::format("{} axes are not allowed; expected 1 or 2", trial.axes()));
  if (trial.axes() != first.axes()) {
    return refuse(trial, fmt::format("{} axes are not allowed; expected {} as in trial {}", trial.axes(),
                                     first.axes(), first.number));
  }
  if (trial.sample_period != first.sample_period) {
    return refuse(trial, fmt::format("sample period: {} s is not allowed; expected {} s as in trial {}",
                                     trial.sample_period, first.sample_period, first.number));
  }
  if (trial.force.rows() != trial.samples() || trial.force.cols() != trial.axes()) {
    return refuse(trial,
                  fmt::format("force: {} x {} values are not allowed; expected {} x {} as the displacement",
                              trial.force.rows(), trial.force.cols(), trial.samples(), trial.axes()));
  }
  if (trial.commanded.rows() != 0 && trial.commanded.rows() != trial.samples()) {
    return refuse(trial, fmt::format("{} commanded values are not allowed; expected 0 or {}",
                                     trial.commanded.rows(), trial.samples()));
  }
  if (trial.onset < 0 || (!trial.is_continuous && trial.onset >= trial.samples())) {
    return refuse(trial, fmt::format("onset at sample {} is not allowed; expected 0 to {}", trial.onset,
                                     trial.samples() - 1));
  }
  return {};
}

Result<TrialPointers> in_order(std::span<const Trial> trials) {
  TrialPointers ordered;
  for (const Trial& trial : trials) {
    if (auto valid = check(trial, trials.front()); !valid) return valid.error();
    ordered.push_back(&trial);
  }
  std::ranges::sort(ordered, {}, &Trial::number);
  const auto repeated = std::ranges::adjacent_find(ordered, {}, &Trial::number);
  if (repeated != ordered.end()) return refuse(**repeated, "the number occurs twice; expected once");
  return ordered;
}

/// Takes out the trials that end before the window does.
void reject_short(TrialPointers& trials, Eigen::Index rows, Estimate& estimate) {
  std::erase_if(trials, [&](const Trial* trial) {
    const bool is_short =
        trial->samples() < kFewestRows || (!trial->is_continuous && trial->samples() - trial->onset < rows);
    if (is_short) estimate.trials_rejected.push_back({trial->number, Reason::kShortTrial});
    return is_short;
  });
}

/// Independent units of one trial: itself, or the blocks of a continuous record behind the filter's
/// transient; what is left over at the end belongs to the last block.
template <int kSize, int kAxes>
void add_units(const Trial& trial, const FitSignals& signals, const Options& options,
               double natural_frequency, std::vector<RecursiveLeastSquares<kSize, kAxes>>& units) {
  const auto rows_in = [&](double duration) {
    return static_cast<Eigen::Index>(std::llround(duration / trial.sample_period));
  };
  if (!trial.is_continuous) {
    units.push_back(factor_of<kSize, kAxes>(signals, trial.onset, rows_in(options.window)));
    return;
  }
  Eigen::Index first = 0;
  if (options.record_method == Method::kStateVariable) {
    const double decay = options.damping_ratio * 2.0 * std::numbers::pi * natural_frequency;
    first = std::min(rows_in(5.0 / decay), trial.samples() / 4);
  }
  const Eigen::Index block = rows_in(options.block);
  const Eigen::Index count = std::max<Eigen::Index>(1, (trial.samples() - first) / block);
  for (Eigen::Index i = 0; i < count; ++i) {
    const Eigen::Index begin = first + i * block;
    const Eigen::Index end = i + 1 == count ? trial.samples() : begin + block;
    units.push_back(factor_of<kSize, kAxes>(signals, begin, end - begin));
  }
}

/// Estimates from all trials pooled, as the window grows: rows in the order of time.
template <int kSize, int kAxes>
std::vector<ConvergencePoint> trace_of(const TrialPointers& trials, const std::vector<FitSignals>& signals,
                                       Eigen::Index rows, double rank_margin) {
  std::vector<ConvergencePoint> trace;
  RecursiveLeastSquares<kSize, kAxes> factor;
  for (Eigen::Index k = 0; k < rows; ++k) {
    const auto row_of_trial = [&](Eigen::Index g) {
      const auto i = static_cast<std::size_t>(g);
      return model_row<kSize, kAxes>(signals[i], trials[i]->onset + k);
    };
    add_rows(static_cast<Eigen::Index>(trials.size()), row_of_trial, factor);
    if (!(condition_bound<kSize>(factor.R()) * rank_margin < 1.0)) continue;
    const double end_time = static_cast<double>(k + 1) * trials.front()->sample_period;
    trace.push_back({end_time, parameters_from(solve(factor), kAxes)});
  }
  return trace;
}

template <int kSize, int kAxes>
std::optional<Reason> fit(const TrialPointers& trials, const Options& options, Eigen::Index rows,
                          Estimate& estimate) {
  std::vector<FitSignals> signals;
  std::vector<RecursiveLeastSquares<kSize, kAxes>> units;
  for (const Trial* trial : trials) {
    signals.push_back(fit_signals(*trial, options, estimate.natural_frequency));
    add_units(*trial, signals.back(), options, estimate.natural_frequency, units);
  }
  if (const auto failure = fit_pooled(units, options.rank_margin, estimate)) return failure;
  const bool has_onsets =
      std::ranges::none_of(trials, [](const Trial* trial) { return trial->is_continuous; });
  if (options.has_trace && has_onsets) {
    estimate.trace = trace_of<kSize, kAxes>(trials, signals, rows, options.rank_margin);
    estimate.settling_time = settling_time(estimate.trace, estimate.value, options.settling_share);
  }
  return std::nullopt;
}

/// Continuous records and perturbations are different data: which of them a condition has.
Result<bool> are_records(const TrialPointers& trials, const Options& options) {
  const auto records = std::ranges::count_if(trials, &Trial::is_continuous);
  if (records != 0 && records != std::ssize(trials)) {
    return fail(
        ErrorCode::kInvalidArgument,
        fmt::format("condition: {} continuous records beside {} perturbations are not allowed; expected "
                    "one kind",
                    records, std::ssize(trials) - records));
  }
  if (records == 0 && options.method == Method::kSpectral) {
    return fail(ErrorCode::kInvalidArgument,
                "method: spectral is not allowed for perturbations; expected lowpass, optimal, "
                "state_variable or refined");
  }
  if (records == 0 && !has_model(options.method, options.model)) {
    return fail(
        ErrorCode::kInvalidArgument,
        fmt::format("model: {} is not allowed for method refined; expected linear", name_of(options.model)));
  }
  if (records != 0 && options.record_method == Method::kRefined) {
    return fail(ErrorCode::kInvalidArgument,
                "method: refined is not allowed for continuous records; expected lowpass, optimal, "
                "state_variable or spectral");
  }
  const bool is_spectral = records != 0 && options.record_method == Method::kSpectral;
  if (is_spectral && !is_record_model(options.model)) {
    return fail(ErrorCode::kInvalidArgument,
                fmt::format("model: {} is not allowed for continuous records by method spectral; expected "
                            "linear, friction, cubic, reflex or auto",
                            name_of(options.model)));
  }
  if (!is_spectral && !is_published_model(options.model)) {
    return fail(
        ErrorCode::kInvalidArgument,
        fmt::format("model: {} is not allowed for method {}; expected linear, no_damping, coriolis, "
                    "squared_velocity or signed_squared_velocity ({} is for continuous records by "
                    "method spectral)",
                    name_of(options.model), name_of(records != 0 ? options.record_method : options.method),
                    name_of(options.model)));
  }
  if (records == 0 || options.record_method == Method::kSpectral) return records != 0;
  for (const Trial* trial : trials) {
    const auto missing = std::ranges::count(trial->is_missing, true);
    if (missing == 0) continue;
    return fail(
        ErrorCode::kDataLoss,
        fmt::format("trial {}: {} missing rows are not allowed for method {}; expected none, or method "
                    "spectral, which uses the segments between them",
                    trial->number, missing, name_of(options.record_method)));
  }
  return true;
}

/// What every method and model finds in the same trials.
struct Examination {
  double window = 0.0;  ///< s; with `block`, what it depends on.
  double block = 0.0;   ///< s.
  double frequency = 0.0;
  Diagnosis diagnosis;
  std::optional<refined::Estimate> refined;    ///< Where a method, a bias or the cross-check asked for it.
  std::optional<refined::Estimate> by_motion;  ///< Where there are no commands.
  std::optional<Estimate> state_variable;      ///< By the published settings, without bias.
  std::optional<Estimate> spectral;            ///< Of records by a published method.
};

Examination examine(const TrialPointers& trials, const Options& options) {
  const double frequency = tuned_natural_frequency(trials, options.window, options.block);
  return {options.window, options.block, frequency, diagnose(trials, options, frequency), {}, {}, {}, {}};
}

const refined::Estimate& refined_of(const TrialPointers& trials, const Options& options, Examination& known) {
  if (!known.refined) known.refined = find_refined(trials, options);
  return *known.refined;
}

/// By a published method.
std::optional<Reason> fit_published(const TrialPointers& trials, const Options& options, Eigen::Index rows,
                                    Estimate& estimate) {
  return with_sizes(options.model, estimate.axes, [&]<int kSize, int kAxes>() {
    return fit<kSize, kAxes>(trials, options, rows, estimate);
  });
}

/// Whether there are commands, and trials enough to test them against model (3) and to simulate a bias.
bool has_commands(const TrialPointers& trials) {
  return trials.size() >= kFewestTested && std::ranges::all_of(trials, [](const Trial* trial) {
           return !trial->is_continuous && trial->commanded.rows() == trial->samples();
         });
}

/// What tests these trials against model (3), if anything does. It does not depend on the analyses before.
const refined::Estimate* model_tests_of(const TrialPointers& trials, const Options& options, Method method,
                                        Examination& known) {
  if (options.model != Model::kLinear) return nullptr;
  if (method == Method::kRefined || has_commands(trials)) {
    const refined::Estimate& found = refined_of(trials, options, known);
    if (found.shortage == refined::Shortage::kNone) return &found;
  }
  if (!known.by_motion) known.by_motion = tests_by_mean_motion(trials, options);
  return known.by_motion ? &*known.by_motion : nullptr;
}

/// What a published method errs at these trials. Where no command is known, state_variable's is left out: it
/// filters force and displacement alike, and its estimates while samples arrive know no bias.
void carry_bias_of(const TrialPointers& trials, const Options& options, Estimate& estimate,
                   Examination& known) {
  const refined::Estimate* found = model_tests_of(trials, options, options.method, known);
  const bool is_by_motion = known.by_motion && found == &*known.by_motion;
  if (found == nullptr || (is_by_motion && options.method == Method::kStateVariable)) return;
  if (const auto bias = method_bias(trials, *found, options, estimate.natural_frequency))
    carry_bias(*bias, estimate);
}

const Estimate& spectral_of(const TrialPointers& trials, Examination& known) {
  if (known.spectral) return *known.spectral;
  Estimate& estimate = known.spectral.emplace();
  estimate.method = Method::kSpectral;
  estimate.axes = trials.front()->axes();
  identify_records(trials, Model::kLinear, estimate);
  return estimate;
}

/// Method state_variable by the published settings, as the cross-check takes it.
const Estimate& state_variable_of(const TrialPointers& trials, Eigen::Index rows, Examination& known) {
  if (known.state_variable) return *known.state_variable;
  Options options;
  options.window = known.window;
  options.has_trace = false;
  Estimate& estimate = known.state_variable.emplace();
  estimate.axes = trials.front()->axes();
  estimate.natural_frequency = known.frequency;
  const bool is_found = known.frequency > 0.0 && !fit_published(trials, options, rows, estimate);
  estimate.status = is_found ? Status::kOk : Status::kUndetermined;
  if (!is_found) return estimate;
  if (const auto bias = method_bias(trials, *known.refined, options, known.frequency))
    state_bias(*bias, estimate);
  return estimate;
}

/// The methods held against each other, where this estimate is by one of the two.
std::optional<CrossCheck> cross_check_of(const TrialPointers& trials, const Options& options,
                                         Eigen::Index rows, Estimate& estimate, Examination& known) {
  const bool is_checked = options.model == Model::kLinear &&
                          (estimate.method == Method::kRefined || estimate.method == Method::kStateVariable);
  if (!is_checked || trials.size() < kFewestCrossChecked || !has_commands(trials)) return std::nullopt;
  return cross_check(refined_of(trials, options, known), state_variable_of(trials, rows, known));
}

/// `known`: the examination of these trials by an analysis before; filled where it is none or another's.
Result<Estimate> identify_one(std::span<const Trial> given, const Options& options,
                              std::optional<Examination>& known) {
  Estimate estimate;
  estimate.method = options.method;
  estimate.model = options.model;
  if (given.empty()) {
    conclude(estimate, Reason::kTooFewTrials, {});
    return estimate;
  }
  const double sample_period = given.front().sample_period;
  if (auto valid = validate(options, sample_period); !valid) return valid.error();
  auto ordered = in_order(given);
  if (!ordered) return ordered.error();
  TrialPointers& trials = *ordered;
  const auto rows = static_cast<Eigen::Index>(std::llround(options.window / sample_period));
  estimate.axes = given.front().axes();
  TONUS_TRY_ASSIGN(const bool is_record, are_records(trials, options));
  if (is_record) estimate.method = options.record_method;
  if (estimate.method == Method::kSpectral) {
    for (const Trial* trial : trials) estimate.trials_used.push_back(trial->number);
    identify_records(trials, options.model, estimate);
    return estimate;
  }
  reject_short(trials, rows, estimate);
  for (const Trial* trial : trials) estimate.trials_used.push_back(trial->number);
  if (trials.empty()) {
    conclude(estimate, Reason::kTooFewTrials, {});
    return estimate;
  }

  if (!known || known->window != options.window || known->block != options.block)
    known = examine(trials, options);
  estimate.force_lag = known->diagnosis.force_lag;
  std::optional<Reason> failure;
  if (estimate.method == Method::kStateVariable) {
    estimate.natural_frequency = options.natural_frequency.value_or(known->frequency);
    if (estimate.natural_frequency <= 0.0) failure = Reason::kRankDeficient;
  }
  if (known->diagnosis.is_single_direction) failure = Reason::kSingleDirection;
  if (!failure && estimate.method == Method::kRefined) {
    failure = identify_refined(refined_of(trials, options, *known), trials.size(), options, estimate);
  } else if (!failure) {
    failure = fit_published(trials, options, rows, estimate);
    if (!failure && !is_record) carry_bias_of(trials, options, estimate, *known);
    if (!failure && is_record && options.model == Model::kLinear)
      hold_against_spectral(spectral_of(trials, *known), estimate);
  }
  Diagnosis diagnosis = known->diagnosis;
  // What a clipped force shows beside its clipping names a wrong cause.
  const refined::Estimate* tests = failure || diagnosis.is_force_clipped
                                       ? nullptr
                                       : model_tests_of(trials, options, estimate.method, *known);
  if (tests != nullptr) {
    take_tests(*tests, known->by_motion && tests == &*known->by_motion, diagnosis);
    carry_doubts(*tests, estimate);
  } else if (estimate.method == Method::kRefined) {
    diagnosis.is_force_shifted = false;  // it has a test of its own
  }
  if (!failure) diagnosis.cross_check = cross_check_of(trials, options, rows, estimate, *known);
  conclude(estimate, failure, diagnosis);
  return estimate;
}

}  // namespace

Result<Estimate> identify(std::span<const Trial> trials, const Options& options) {
  std::optional<Examination> none;
  return identify_one(trials, options, none);
}

std::vector<Result<Estimate>> identify_each(std::span<const Trial> trials,
                                            std::span<const Options> analyses) {
  std::vector<Result<Estimate>> estimates;
  std::optional<Examination> known;
  for (const Options& options : analyses) estimates.push_back(identify_one(trials, options, known));
  return estimates;
}

}  // namespace tonus::impedance
