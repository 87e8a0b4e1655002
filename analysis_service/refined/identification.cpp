#include "analysis_service/refined/identification.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <utility>

#include "analysis_service/refined/command_response.hpp"
#include "analysis_service/refined/weak_form.hpp"
#include "analysis_service/refined/weighted_fit.hpp"

namespace tonus::refined {
namespace {

constexpr double kLeastSpread = 1e-3;  // Of U'U, smaller over larger eigenvalue: less is one line.

/// Rows that all trials have around their onsets, and how they are thinned for the response to the command.
struct Frame {
  Eigen::Index rest = 0;
  Eigen::Index rows = 0;
  Eigen::Index step = 1;    // rows between test functions
  Eigen::Index stride = 1;  // rows between those of the response

  [[nodiscard]] Eigen::MatrixXd cut(const Trial& trial, const Eigen::MatrixXd& signal) const {
    return signal.middleRows(trial.onset - rest, rows);
  }
  [[nodiscard]] Eigen::MatrixXd thinned(const Eigen::MatrixXd& signal) const {
    return signal(Eigen::seqN(0, (rows - 1) / stride + 1, stride), Eigen::all);
  }
};

Frame frame_of(const std::vector<Trial>& trials, const Settings& settings) {
  Frame frame;
  frame.rest = trials.front().onset;
  Eigen::Index moving = std::llround(settings.window / settings.sample_period);
  for (const Trial& trial : trials) {
    frame.rest = std::min(frame.rest, trial.onset);
    moving = std::min(moving, trial.displacement.rows() - trial.onset);
  }
  frame.step = step_of(settings.sample_period);
  frame.stride = std::max<Eigen::Index>(1, frame.step / 4);
  while (frame.step % frame.stride != 0) --frame.stride;
  frame.rows = frame.rest + moving;
  frame.rows -= (frame.rows - 1) % frame.stride;
  return frame;
}

/// The commands of a condition: where each trial goes, and how they all get there.
struct Commands {
  Eigen::MatrixXd targets;  // U, trials x axes, m
  Eigen::MatrixXd weights;  // W = U (U'U)^-1
  Eigen::VectorXd shape;    // rows
};

Shortage read_commands(const std::vector<Trial>& trials, const Frame& frame, Commands& commands) {
  const Eigen::Index axes = trials.front().displacement.cols();
  std::vector<Eigen::MatrixXd> moved;
  Eigen::VectorXd squares = Eigen::VectorXd::Zero(frame.rows);
  for (const Trial& trial : trials) {
    if (trial.commanded.rows() != trial.displacement.rows()) return Shortage::kNoCommand;
    moved.push_back(frame.cut(trial, trial.commanded));
    const Eigen::RowVectorXd start = moved.back().row(0);
    moved.back().rowwise() -= start;
    squares += moved.back().rowwise().squaredNorm();
  }
  Eigen::Index farthest = 0;
  if (!(squares.maxCoeff(&farthest) > 0.0)) return Shortage::kNoCommand;
  commands.targets.resize(static_cast<Eigen::Index>(trials.size()), axes);
  for (std::size_t j = 0; j < moved.size(); ++j)
    commands.targets.row(static_cast<Eigen::Index>(j)) = moved[j].row(farthest);
  const Eigen::MatrixXd UU = commands.targets.transpose() * commands.targets;
  const Eigen::VectorXd values = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(UU).eigenvalues();
  if (!(values[0] > kLeastSpread * values[axes - 1])) return Shortage::kSingleDirection;
  commands.weights = commands.targets * UU.inverse();
  commands.shape = Eigen::VectorXd::Zero(frame.rows);
  for (std::size_t j = 0; j < moved.size(); ++j)
    commands.shape += moved[j] * commands.targets.row(static_cast<Eigen::Index>(j)).transpose();
  commands.shape /= UU.trace();
  return Shortage::kNone;
}

MeanResponse mean_response(const std::vector<Trial>& trials, const Frame& frame, const Commands& commands,
                           double sample_period) {
  MeanResponse mean;
  mean.sample_period = static_cast<double>(frame.stride) * sample_period;
  mean.rest = (frame.rest + frame.stride - 1) / frame.stride;
  mean.shape = frame.thinned(commands.shape);
  for (Eigen::Index b = 0; b < commands.weights.cols(); ++b) {
    Eigen::MatrixXd response = Eigen::MatrixXd::Zero(mean.shape.size(), commands.weights.cols());
    for (std::size_t j = 0; j < trials.size(); ++j)
      response += commands.weights(static_cast<Eigen::Index>(j), b) *
                  frame.thinned(frame.cut(trials[j], trials[j].displacement));
    mean.of_axis.push_back(std::move(response));
  }
  return mean;
}

/// What each trial has of `taken` beyond the mean of all; zeros where nothing was taken.
Eigen::MatrixXd beyond_mean(const std::vector<Trial>& trials, Eigen::VectorXd Trial::*taken) {
  const Eigen::Index axes = trials.front().displacement.cols();
  Eigen::MatrixXd all = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(trials.size()), axes);
  for (std::size_t j = 0; j < trials.size(); ++j) {
    if ((trials[j].*taken).size() != axes) return Eigen::MatrixXd::Zero(all.rows(), axes);
    all.row(static_cast<Eigen::Index>(j)) = (trials[j].*taken).transpose();
  }
  const Eigen::RowVectorXd mean = all.colwise().mean();
  all.rowwise() -= mean;
  return all;
}

Eigen::MatrixXd regressors(const WeakForm& weak, const Eigen::MatrixXd& x) {
  const Eigen::Index axes = x.cols();
  Eigen::MatrixXd phi(weak.size(), 3 * axes + 1);
  phi << weak.apply(2, x), weak.apply(1, x), weak.apply(0, x), Eigen::VectorXd::Ones(weak.size());
  return phi;
}

/// Everything that the fit was made from, by trial.
struct Prepared {
  std::vector<TrialRows> trials;
  std::vector<Eigen::MatrixXd> predicted;  // m, thinned rows x axes
  Eigen::MatrixXd x_taken;                 // beyond the mean, trials x axes
  Eigen::MatrixXd f_taken;
};

Prepared prepare(const std::vector<Trial>& trials, const Frame& frame, const Commands& commands,
                 const CommandResponse& response, const WeakForm& fine, const WeakForm& thin) {
  Prepared prepared;
  prepared.x_taken = beyond_mean(trials, &Trial::displacement_taken);
  prepared.f_taken = beyond_mean(trials, &Trial::force_taken);
  for (std::size_t j = 0; j < trials.size(); ++j) {
    const auto row = static_cast<Eigen::Index>(j);
    Eigen::MatrixXd x = frame.cut(trials[j], trials[j].displacement);
    Eigen::MatrixXd f = frame.cut(trials[j], trials[j].force);
    x.rowwise() += prepared.x_taken.row(row);
    f.rowwise() += prepared.f_taken.row(row);
    Eigen::MatrixXd predicted = Eigen::MatrixXd::Zero(response.of_axis.front().rows(), x.cols());
    for (Eigen::Index b = 0; b < x.cols(); ++b)
      predicted += commands.targets(row, b) * response.of_axis[static_cast<std::size_t>(b)];
    prepared.trials.push_back({fine.apply(0, f), regressors(fine, x), regressors(thin, predicted)});
    prepared.predicted.push_back(std::move(predicted));
  }
  return prepared;
}

/// X0 of each trial as it was tared, their mean and its scatter.
void set_centre(const WeightedFit& fit, const Prepared& prepared, Estimate& estimate) {
  const Eigen::Index axes = estimate.theta.cols();
  const auto count = static_cast<Eigen::Index>(prepared.trials.size());
  const Eigen::MatrixXd K = estimate.theta.middleRows(2 * axes, axes).transpose();
  const Eigen::MatrixXd ones =
      fit.whitener.design(Eigen::MatrixXd::Ones(prepared.trials.front().force.rows(), 1));
  const auto mean_of = (ones.transpose() * ones).ldlt();
  const Eigen::VectorXd c = estimate.theta.bottomRows(1).transpose();
  Eigen::MatrixXd centres(count, axes);
  for (Eigen::Index j = 0; j < count; ++j) {
    const auto& e = fit.residuals[static_cast<std::size_t>(j)];
    const Eigen::VectorXd offset = c + mean_of.solve(ones.transpose() * fit.whitener.signal(e));
    const Eigen::VectorXd tared =
        offset - prepared.f_taken.row(j).transpose() + K * prepared.x_taken.row(j).transpose();
    centres.row(j) = -K.partialPivLu().solve(tared).transpose();
  }
  estimate.X0 = centres.colwise().mean();
  const Eigen::MatrixXd apart = centres.rowwise() - estimate.X0.transpose();
  // The offsets' scatter also served to fit K, along as many directions as there are axes.
  estimate.X0_freedom = static_cast<double>(count - 1 - axes);
  estimate.X0_covariance = apart.transpose() * apart / (estimate.X0_freedom * static_cast<double>(count));
  estimate.X0_std =
      (apart.colwise().squaredNorm() / (estimate.X0_freedom * static_cast<double>(count))).cwiseSqrt();
}

void set_sigma(const WeightedFit& fit, Estimate& estimate) {
  Eigen::RowVectorXd left = Eigen::RowVectorXd::Zero(fit.theta.cols());
  double rows = 0.0;
  for (const Eigen::MatrixXd& e : fit.residuals) {
    left += e.colwise().squaredNorm();
    rows += static_cast<double>(e.rows());
  }
  estimate.sigma = (left / rows).cwiseSqrt().transpose();
}

/// Correlation of whitened residuals with their neighbours.
double neighbours(const WeightedFit& fit) {
  const Eigen::Index axes = fit.theta.cols();
  const Eigen::Index n = fit.y.front().size() / axes;
  double largest = 0.0;
  for (Eigen::Index axis = 0; axis < axes; ++axis) {
    double product = 0.0;
    double square = 0.0;
    for (std::size_t j = 0; j < fit.y.size(); ++j) {
      const Eigen::VectorXd r = (fit.y[j] - fit.X[j] * fit.theta.reshaped()).segment(axis * n, n);
      product += r.head(n - 1).dot(r.tail(n - 1));
      square += r.squaredNorm();
    }
    largest = std::max(largest, std::abs(product / square));
  }
  return largest;
}

/// At the samples' rate, to the end of the shortest trial.
CommandMotion command_motion(const std::vector<Trial>& trials, const Commands& commands,
                             const CommandResponse& response, const Settings& settings) {
  Frame frame = frame_of(trials, settings);
  Eigen::Index moving = trials.front().displacement.rows() - trials.front().onset;
  for (const Trial& trial : trials) moving = std::min(moving, trial.displacement.rows() - trial.onset);
  frame.rows = frame.rest + moving;
  Commands of_all;
  CommandMotion motion;
  if (read_commands(trials, frame, of_all) != Shortage::kNone) return motion;
  motion.rest = frame.rest;
  motion.targets = commands.targets;
  // The shape is a share of the command where it is farthest in the window.
  of_all.shape *= of_all.targets.norm() / commands.targets.norm();
  motion.of_axis = motion_of(response, commands.targets.cols(), of_all.shape, settings.sample_period);
  return motion;
}

}  // namespace

