#include "analysis_service/impedance/fit_signals.hpp"

#include <utility>

#include "analysis_service/impedance/butterworth.hpp"
#include "analysis_service/impedance/optimal_fourier.hpp"
#include "analysis_service/impedance/parameters.hpp"
#include "analysis_service/impedance/state_variable_filter.hpp"

namespace tonus::impedance {
namespace {

/// The model's velocity term from the velocity.
Signals terms_of(const Signals& v, Model model) {
  switch (model) {
    case Model::kLinear:
      return v;
    case Model::kNoDamping:
      return Signals(v.rows(), 0);
    case Model::kSquaredVelocity:
      return v.cwiseAbs2();
    case Model::kSignedSquaredVelocity:
      return v.cwiseProduct(v.cwiseAbs());
    case Model::kCoriolis:
      break;
    case Model::kFriction:  // of method spectral, which fits no signals by sample
    case Model::kCubic:
    case Model::kReflex:
    case Model::kAutomatic:
      return v;
  }
  if (v.cols() == 1) return v.cwiseAbs2();
  Signals products(v.rows(), 3);
  products << v.col(0).cwiseAbs2(), v.col(0).cwiseProduct(v.col(1)), v.col(1).cwiseAbs2();
  return products;
}

bool needs_products(Model model) { return model != Model::kLinear && model != Model::kNoDamping; }

FitSignals lowpass(const Trial& trial, const Options& options) {
  const SecondOrderFilter filter = butterworth_lowpass(options.cutoff, trial.sample_period);
  FitSignals signals;
  signals.displacement = zero_phase(filter, trial.displacement);
  signals.velocity_terms =
      terms_of(central_difference(signals.displacement, trial.sample_period), options.model);
  signals.acceleration = second_difference(signals.displacement, trial.sample_period);
  signals.force = options.is_force_filtered ? zero_phase(filter, trial.force) : trial.force;
  return signals;
}

FitSignals optimal(const Trial& trial, const Options& options) {
  OptimalDerivatives d = optimal_fourier(trial.displacement, trial.sample_period);
  FitSignals signals;
  signals.velocity_terms = terms_of(d.rate, options.model);
  signals.displacement = std::move(d.value);
  signals.acceleration = std::move(d.acceleration);
  signals.force = trial.force;
  return signals;
}

/// Both sides of the model through T(s), sample by sample.
template <int kAxes>
FitSignals state_variable(const Trial& trial, const Options& options, double natural_frequency) {
  const auto step = StateVariableStep::make(natural_frequency, options.damping_ratio, trial.sample_period);
  StateVariableFilter<kAxes> x_filter(step);
  StateVariableFilter<kAxes> f_filter(step);
  const Eigen::Array<double, kAxes, 1> f_rest = rest_force(trial);
  const Eigen::Index rows = trial.samples();
  FitSignals signals{Signals(rows, kAxes), Signals(rows, kAxes), Signals(rows, kAxes), Signals(rows, kAxes)};
  for (Eigen::Index k = 0; k < rows; ++k) {
    x_filter.push(trial.displacement.row(k).transpose().array());
    f_filter.push(trial.force.row(k).transpose().array() - f_rest);
    signals.acceleration.row(k) = x_filter.acceleration().matrix().transpose();
    signals.velocity_terms.row(k) = x_filter.rate().matrix().transpose();
    signals.displacement.row(k) = x_filter.value().matrix().transpose();
    signals.force.row(k) = (f_filter.value() + f_rest).matrix().transpose();
  }
  if (!needs_products(options.model)) {
    if (options.model == Model::kNoDamping) signals.velocity_terms.resize(rows, 0);
    return signals;
  }
  const SecondOrderFilter smoother = butterworth_lowpass(options.cutoff, trial.sample_period);
  const Signals products = terms_of(
      central_difference(zero_phase(smoother, trial.displacement), trial.sample_period), options.model);
  signals.velocity_terms.resizeLike(products);
  for (Eigen::Index term = 0; term < products.cols(); ++term) {
    StateVariableFilter<1> filter(step);
    for (Eigen::Index k = 0; k < rows; ++k) {
      filter.push(products.col(term).segment<1>(k).array());
      signals.velocity_terms(k, term) = filter.value()[0];
    }
  }
  return signals;
}

}  // namespace

AxisVector rest_force(const Trial& trial) {
  if (trial.is_continuous || trial.onset == 0) return AxisVector::Zero(trial.axes());
  return mean_of_rows(trial.force, 0, trial.onset);
}

FitSignals fit_signals(const Trial& trial, const Options& options, double natural_frequency) {
  FitSignals signals;
  switch (trial.is_continuous ? options.record_method : options.method) {
    case Method::kLowpass:
      signals = lowpass(trial, options);
      break;
    case Method::kOptimal:
      signals = optimal(trial, options);
      break;
    case Method::kStateVariable:
      signals = trial.axes() == 1 ? state_variable<1>(trial, options, natural_frequency)
                                  : state_variable<2>(trial, options, natural_frequency);
      break;
    case Method::kRefined:
    case Method::kSpectral:  // fits no signals by sample
      break;
  }
  if (trial.handle_mass > 0.0) signals.force -= trial.handle_mass * signals.acceleration;
  return signals;
}

}  // namespace tonus::impedance
