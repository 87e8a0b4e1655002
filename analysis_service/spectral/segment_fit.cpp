#include "analysis_service/spectral/segment_fit.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "analysis_service/spectral/activity.hpp"
#include "analysis_service/statistics/distributions.hpp"

namespace tonus::spectral {
namespace {

constexpr Eigen::Index kFirstBin = 3;   // an offset reaches bins 0 to 2
constexpr double kLastBinShare = 0.45;  // of the length: below half the sample rate
constexpr Eigen::Index kFewestBins = 8;

using Complex = std::complex<double>;

/// Minimum of V by Newton's method; directions of negative curvature are taken by its magnitude, steps are
/// halved until V falls. The Hessian costs far more than the rest: it is kept for as long as a whole step
/// divides what is left by kGoodStep or more.
template <int N>
typename Likelihood<N>::Vector minimise(const Likelihood<N>& likelihood,
                                        const typename Likelihood<N>::Data& data,
                                        typename Likelihood<N>::Vector p) {
  using Model = Likelihood<N>;
  using Vector = typename Model::Vector;
  constexpr int kMostSteps = 60;
  constexpr double kLongestStep = 1.0;
  constexpr double kDecrement = 1e-6;  // of V, far below one unit of its logarithm
  constexpr double kGoodStep = 8.0;
  double value = likelihood.value(p, data);
  Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver;
  bool is_fresh = false;
  double last_decrement = 0.0;
  for (int step = 0; step < kMostSteps; ++step) {
    const Vector slope = likelihood.gradient(p, data);
    const auto step_along = [&] {
      const auto& eigenvalues = solver.eigenvalues();
      const double floor = 1e-9 * eigenvalues.cwiseAbs().maxCoeff() + 1e-12;
      const Vector along = solver.eigenvectors().transpose() * slope;
      Vector direction = Vector::Zero();
      for (int i = 0; i < Model::kParameters; ++i)
        direction -= solver.eigenvectors().col(i) * (along[i] / std::max(std::abs(eigenvalues[i]), floor));
      const double longest = direction.cwiseAbs().maxCoeff();
      if (longest > kLongestStep) direction *= kLongestStep / longest;
      return direction;
    };
    Vector direction = Vector::Zero();
    double decrement = 0.0;
    if (is_fresh) {
      direction = step_along();
      decrement = -slope.dot(direction);
      is_fresh = decrement * kGoodStep <= last_decrement;
    }
    if (!is_fresh) {
      solver.compute(likelihood.hessian(p, data));
      direction = step_along();
      decrement = -slope.dot(direction);
    }
    if (!(decrement > kDecrement)) break;
    last_decrement = decrement;
    double share = 1.0;
    bool is_lower = false;
    for (int half = 0; half < 30 && !is_lower; ++half) {
      const double tried = likelihood.value(p + share * direction, data);
      if (tried < value - 1e-4 * share * decrement) {
        p += share * direction;
        value = tried;
        is_lower = true;
      } else {
        share *= 0.5;
      }
    }
    if (!is_lower) break;
    is_fresh = share == 1.0;
  }
  return p;
}

/// Least squares weighted by coherence, the lag of each force on a grid.
template <int N>
typename Likelihood<N>::Vector start_of(const SegmentFit<N>& fit, const Eigen::ArrayXd& lags) {
  using Model = Likelihood<N>;
  typename Model::Vector p = Model::Vector::Zero();
  const Eigen::ArrayXd& w = fit.likelihood.w();
  for (int i = 0; i < N; ++i) {
    Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(3 * N, 3 * N);
    Eigen::ArrayXd weight(w.size());
    for (Eigen::Index k = 0; k < w.size(); ++k) {
      const auto& G = fit.all.moments[static_cast<std::size_t>(k)];
      weight[k] = fit.coherence[k] / (1.0001 - fit.coherence[k]) / std::max(G(i, i).real(), 1e-300);
      normal += weight[k] * G.template bottomRightCorner<3 * N, 3 * N>().real();
    }
    const auto solver = normal.completeOrthogonalDecomposition();
    double best = -std::numeric_limits<double>::infinity();
    for (const double lag : lags) {
      Eigen::VectorXd right = Eigen::VectorXd::Zero(3 * N);
      for (Eigen::Index k = 0; k < w.size(); ++k) {
        const auto& G = fit.all.moments[static_cast<std::size_t>(k)];
        right += weight[k] *
                 (std::polar(1.0, w[k] * lag) * G.row(i).template rightCols<3 * N>()).real().transpose();
      }
      const Eigen::VectorXd theta = solver.solve(right);
      const double explained = theta.dot(right);
      if (explained <= best) continue;
      best = explained;
      for (int part = 0; part < 3; ++part) p.segment(part * N * N + i * N, N) = theta.segment(part * N, N);
      p[Model::kImpedance + i] = lag;
    }
  }
  return p;
}

/// Noise laws: half of the residual in either signal.
template <int N>
void start_noise(SegmentFit<N>& fit) {
  using Model = Likelihood<N>;
  const Eigen::Index bins = fit.likelihood.bins();
  Eigen::MatrixXd design(bins, 2);
  design.col(0).setOnes();
  design.col(1) = fit.likelihood.w().log().matrix();
  Eigen::MatrixXd levels(bins, 2 * N);
  for (Eigen::Index k = 0; k < bins; ++k) {
    const auto b = fit.likelihood.bin(fit.p, fit.all, k);
    for (int i = 0; i < N; ++i) {
      const double residual = 0.5 * std::max(b.RR(i, i).real(), 1e-30);
      levels(k, 2 * i) = std::log(residual / std::max(std::norm(b.Z(i, i)), 1e-30));
      levels(k, 2 * i + 1) = std::log(residual);
    }
  }
  const Eigen::MatrixXd laws = design.colPivHouseholderQr().solve(levels);
  typename Model::Vector centre = fit.p;
  for (int i = 0; i < 2 * N; ++i) {
    const int at = Model::kStructural + 2 * i;
    fit.p[at] = centre[at] = laws(0, i);
    fit.p[at + 1] = std::clamp(laws(1, i), -2.0, 2.0);
    centre[at + 1] = 0.0;
  }
  fit.likelihood.centre_noise(centre);
}

/// ln of the unit of the noises' powers, of displacement and force of each axis.
template <int N>
Eigen::Matrix<double, 2 * N, 1> noise_units(const SegmentFit<N>& fit) {
  Eigen::Matrix<double, 2 * N, 1> units;
  for (int i = 0; i < N; ++i) {
    units[2 * i] = 2.0 * std::log(fit.displacement_unit[i]);
    units[2 * i + 1] = 2.0 * std::log(fit.force_unit[i]);
  }
  return units;
}

/// The start that the settings give, scaled. The prior stays centred at the laws of its residual.
template <int N>
void take_start(const FitSettings& settings, SegmentFit<N>& fit) {
  using Model = Likelihood<N>;
  fit.p.template head<Model::kStructural>() =
      settings.start.template head<Model::kStructural>().cwiseQuotient(
          fit.unit.template head<Model::kStructural>());
  if (settings.is_lag_known) fit.p.template segment<N>(Model::kImpedance).setZero();
  start_noise(fit);
  const auto units = noise_units(fit);
  for (int i = 0; i < 2 * N; ++i) {
    const int at = Model::kStructural + 2 * i;
    fit.p[at + 1] = settings.start[at + 1];
    fit.p[at] = settings.start[at] - units[i] + settings.start[at + 1] * std::log(fit.w_unit);
  }
}

template <int N>
void set_units(SegmentFit<N>& fit) {
  for (int i = 0; i < N; ++i) {
    for (int j = 0; j < N; ++j) {
      const double stiffness = fit.force_unit[i] / fit.displacement_unit[j];
      fit.unit[i * N + j] = stiffness / (fit.w_unit * fit.w_unit);
      fit.unit[N * N + i * N + j] = stiffness / fit.w_unit;
      fit.unit[2 * N * N + i * N + j] = stiffness;
    }
    fit.unit[3 * N * N + i] = 1.0 / fit.w_unit;
  }
}

/// Moments of the blocks of segments, of all, and of all but one.
template <int N>
void set_moments(SegmentFit<N>& fit) {
  using Model = Likelihood<N>;
  const auto count = static_cast<int>(fit.segments.size());
  const int blocks = std::min(kMostBlocks, count / 3);
  const auto bins = static_cast<std::size_t>(fit.w.size());
  typename Model::Data none;
  none.moments.assign(bins, Model::Moment::Zero());
  fit.all = none;
  fit.only.assign(static_cast<std::size_t>(blocks), none);
  for (int s = 0; s < count; ++s) {
    const int block = std::min(s * blocks / count, blocks - 1);
    fit.block_of.push_back(block);
    auto& data = fit.only[static_cast<std::size_t>(block)];
    data.segments += 1.0;
    const Eigen::MatrixXcd& Y = fit.Y[static_cast<std::size_t>(s)];
    for (std::size_t k = 0; k < bins; ++k) {
      const Eigen::Matrix<Complex, 4 * N, 1> y = Y.col(static_cast<Eigen::Index>(k));
      data.moments[k].noalias() += y * y.adjoint();
    }
  }
  for (const auto& data : fit.only) {
    fit.all.segments += data.segments;
    for (std::size_t k = 0; k < bins; ++k) fit.all.moments[k] += data.moments[k];
  }
  for (const auto& data : fit.only) {
    typename Model::Data rest = fit.all;
    rest.segments -= data.segments;
    for (std::size_t k = 0; k < bins; ++k) rest.moments[k] -= data.moments[k];
    fit.without.push_back(std::move(rest));
  }
}

template <int N>
typename Likelihood<N>::Hessian inverse_of(const typename Likelihood<N>::Hessian& H) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(H);
  const double floor = 1e-13 * solver.eigenvalues().cwiseAbs().maxCoeff();
  Eigen::MatrixXd inverse = Eigen::MatrixXd::Zero(H.rows(), H.cols());
  for (int i = 0; i < H.rows(); ++i) {
    const double value = solver.eigenvalues()[i];
    if (std::abs(value) <= floor) continue;
    inverse += solver.eigenvectors().col(i) * solver.eigenvectors().col(i).transpose() / value;
  }
  return inverse;
}

/// Block jackknife, linearised by the Hessian (equation 10), never below the inverse Hessian.
template <int N>
void set_covariance(SegmentFit<N>& fit) {
  using Model = Likelihood<N>;
  constexpr int kStructural = Model::kStructural;
  fit.inverse_hessian = inverse_of<N>(fit.likelihood.hessian(fit.p, fit.all));
  const int m = fit.blocks();
  fit.shifts.resize(m, Model::kParameters);
  for (int b = 0; b < m; ++b)
    fit.shifts.row(b) =
        -(fit.inverse_hessian * fit.likelihood.gradient(fit.p, fit.without[static_cast<std::size_t>(b)]))
             .transpose();
  fit.shifts.rowwise() -= fit.shifts.colwise().mean().eval();
  fit.covariance = (static_cast<double>(m - 1) / m * (fit.shifts.transpose() * fit.shifts))
                       .topLeftCorner(kStructural, kStructural);
  fit.variation = 0.0;
  Eigen::VectorXd grown(kStructural);
  for (int i = 0; i < kStructural; ++i) {
    const double jackknife = std::max(fit.covariance(i, i), 1e-300);
    const double curvature = std::max(fit.inverse_hessian(i, i), 0.0);
    grown[i] = std::sqrt(std::max(1.0, curvature / jackknife));
    if (i < Model::kImpedance && curvature > 0.0)
      fit.variation = std::max(fit.variation, jackknife / curvature);
  }
  fit.covariance = fit.covariance.cwiseProduct(grown * grown.transpose()).eval();
  const double t = statistics::student_t_quantile(0.975, m - 1);
  fit.relative_width.resize(Model::kImpedance);
  fit.score = 0.0;
  for (int i = 0; i < Model::kImpedance; ++i) {
    fit.relative_width[i] = t * std::sqrt(fit.covariance(i, i)) / fit.largest_beside(i);
    fit.score += std::log(std::clamp(fit.relative_width[i], 1e-4, 10.0)) / (N * N);
  }
}

}  // namespace

