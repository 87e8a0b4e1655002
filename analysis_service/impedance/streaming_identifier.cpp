#include "analysis_service/impedance/streaming_identifier.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <spdlog/fmt/fmt.h>

#include "analysis_service/impedance/diagnostics.hpp"
#include "analysis_service/impedance/fit_signals.hpp"
#include "analysis_service/impedance/model_tests.hpp"
#include "analysis_service/impedance/pooled_fit.hpp"
#include "analysis_service/impedance/refined_identification.hpp"
#include "analysis_service/impedance/sized.hpp"
#include "analysis_service/impedance/state_variable_filter.hpp"
#include "analysis_service/impedance/tuning.hpp"
#include "analysis_service/impedance/unit_factor.hpp"
#include "analysis_service/impedance/verdict.hpp"

namespace tonus::impedance {

/// What does not depend on the sizes: the samples of the trial under way, the trials ended.
class StreamingIdentifier::Core {
 public:
  Core(const Options& options, const Preparation& preparation, double longest_trial)
      : options_(options),
        preparation_(preparation),
        window_rows_(rows_in(options.window)),
        natural_frequency_(options.natural_frequency.value_or(kProvisionalFrequency)),
        rest_(static_cast<std::size_t>(rows_in(preparation.rest))) {
    samples_.reserve(rest_.size() + static_cast<std::size_t>(rows_in(longest_trial)));
  }
  virtual ~Core() = default;
  Core(const Core&) = delete;
  Core& operator=(const Core&) = delete;

  virtual void start_moving() = 0;
  virtual void take(const EndpointSample& sample) = 0;
  virtual void refit() = 0;
  [[nodiscard]] virtual Estimate estimate() const = 0;

  void begin_trial(std::uint32_t number) {
    discard_trial();
    number_ = number;
    phase_ = Phase::kRest;
  }

  void push_rest(const EndpointSample& sample) {
    if (phase_ != Phase::kRest) {
      ++dropped_;
      return;
    }
    rest_[rest_count_ % rest_.size()] = sample;
    ++rest_count_;
  }

  void mark_onset() {
    if (phase_ != Phase::kRest) return;
    const std::size_t kept = std::min(rest_count_, rest_.size());
    for (std::size_t i = rest_count_ - kept; i < rest_count_; ++i)
      samples_.push_back(rest_[i % rest_.size()]);
    onset_ = samples_.size();
    phase_ = Phase::kMoving;
    start_moving();
  }

  void push(const EndpointSample& sample) {
    if (phase_ != Phase::kMoving || samples_.size() == samples_.capacity()) {
      ++dropped_;
      return;
    }
    samples_.push_back(sample);
    take(sample);
  }

  Result<void> end_trial() {
    const bool is_known = std::ranges::find(trials_, number_, &Trial::number) != trials_.end();
    auto trial = is_known ? Result<Trial>(fail(ErrorCode::kAlreadyExists,
                                               fmt::format("trial {}: the number is there already", number_)))
                          : prepare_trial(number_, samples_, static_cast<Eigen::Index>(onset_), preparation_);
    discard_trial();
    if (!trial) return trial.error();
    trials_.push_back(std::move(*trial));
    retune();
    return {};
  }

  bool remove_trial(std::uint32_t number) {
    if (std::erase_if(trials_, [number](const Trial& trial) { return trial.number == number; }) == 0)
      return false;
    retune();
    if (phase_ != Phase::kMoving) return true;
    start_moving();  // through the filter as it is tuned now
    for (std::size_t i = onset_; i < samples_.size(); ++i) take(samples_[i]);
    return true;
  }

  void discard_trial() {
    phase_ = Phase::kIdle;
    samples_.clear();
    rest_count_ = 0;
    onset_ = 0;
  }

  [[nodiscard]] Result<Estimate> finish() const { return identify(trials_, options_); }
  [[nodiscard]] std::span<const Trial> trials() const { return trials_; }
  [[nodiscard]] double natural_frequency() const { return natural_frequency_; }
  [[nodiscard]] std::size_t dropped() const { return dropped_; }

 protected:
  enum class Phase : std::uint8_t { kIdle, kRest, kMoving };

  [[nodiscard]] Eigen::Index rows_in(double duration) const {
    return static_cast<Eigen::Index>(std::llround(duration / preparation_.sample_period));
  }