Estimate identify(const std::vector<Trial>& trials, const Settings& settings) {
  Estimate estimate;
  if (trials.size() < kFewestTrials) return estimate;
  const Frame frame = frame_of(trials, settings);
  const WeakForm fine(frame.rows, settings.sample_period, frame.step);
  if (fine.size() < 5 * (kHighestOrder + 1) / 2) {
    estimate.shortage = Shortage::kTooFewRows;
    return estimate;
  }
  Commands commands;
  estimate.shortage = read_commands(trials, frame, commands);
  if (estimate.shortage != Shortage::kNone) return estimate;

  const MeanResponse mean = mean_response(trials, frame, commands, settings.sample_period);
  const CommandResponse response = command_response(mean);
  estimate.shortage = Shortage::kNoResponse;
  if (!response.is_found) return estimate;
  const WeakForm thin(mean.shape.size(), mean.sample_period, frame.step / frame.stride);
  const Prepared prepared = prepare(trials, frame, commands, response, fine, thin);

  const WeightedFit fit = fit_weighted(prepared.trials);
  estimate.shortage = Shortage::kSingular;
  if (!fit.is_found) return estimate;
  estimate.shortage = Shortage::kNone;
  estimate.theta = fit.theta;
  estimate.covariance.emplace(fit);
  estimate.condition = fit.condition;
  estimate.order = fit.process.order();
  estimate.rows = frame.rows * static_cast<Eigen::Index>(trials.size());
  estimate.command_unexplained = response.unexplained;
  estimate.motion = command_motion(trials, commands, response, settings);
  estimate.process = fit.process;
  estimate.offset_scatter = fit.offset_scatter;
  estimate.white = neighbours(fit);
  set_centre(fit, prepared, estimate);
  set_sigma(fit, estimate);
  estimate.alternatives =
      test_alternatives(fit, *estimate.covariance, prepared.predicted, thin, mean.sample_period);
  estimate.lag = test_lag(fit, *estimate.covariance, prepared.predicted, thin, mean.sample_period);
  estimate.misfit = test_misfit(fit, prepared.trials, commands.weights);
  const Eigen::Index axes = fit.theta.cols();
  estimate.theta.topRows(axes).diagonal().array() -= settings.handle_mass;
  return estimate;
}

}  // namespace tonus::refined