template <int N>
Eigen::VectorXd start_from(const SegmentFit<N>& fit) {
  using Model = Likelihood<N>;
  Eigen::VectorXd start = fit.p;
  start.head<Model::kStructural>() =
      fit.p.template head<Model::kStructural>().cwiseProduct(fit.unit.template head<Model::kStructural>());
  const auto units = noise_units(fit);
  for (int i = 0; i < 2 * N; ++i) {
    const int at = Model::kStructural + 2 * i;
    start[at] += units[i] - fit.p[at + 1] * std::log(fit.w_unit);
  }
  return start;
}

template <int N>
double independent_frequencies(const SegmentFit<N>& fit) {
  const auto bins = fit.w.size();
  const auto segments = static_cast<Eigen::Index>(fit.Y.size());
  double fewest = std::numeric_limits<double>::infinity();
  for (int axis = 0; axis < N; ++axis) {
    Eigen::MatrixXcd X(bins, segments);
    for (Eigen::Index s = 0; s < segments; ++s)
      X.col(s) = fit.Y[static_cast<std::size_t>(s)].row(3 * N + axis).transpose();
    X.rowwise().normalize();
    // sum |X X^H|^2 = sum |X^H X|^2: the smaller product.
    const double squares =
        bins < segments ? (X * X.adjoint()).squaredNorm() : (X.adjoint() * X).squaredNorm();
    fewest = std::min(fewest, static_cast<double>(bins * bins) / std::max(squares, 1e-300));
  }
  return fewest;
}

