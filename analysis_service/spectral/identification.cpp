#include "analysis_service/spectral/identification.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <set>

#include "analysis_service/spectral/activity.hpp"
#include "analysis_service/spectral/band_misfit.hpp"
#include "analysis_service/spectral/judgement.hpp"
#include "analysis_service/spectral/segment_fit.hpp"
#include "analysis_service/statistics/distributions.hpp"

namespace tonus::spectral {
namespace {

/// Segment lengths tried, as shares of the rows in which the input is on.
constexpr double kLengthShares[] = {1.0 / 60, 1.0 / 30, 1.0 / 16, 1.0 / 9, 1.0 / kSegmentsOfLongest};
constexpr Eigen::Index kShortestSegment = 32;

template <int N>
struct Candidate {
  SegmentFit<N> fit;
  BandMisfit misfit;

  /// Logarithm of the intervals' width after the misfit has widened them: less is better.
  [[nodiscard]] double width() const {
    bool is_physical = true;
    for (int i = 0; i < N; ++i) {
      for (int part = 0; part < 3; ++part) is_physical &= fit.p[part * N * N + i * N + i] > 0.0;
    }
    return fit.score + 1.5 * std::log(std::max(1.0, misfit.ratio)) + (is_physical ? 0.0 : 100.0);
  }
};

template <int N>
std::optional<Candidate<N>> candidate_of(std::span<const Record> records, Eigen::Index length,
                                         const FitSettings& settings, const Eigen::VectorXd& lead) {
  auto fit = fit_segments<N>(records, length, settings, lead);
  if (!fit || !fit->p.allFinite() || !fit->covariance.allFinite()) return std::nullopt;
  const BandMisfit misfit = misfit_of(*fit);
  return Candidate<N>{std::move(*fit), misfit};
}

/// Share of the force that neither the model explains nor the noise of the sensors, as it stands above the
/// band (equation 14): it may be the arm's own force, which the rig feeds back into the motion, so that it
/// may bias the response by as much.
template <int N>
double unaccounted_share(const SegmentFit<N>& fit) {
  Eigen::Matrix<double, N, 1> rest = Eigen::Matrix<double, N, 1>::Zero();
  Eigen::Matrix<double, N, 1> force = Eigen::Matrix<double, N, 1>::Zero();
  for (Eigen::Index k = 0; k < fit.w.size(); ++k) {
    const auto b = fit.likelihood.bin(fit.p, fit.all, k);
    rest += b.RR.diagonal().real() - b.Z.cwiseAbs2() * fit.displacement_floor - fit.force_floor;
    force +=
        fit.all.moments[static_cast<std::size_t>(k)].diagonal().real().template head<N>() / fit.all.segments;
  }
  return std::max(0.0, (rest.array() / force.array()).maxCoeff());
}

template <int N>
void set_numbers(const Candidate<N>& chosen, const Eigen::VectorXd& least_variance, Estimate& estimate) {
  const SegmentFit<N>& fit = chosen.fit;
  constexpr int kStructural = Likelihood<N>::kStructural;
  constexpr int kImpedance = Likelihood<N>::kImpedance;
  const double grown = std::max(1.0, chosen.misfit.ratio);
  // Never less than the scatter of the bands, and where the model fails, its misfit beside it.
  const Eigen::VectorXd over_bands = variance_over_bands(fit).cwiseMax(grown * least_variance);
  Eigen::VectorXd widen(kStructural);
  for (int i = 0; i < kStructural; ++i)
    widen[i] = std::sqrt(std::max(1.0, over_bands[i] / std::max(fit.covariance(i, i), 1e-300) / grown));
  Eigen::MatrixXd covariance = grown * fit.covariance.cwiseProduct(widen * widen.transpose());
  if (chosen.misfit.ratio > kMostRatio) {
    for (int i = 0; i < kImpedance; ++i)
      covariance(i, i) += std::pow(chosen.misfit.largest * fit.largest_beside(i), 2);
  }
  estimate.unaccounted = unaccounted_share(fit);
  for (int i = 0; i < kImpedance; ++i)
    covariance(i, i) += std::pow(estimate.unaccounted * fit.largest_beside(i), 2);
  const Eigen::VectorXd unit = fit.unit.head(kStructural);
  estimate.covariance = covariance.cwiseProduct(unit * unit.transpose());
  const Eigen::VectorXd value = fit.p.head(kStructural).cwiseProduct(unit);
  const Eigen::VectorXd error = estimate.covariance.diagonal().cwiseMax(0.0).cwiseSqrt();
  const auto matrix = [&](const Eigen::VectorXd& elements, int part) {
    Eigen::MatrixXd found(N, N);
    for (int i = 0; i < N; ++i) {
      for (int j = 0; j < N; ++j) found(i, j) = elements[part * N * N + i * N + j];
    }
    return found;
  };
  estimate.M = matrix(value, 0);
  estimate.B = matrix(value, 1);
  estimate.K = matrix(value, 2);
  estimate.M_error = matrix(error, 0);
  estimate.B_error = matrix(error, 1);
  estimate.K_error = matrix(error, 2);
  estimate.lag = value.tail(N) + fit.lead;
  estimate.lag_error = error.tail(N);
  estimate.t95 = statistics::student_t_quantile(0.975, fit.blocks() - 1);
  estimate.band_low = fit.w[0] / (2.0 * std::numbers::pi);
  estimate.band_high = fit.w[fit.w.size() - 1] / (2.0 * std::numbers::pi);
  estimate.segments = fit.segments.size();
  estimate.blocks = fit.blocks();
  estimate.coherence = fit.coherence.mean();
  Eigen::Matrix<double, N, 1> residual = Eigen::Matrix<double, N, 1>::Zero();
  Eigen::Matrix<double, N, 1> force = Eigen::Matrix<double, N, 1>::Zero();
  for (Eigen::Index k = 0; k < fit.w.size(); ++k) {
    const auto b = fit.likelihood.bin(fit.p, fit.all, k);
    residual += b.RR.diagonal().real();
    force +=
        fit.all.moments[static_cast<std::size_t>(k)].diagonal().real().template head<N>() / fit.all.segments;
  }
  estimate.explained = 1.0 - (residual.array() / force.array()).maxCoeff();
  const double spacing =
      static_cast<double>(fit.bins.back() - fit.bins.front() + 1) / static_cast<double>(fit.bins.size());
  estimate.sigma = (2.0 * spacing / static_cast<double>(fit.length) * residual).cwiseSqrt();
  estimate.sigma = estimate.sigma.cwiseProduct(fit.force_unit).eval();
}

/// The best-determined part of the excited band in which the model holds.
template <int N>
std::optional<Candidate<N>> best_part(std::span<const Record> records, const Candidate<N>& whole,
                                      const FitSettings& settings) {
  constexpr int kEdges = N == 1 ? 9 : 6;
  const double low = whole.fit.w[0] / (2.0 * std::numbers::pi);
  const double high = whole.fit.w[whole.fit.w.size() - 1] / (2.0 * std::numbers::pi);
  std::vector<double> edges;
  edges.reserve(kEdges);
  for (int i = 0; i < kEdges; ++i) edges.push_back(low * std::pow(high / low, i / (kEdges - 1.0)));
  edges.front() *= 0.99;
  edges.back() *= 1.01;
  std::optional<Candidate<N>> best;
  for (std::size_t i = 0; i + 1 < edges.size(); ++i) {
    for (std::size_t j = i + 2; j < edges.size(); ++j) {
      if (edges[j] <= 1.9 * edges[i]) continue;
      FitSettings part = settings;
      part.range = {edges[i], edges[j]};
      part.start = start_from(whole.fit);
      auto candidate = candidate_of<N>(records, whole.fit.length, part, whole.fit.lead);
      if (candidate && (!best || candidate->width() < best->width())) best = std::move(candidate);
    }
  }
  return best;
}

/// What is found once for all models of the same records.
template <int N>
struct Search {
  std::span<const Record> raw;
  std::vector<Record> records;  ///< filled()
  FitSettings settings;
  std::optional<Candidate<N>> whole;  ///< The linear model over the whole excited band.
  double frequencies = 0.0;           ///< Independent ones.
  Shortage shortage = Shortage::kNone;
};

/// The segment length with the narrowest intervals.
template <int N>
void find_length(Search<N>& search) {
  const auto active = static_cast<double>(rows_with_input(search.records));
  const Eigen::VectorXd no_lead = Eigen::VectorXd::Zero(N);
  std::set<Eigen::Index> lengths;
  for (const double share : kLengthShares) {
    const auto length = static_cast<Eigen::Index>(active * share) / 2 * 2;
    if (length >= kShortestSegment) lengths.insert(fast_length(length));
  }
  bool has_segments = false;
  for (const Eigen::Index length : lengths) {
    has_segments |= segments_of(search.records, length).size() >= kFewestSegments;
    auto candidate = candidate_of<N>(search.records, length, search.settings, no_lead);
    if (candidate && (!search.whole || candidate->width() < search.whole->width()))
      search.whole = std::move(candidate);
  }
  if (!search.whole) {
    search.shortage = has_segments ? Shortage::kNotCoherent : Shortage::kTooFewSegments;
    return;
  }
  search.frequencies = independent_frequencies(search.whole->fit);
  if (search.frequencies < kFewestFrequencies) search.shortage = Shortage::kTooFewFrequencies;
}

/// Numbers, terms and checks of a fit to `records`.
template <int N>
void conclude(const Search<N>& search, std::span<const Record> records, const Candidate<N>& chosen,
              const Eigen::VectorXd& least_variance, Estimate& estimate) {
  set_numbers(chosen, least_variance, estimate);
  estimate.frequencies = search.frequencies;
  estimate.segment_duration = static_cast<double>(chosen.fit.length) * records.front().sample_period;
  estimate.terms = fit_terms<N>(records, chosen.fit);
  judge<N>({search.raw, chosen.fit, chosen.misfit, search.whole->misfit.largest, search.settings.most_lag},
           estimate);
  // Where the noise alone leaves an element open, there is no result; where a misfit widens it, one that is
  // suspect.
  const bool is_determined = chosen.fit.relative_width.maxCoeff() <= kMostWidth;
  estimate.outcome = is_determined ? Outcome::kFound : Outcome::kUndetermined;
}

template <int N>
Estimate linear_estimate(const Search<N>& search) {
  Estimate estimate;
  estimate.axes = N;
  std::vector<Record> aligned;
  std::span<const Record> records = search.records;
  Candidate<N> chosen = *search.whole;
  if (!is_acceptable(chosen.misfit)) {
    auto part = best_part<N>(records, chosen, search.settings);
    if (part && part->width() < chosen.width()) {
      chosen = std::move(*part);
      estimate.is_part_of_band = true;
    }
  }
  // exp(jwd) on a windowed spectrum is exact for small lags alone: a large one is taken from the record.
  const Eigen::VectorXd lag = chosen.fit.p.segment(Likelihood<N>::kImpedance, N) / chosen.fit.w_unit;
  if (lag.cwiseAbs().maxCoeff() > 0.1 * records.front().sample_period) {
    for (const Record& record : records) aligned.push_back(with_force_advanced(record, lag));
    records = aligned;
    FitSettings settings = search.settings;
    settings.is_lag_known = true;
    settings.start = start_from(chosen.fit);
    const auto& w = chosen.fit.w;
    settings.range = {0.999 * w[0] / (2.0 * std::numbers::pi),
                      1.001 * w[w.size() - 1] / (2.0 * std::numbers::pi)};
    if (auto again = candidate_of<N>(records, chosen.fit.length, settings, lag)) chosen = std::move(*again);
  }
  conclude<N>(search, records, chosen, Eigen::VectorXd::Zero(Likelihood<N>::kStructural), estimate);
  return estimate;
}

/// `bic`: less that of the linear model.
template <int N>
Estimate extended_estimate(const Search<N>& search, Addition addition, double& bic) {
  Estimate estimate;
  estimate.axes = N;
  estimate.addition = addition;
  const auto extended = fit_extended<N>(search.records, search.whole->fit, addition, search.settings);
  if (!extended) {
    estimate.shortage = Shortage::kUnsettled;
    return estimate;
  }
  estimate.parameters = extended->parameters;
  bic = static_cast<double>(extended->parameters.size()) * std::log(extended->data) - 2.0 * extended->gain;
  const Candidate<N> chosen{extended->fit, misfit_of(extended->fit)};
  conclude<N>(search, extended->corrected, chosen, extended->variance, estimate);
  return estimate;
}

/// The simplest model that passes every check.
template <int N>
Estimate automatic_estimate(const Search<N>& search) {
  Estimate linear = linear_estimate(search);
  linear.compared.push_back({Addition::kNone, true, linear.is_ok(), 0.0});
  if (linear.is_ok()) return linear;
  std::vector<Compared> compared = linear.compared;
  std::optional<Estimate> best;
  double best_bic = 0.0;
  for (const Addition addition : {Addition::kFriction, Addition::kCubic, Addition::kReflex}) {
    double bic = 0.0;
    Estimate estimate = extended_estimate(search, addition, bic);
    const bool is_found = estimate.outcome != Outcome::kNone;
    const bool is_accepted = estimate.is_ok() && bic < 0.0;
    compared.push_back({addition, is_found, is_accepted, bic});
    if (!is_accepted) continue;
    const bool is_simpler = !best || estimate.parameters.size() < best->parameters.size();
    const bool is_likelier = best && estimate.parameters.size() == best->parameters.size() && bic < best_bic;
    if (!is_simpler && !is_likelier) continue;
    best = std::move(estimate);
    best_bic = bic;
  }
  Estimate& chosen = best ? *best : linear;
  chosen.compared = std::move(compared);
  return std::move(chosen);
}

template <int N>  // NOLINTNEXTLINE(performance-unnecessary-value-param): the records are moved on
Estimate identify(std::span<const Record> raw, std::vector<Record> records, const Settings& settings) {
  Search<N> search;
  search.raw = raw;
  search.records = std::move(records);
  search.settings.most_lag = std::max(settings.most_lag, 2.0 * raw.front().sample_period);
  find_length(search);
  if (search.shortage != Shortage::kNone) {
    Estimate none;
    none.frequencies = search.frequencies;
    none.axes = N;
    none.addition = settings.is_automatic ? Addition::kNone : settings.addition;
    none.shortage = search.shortage;
    return none;
  }
  if (settings.is_automatic) return automatic_estimate(search);
  if (settings.addition == Addition::kNone) return linear_estimate(search);
  double bic = 0.0;
  return extended_estimate(search, settings.addition, bic);
}

/// Why the records cannot be transformed at all. `whole`: filled().
Shortage shortage_of(std::span<const Record> records, std::span<const Record> whole) {
  Eigen::Index usable = 0;
  for (const Record& record : records) {
    for (Eigen::Index i = 0; i < record.samples(); ++i) usable += record.is_row_missing(i) ? 0 : 1;
  }
  if (usable < kFewestRows) return Shortage::kTooFewSamples;
  const auto is_moving = [&](Eigen::MatrixXd Record::*signals, Eigen::Index axis) {
    return std::ranges::any_of(whole, [&](const Record& record) {
      return (record.*signals).col(axis).maxCoeff() > (record.*signals).col(axis).minCoeff();
    });
  };
  for (int axis = 0; axis < records.front().axes(); ++axis) {
    if (!is_moving(&Record::displacement, axis) || !is_moving(&Record::force, axis))
      return Shortage::kNoMotion;
  }
  return Shortage::kNone;
}

}  // namespace

bool Estimate::is_ok() const {
  return outcome == Outcome::kFound && std::ranges::all_of(checks, &Check::is_passed);
}

Estimate identify(std::span<const Record> records, const Settings& settings) {
  Estimate none;
  none.shortage = Shortage::kTooFewSamples;
  if (records.empty()) return none;
  std::vector<Record> whole;
  for (const Record& record : records) whole.push_back(filled(record));
  none.axes = records.front().axes();
  none.shortage = shortage_of(records, whole);
  if (none.shortage != Shortage::kNone) return none;
  return none.axes == 1 ? identify<1>(records, std::move(whole), settings)
                        : identify<2>(records, std::move(whole), settings);
}

}  // namespace tonus::spectral