  /// Trials that reach the window's end, by ascending number, as identify() takes them.
  [[nodiscard]] std::vector<const Trial*> usable() const {
    std::vector<const Trial*> ordered;
    for (const Trial& trial : trials_) {
      if (trial.samples() >= kFewestRows && trial.samples() - trial.onset >= window_rows_)
        ordered.push_back(&trial);
    }
    std::ranges::sort(ordered, {}, &Trial::number);
    return ordered;
  }

  void retune() {
    const auto ordered = usable();
    if (ordered.empty()) {
      natural_frequency_ = options_.natural_frequency.value_or(kProvisionalFrequency);
      diagnosis_ = {};
      return refit();
    }
    const double tuned = tuned_natural_frequency(ordered, options_.window, options_.block);
    if (!options_.natural_frequency && tuned > 0.0) natural_frequency_ = tuned;
    diagnosis_ = diagnose(ordered, options_, tuned);
    model_tests_.reset();
    if (!diagnosis_.is_force_clipped) model_tests_ = tests_by_mean_motion(ordered, options_);
    if (model_tests_) take_tests(*model_tests_, true, diagnosis_);
    refit();
  }

  Options options_;
  Preparation preparation_;
  Eigen::Index window_rows_;
  double natural_frequency_;
  Phase phase_ = Phase::kIdle;
  std::uint32_t number_ = 0;
  std::vector<EndpointSample> rest_;  ///< Ring of the newest samples of the rest.
  std::size_t rest_count_ = 0;
  std::vector<EndpointSample> samples_;  ///< Rest, then motion; reserved once.
  std::size_t onset_ = 0;
  std::vector<Trial> trials_;
  Diagnosis diagnosis_;
  std::optional<refined::Estimate> model_tests_;  ///< What diagnosis_ points at.
  std::size_t dropped_ = 0;
};

template <int kAxes, int kRegressors>
class StreamingIdentifier::SizedCore final : public Core {
 public:
  using Factor = RecursiveLeastSquares<kRegressors, kAxes>;
  using Values = Eigen::Array<double, kAxes, 1>;

  using Core::Core;

  /// Means of the rest as prepare_trial and rest_force take them, then the filters through the rest.
  void start_moving() override {
    row_ = 0;
    factor_ = Factor();
    pending_.setZero();
    x_filter_ = f_filter_ = StateVariableFilter<kAxes>(step_);
    p_mean_ = f_tare_ = f_rest_ = Values::Zero();
    const auto rest = std::span(samples_).first(onset_);
    if (rest.empty()) return;
    const auto count = static_cast<double>(rest.size());
    Values f_mean = Values::Zero();
    for (const EndpointSample& sample : rest) {
      p_mean_ += sample.p_SE.head<kAxes>().array();
      f_mean += sample.f_S.head<kAxes>().array();
    }
    p_mean_ /= count;
    if (preparation_.is_force_tared) f_tare_ = f_mean / count;
    for (const EndpointSample& sample : rest) f_rest_ += prepared_force(sample);
    f_rest_ /= count;
    for (const EndpointSample& sample : rest) filter(sample);
  }

  void take(const EndpointSample& sample) override {
    filter(sample);
    if (row_ >= window_rows_) return;
    auto row = pending_.row(row_ % Factor::kBlockRows);
    const Values x2 = x_filter_.acceleration();
    Values force = f_filter_.value() + f_rest_;
    if (preparation_.handle_mass > 0.0) force -= preparation_.handle_mass * x2;
    const auto as_row = [](const Values& values) { return values.matrix().transpose().eval(); };
    if constexpr (kRegressors == 3 * kAxes + 1) {
      row << as_row(x2), as_row(x_filter_.rate()), as_row(x_filter_.value()), 1.0, as_row(force);
    } else {
      row << as_row(x2), as_row(x_filter_.value()), 1.0, as_row(force);
    }
    if (++row_ % Factor::kBlockRows != 0) return;
    factor_.update(pending_, Factor::kBlockRows);
    pending_.setZero();
  }

  void refit() override {
    step_ = make_step();
    units_.clear();
    for (const Trial* trial : usable()) {
      units_.push_back(factor_of<kRegressors, kAxes>(fit_signals(*trial, options_, natural_frequency_),
                                                     trial->onset, window_rows_));
    }
  }