template <int N>
std::optional<SegmentFit<N>> fit_segments(std::span<const Record> records, Eigen::Index length,
                                          const FitSettings& settings, const Eigen::VectorXd& lead) {
  const std::vector<Segment> segments = segments_of(records, length);
  if (segments.size() < kFewestSegments) return std::nullopt;
  const double period = records.front().sample_period;
  const Bins bins{kFirstBin, static_cast<Eigen::Index>(kLastBinShare * static_cast<double>(length))};
  if (bins.end - bins.first < kFewestBins) return std::nullopt;
  const double step = 2.0 * std::numbers::pi / (static_cast<double>(length) * period);
  const Eigen::ArrayXd w = Eigen::ArrayXd::LinSpaced(bins.end - bins.first, static_cast<double>(bins.first),
                                                     static_cast<double>(bins.end - 1)) *
                           step;
  const auto Y = windowed_spectra(records, segments, length, bins);
  Eigen::MatrixXd power(static_cast<Eigen::Index>(Y.size()), N);
  for (std::size_t segment = 0; segment < Y.size(); ++segment)
    power.row(static_cast<Eigen::Index>(segment)) =
        (Y[segment].bottomRows(N).cwiseAbs2() * w.square().matrix()).transpose();
  const std::vector<std::size_t> active = pieces_with_input(power);
  if (active.size() < kFewestSegments) return std::nullopt;
  const BinChoice choice = choose_bins<N>(Y, active, w, settings.least_coherence, settings.range);
  const std::vector<Eigen::Index>& chosen = choice.bins;
  if (static_cast<Eigen::Index>(chosen.size()) < kFewestBins) return std::nullopt;

  SegmentFit<N> fit;
  fit.length = length;
  fit.lead = lead;
  fit.w = w(chosen);
  fit.coherence = choice.coherence(chosen);
  for (const Eigen::Index k : chosen) fit.bins.push_back(k + bins.first);
  fit.w_unit = std::exp(fit.w.log().mean());
  fit.force_unit.setZero();
  fit.displacement_unit.setZero();
  for (const std::size_t s : active) {
    fit.segments.push_back(segments[s]);
    fit.Y.push_back(Y[s](Eigen::all, chosen));
    fit.force_unit += fit.Y.back().topRows(N).rowwise().squaredNorm();
    fit.displacement_unit += fit.Y.back().bottomRows(N).rowwise().squaredNorm();
  }
  const double count = static_cast<double>(active.size()) * static_cast<double>(chosen.size());
  fit.force_unit = (fit.force_unit / count).cwiseSqrt();
  fit.displacement_unit = (fit.displacement_unit / count).cwiseSqrt();
  if (!(fit.force_unit.minCoeff() > 0.0) || !(fit.displacement_unit.minCoeff() > 0.0)) return std::nullopt;
  constexpr double kClearOfBand = 1.3;
  const auto above =
      static_cast<Eigen::Index>(kClearOfBand * static_cast<double>(fit.bins.back())) - bins.first + 1;
  for (int i = 0; i < N; ++i) {
    fit.force_floor[i] = noise_floor(Y, active, i, above) / (fit.force_unit[i] * fit.force_unit[i]);
    fit.displacement_floor[i] =
        noise_floor(Y, active, 3 * N + i, above) / (fit.displacement_unit[i] * fit.displacement_unit[i]);
  }
  for (auto& y : fit.Y) {
    for (int i = 0; i < N; ++i) {
      y.row(i) /= fit.force_unit[i];
      y.row(N + i) /= fit.displacement_unit[i] * fit.w_unit * fit.w_unit;
      y.row(2 * N + i) /= fit.displacement_unit[i] * fit.w_unit;
      y.row(3 * N + i) /= fit.displacement_unit[i];
    }
  }
  set_units(fit);
  fit.likelihood =
      Likelihood<N>(fit.w / fit.w_unit, static_cast<double>(active.size()) / (kOverlap * kBinCorrelation));
  set_moments(fit);

  const double top = fit.w[fit.w.size() - 1];
  const double most = settings.is_lag_known ? 0.0 : settings.most_lag;
  const auto each_way = static_cast<Eigen::Index>(std::clamp(std::ceil(most * top / 0.6), 30.0, 400.0));
  const Eigen::ArrayXd lags = settings.is_lag_known
                                  ? Eigen::ArrayXd(Eigen::ArrayXd::Zero(1))
                                  : Eigen::ArrayXd::LinSpaced(2 * each_way + 1, -most, most) * fit.w_unit;
  if (settings.start.size() == SegmentFit<N>::Model::kParameters) {
    take_start(settings, fit);
  } else {
    fit.p = start_of(fit, lags);
    start_noise(fit);
  }
  fit.p = minimise<N>(fit.likelihood, fit.all, fit.p);
  set_covariance(fit);
  return fit;
}

template Eigen::VectorXd start_from<1>(const SegmentFit<1>&);
template Eigen::VectorXd start_from<2>(const SegmentFit<2>&);
template double independent_frequencies<1>(const SegmentFit<1>&);
template double independent_frequencies<2>(const SegmentFit<2>&);
template std::optional<SegmentFit<1>> fit_segments<1>(std::span<const Record>, Eigen::Index,
                                                      const FitSettings&, const Eigen::VectorXd&);
template std::optional<SegmentFit<2>> fit_segments<2>(std::span<const Record>, Eigen::Index,
                                                      const FitSettings&, const Eigen::VectorXd&);

}  // namespace tonus::spectral