  [[nodiscard]] Estimate estimate() const override {
    Estimate estimate;
    estimate.method = options_.method;
    estimate.model = options_.model;
    estimate.axes = kAxes;
    estimate.natural_frequency = natural_frequency_;
    estimate.force_lag = diagnosis_.force_lag;
    for (const Trial* trial : usable()) estimate.trials_used.push_back(trial->number);
    std::vector<Factor> units = units_;
    if (phase_ == Phase::kMoving && row_ > 0) {
      units.push_back(factor_);
      units.back().update(pending_, row_ % Factor::kBlockRows);
    }
    std::optional<Reason> failure = fit_pooled(units, options_.rank_margin, estimate);
    if (diagnosis_.is_single_direction) failure = Reason::kSingleDirection;
    if (!failure && diagnosis_.model_tests != nullptr) carry_doubts(*diagnosis_.model_tests, estimate);
    conclude(estimate, failure, diagnosis_);
    return estimate;
  }

 private:
  [[nodiscard]] Values prepared_force(const EndpointSample& sample) const {
    Values force = sample.f_S.head<kAxes>().array();
    if (preparation_.is_force_tared) force -= f_tare_;
    return force;
  }

  void filter(const EndpointSample& sample) {
    x_filter_.push(sample.p_SE.head<kAxes>().array() - p_mean_);
    f_filter_.push(prepared_force(sample) - f_rest_);
  }

  [[nodiscard]] StateVariableStep make_step() const {
    return StateVariableStep::make(natural_frequency_, options_.damping_ratio, preparation_.sample_period);
  }

  StateVariableStep step_ = make_step();
  StateVariableFilter<kAxes> x_filter_{step_};
  StateVariableFilter<kAxes> f_filter_{step_};
  Values p_mean_ = Values::Zero();
  Values f_tare_ = Values::Zero();
  Values f_rest_ = Values::Zero();
  Factor factor_;  ///< Of the trial under way, but for the rows in `pending_`: whole blocks, as factor_of().
  typename Factor::Block pending_ = Factor::Block::Zero();
  Eigen::Index row_ = 0;
  std::vector<Factor> units_;  ///< Of the usable trials, by ascending number.
};

Result<StreamingIdentifier> StreamingIdentifier::create(const Options& options,
                                                        const Preparation& preparation,
                                                        double longest_trial) {
  if (auto valid = validate(preparation); !valid) return valid.error();
  if (auto valid = validate(options, preparation.sample_period); !valid) return valid.error();
  if (options.method != Method::kStateVariable) {
    return fail(ErrorCode::kInvalidArgument,
                fmt::format("streaming: method: {} is not allowed; expected state_variable",
                            name_of(options.method)));
  }
  if (options.model != Model::kLinear && options.model != Model::kNoDamping) {
    return fail(ErrorCode::kInvalidArgument,
                fmt::format("streaming: model: {} is not allowed; expected linear or no_damping",
                            name_of(options.model)));
  }
  if (!(longest_trial >= options.window) || !(longest_trial <= 3600.0)) {
    return fail(ErrorCode::kInvalidArgument,
                fmt::format("streaming: longest trial: {} s is not allowed; expected {} to 3600 s",
                            longest_trial, options.window));
  }
  return with_sizes(options.model, preparation.axes,
                    [&]<int kSize, int kAxes>() -> Result<StreamingIdentifier> {
                      return StreamingIdentifier(
                          std::make_unique<SizedCore<kAxes, kSize>>(options, preparation, longest_trial));
                    });
}

StreamingIdentifier::StreamingIdentifier(std::unique_ptr<Core> core) : core_(std::move(core)) {}
StreamingIdentifier::StreamingIdentifier(StreamingIdentifier&&) noexcept = default;
StreamingIdentifier& StreamingIdentifier::operator=(StreamingIdentifier&&) noexcept = default;
StreamingIdentifier::~StreamingIdentifier() = default;

void StreamingIdentifier::begin_trial(std::uint32_t number) { core_->begin_trial(number); }
void StreamingIdentifier::push_rest(const EndpointSample& sample) { core_->push_rest(sample); }
void StreamingIdentifier::mark_onset() { core_->mark_onset(); }
void StreamingIdentifier::push(const EndpointSample& sample) { core_->push(sample); }
Result<void> StreamingIdentifier::end_trial() { return core_->end_trial(); }
void StreamingIdentifier::discard_trial() { core_->discard_trial(); }
bool StreamingIdentifier::remove_trial(std::uint32_t number) { return core_->remove_trial(number); }
Estimate StreamingIdentifier::estimate() const { return core_->estimate(); }
Result<Estimate> StreamingIdentifier::finish() const { return core_->finish(); }
std::span<const Trial> StreamingIdentifier::trials() const { return core_->trials(); }
double StreamingIdentifier::natural_frequency() const { return core_->natural_frequency(); }
std::size_t StreamingIdentifier::dropped() const { return core_->dropped(); }

}  // namespace tonus::impedance
