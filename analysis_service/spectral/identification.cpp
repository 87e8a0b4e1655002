#include "analysis_service/spectral/identification.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <set>

#include "analysis_service/spectral/band_misfit.hpp"
#include "analysis_service/spectral/sample_defects.hpp"
#include "analysis_service/spectral/segment_fit.hpp"
#include "analysis_service/spectral/statistics.hpp"

namespace tonus::spectral {
namespace {

/// Segment lengths tried, as shares of the rows in which the input is on.
constexpr double kLengthShares[] = {1.0 / 60, 1.0 / 30, 1.0 / 16, 1.0 / 9, 1.0 / 5.5};
constexpr Eigen::Index kShortestSegment = 32;
constexpr double kLeastExplained = 0.5;
constexpr double kLeastCoherence = 0.5;
constexpr double kMostLagShare = 0.9;  // of the lags searched
constexpr double kMostClipped = 5e-4;
constexpr double kMostHeldShare = 0.05;
constexpr double kMostVariation = 8.0;      // of the blocks over what the noise explains, in variances
constexpr double kVariationMatters = 0.02;  // relative half-width below which it does not
constexpr double kMostWidth = 0.5;
constexpr double kMostPositionChange = 0.2;
constexpr double kHalvesEffect = 0.03;
constexpr double kLevelStrict = 1e-4;  // one-sided, of a term with a small effect
constexpr double kLevelLoose = 5e-3;   // of a term that changes the result by more than its interval

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

/// Rows in which the input is on: of 120 pieces of all records, those whose motion is not much weaker than
/// that of the strongest.
Eigen::Index active_rows(std::span<const Record> records) {
  Eigen::Index rows = 0;
  for (const Record& record : records) rows += record.samples();
  const Eigen::Index piece = std::max<Eigen::Index>(2, rows / 120);
  const int axes = records.front().axes();
  std::vector<std::vector<double>> powers(static_cast<std::size_t>(axes));
  for (const Record& record : records) {
    for (Eigen::Index first = 0; first + piece <= record.samples(); first += piece) {
      for (int axis = 0; axis < axes; ++axis) {
        const auto x = record.displacement.col(axis).segment(first, piece);
        powers[static_cast<std::size_t>(axis)].push_back((x.array() - x.mean()).square().sum());
      }
    }
  }
  std::vector<double> power(powers.front().size(), 0.0);
  for (const auto& of_axis : powers) {
    double total = 0.0;
    for (const double value : of_axis) total += value;
    for (std::size_t i = 0; i < power.size(); ++i) power[i] += total > 0.0 ? of_axis[i] / total : 0.0;
  }
  std::vector<double> sorted = power;
  std::ranges::sort(sorted, std::greater<>());
  const std::size_t strongest = std::min<std::size_t>(6, sorted.size());
  if (strongest == 0) return rows;
  double mean = 0.0;
  for (std::size_t i = 0; i < strongest; ++i) mean += sorted[i] / static_cast<double>(strongest);
  const auto active = std::ranges::count_if(power, [&](double p) { return p > 0.05 * mean; });
  return static_cast<Eigen::Index>(std::llround(static_cast<double>(rows) * static_cast<double>(active) /
                                                static_cast<double>(power.size())));
}

template <int N>
class Judgement {
 public:
  Judgement(std::span<const Record> raw, std::span<const Record> records, const Candidate<N>& chosen,
            const Settings& settings, Estimate& estimate)
      : raw_(raw), records_(records), chosen_(chosen), settings_(settings), estimate_(estimate) {}

  void judge() {
    add_at_least(Test::kExplainedShare, estimate_.explained, kLeastExplained);
    add_at_least(Test::kCoherence, estimate_.coherence, kLeastCoherence);
    judge_halves();
    judge_bands();
    add_at_most(Test::kLag, estimate_.lag.cwiseAbs().maxCoeff(), kMostLagShare * settings_.most_lag);
    add_at_least(Test::kUnits, estimate_.blocks, 6);
    judge_terms();
    judge_samples();
    judge_steadiness();
    add_at_most(Test::kWidth, width(), kMostWidth);
  }

 private:
  void add(Test test, double value, double limit, bool is_passed) {
    estimate_.checks.push_back({test, value, limit, is_passed});
  }
  void add_at_least(Test test, double value, double limit) { add(test, value, limit, value >= limit); }
  void add_at_most(Test test, double value, double limit) { add(test, value, limit, value <= limit); }

  /// Largest relative 95 % half-width of an element.
  [[nodiscard]] double width() const {
    double widest = 0.0;
    const auto relative = [&](const Eigen::MatrixXd& value, const Eigen::MatrixXd& error) {
      const double of_matrix = estimate_.t95 * error.maxCoeff() / value.cwiseAbs().maxCoeff();
      widest =
          std::isfinite(of_matrix) ? std::max(widest, of_matrix) : std::numeric_limits<double>::infinity();
    };
    relative(estimate_.M, estimate_.M_error);
    relative(estimate_.B, estimate_.B_error);
    relative(estimate_.K, estimate_.K_error);
    return widest;
  }

  /// The limit is what both tests allow: significance, and an effect that matters.
  void judge_halves() {
    double value = 0.0;
    double limit = 1.0;
    double excess = -1.0;
    for (const bool is_middle : {false, true}) {
      const HalvesDifference halves = halves_of(chosen_.fit, is_middle);
      const double allowed_effect = std::max(kHalvesEffect, width());
      const double allowed =
          std::max(halves.threshold, halves.value * allowed_effect / std::max(halves.effect, 1e-12));
      const double over = halves.value / std::max(allowed, 1e-12);
      if (over <= excess) continue;
      excess = over;
      value = halves.value;
      limit = allowed;
    }
    add_at_most(Test::kHalves, value, limit);
  }

  void judge_bands() {
    const BandMisfit& misfit = chosen_.misfit;
    const double significant = misfit.largest * std::sqrt(kMostRatio / std::max(misfit.ratio, 1e-12));
    double limit = std::max(significant, misfit.ratio < kSmallMisfitRatio ? kSmallMisfit : 0.0);
    double value = misfit.largest;
    if (estimate_.is_part_of_band) {  // of the band that was excited the model holds in a part alone
      value = std::max(value, excited_misfit);
      limit = std::min(limit, kSmallMisfit);
    }
    add(Test::kBands, value, limit, !estimate_.is_part_of_band && is_acceptable(misfit));
  }

  void judge_terms() {
    judge_shares(Test::kFriction, {Term::kFriction, Term::kDrag});
    judge_shares(Test::kHardening, {Term::kHardening});
    const double strict = student_t_quantile(1.0 - kLevelStrict / (N * N), estimate_.blocks - 1);
    double value = 0.0;
    double limit = kMostPositionChange;
    double excess = -1.0;
    for (const TermFit& term : estimate_.terms) {
      if (term.term != Term::kPosition) continue;
      const double allowed =
          std::max(kMostPositionChange, term.stiffness_change * strict / std::max(std::abs(term.t), 1e-12));
      const double over = term.stiffness_change / std::max(allowed, 1e-300);
      if (over <= excess) continue;
      excess = over;
      value = term.stiffness_change;
      limit = allowed;
    }
    add_at_most(Test::kPosition, value, limit);
  }

  /// A term fails where it is significant and changes the result: the share at which both begin is the limit.
  void judge_shares(Test test, std::initializer_list<Term> terms) {
    const double freedom = estimate_.blocks - 1;
    const double comparisons = static_cast<double>(N * N);
    const double strict = student_t_quantile(1.0 - kLevelStrict / comparisons, freedom);
    const double loose = student_t_quantile(1.0 - kLevelLoose / comparisons, freedom);
    const double half_width = width();
    double value = 0.0;
    double limit = 1.0;
    double excess = -1.0;
    for (const TermFit& term : estimate_.terms) {
      if (std::ranges::find(terms, term.term) == terms.end()) continue;
      const double t = std::max(std::abs(term.t), 1e-12);
      const double change = std::max(term.change, 1e-12);
      const double over = 1.0 / std::min(std::max(strict / t, std::max(0.01, 0.5 * half_width) / change),
                                         std::max(loose / t, std::max(0.02, half_width) / change));
      if (over <= excess) continue;
      excess = over;
      value = term.share;
      limit = term.share / over;
    }
    add_at_most(test, value, limit);
  }

  void judge_samples() {
    double clipped = 0.0;
    double held = 0.0;
    for (const Record& record : raw_) {
      for (const auto* signals : {&record.displacement, &record.force}) {
        for (Eigen::Index axis = 0; axis < signals->cols(); ++axis) {
          std::vector<double> usable;
          for (Eigen::Index i = 0; i < record.samples(); ++i) {
            if (!record.is_row_missing(i)) usable.push_back((*signals)(i, axis));
          }
          const SampleDefects defects = sample_defects_of(
              Eigen::Map<const Eigen::VectorXd>(usable.data(), static_cast<Eigen::Index>(usable.size())));
          clipped = std::max(clipped, defects.clipped_share);
          held = std::max(held, defects.held_share);
        }
      }
    }
    add_at_most(Test::kClipping, clipped, kMostClipped);
    add_at_most(Test::kHeldSamples, held, kMostHeldShare);
  }

  void judge_steadiness() {
    const double limit =
        width() > kVariationMatters ? std::sqrt(kMostVariation) : std::numeric_limits<double>::infinity();
    const double value = std::sqrt(chosen_.fit.variation);
    add_at_most(Test::kSteadiness, value,
                std::isinf(limit) ? std::max(value, std::sqrt(kMostVariation)) : limit);
  }

 public:
  double excited_misfit = 0.0;

 private:
  std::span<const Record> raw_;
  std::span<const Record> records_;
  const Candidate<N>& chosen_;
  const Settings& settings_;
  Estimate& estimate_;
};

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
void set_numbers(const Candidate<N>& chosen, Estimate& estimate) {
  const SegmentFit<N>& fit = chosen.fit;
  constexpr int kStructural = Likelihood<N>::kStructural;
  constexpr int kImpedance = Likelihood<N>::kImpedance;
  const double grown = std::max(1.0, chosen.misfit.ratio);
  // Never less than the scatter of the bands, and where the model fails, its misfit beside it.
  const Eigen::VectorXd over_bands = variance_over_bands(fit);
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
  estimate.t95 = student_t_quantile(0.975, fit.blocks() - 1);
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
  for (int i = 0; i < kEdges; ++i) edges.push_back(low * std::pow(high / low, i / (kEdges - 1.0)));
  edges.front() *= 0.99;
  edges.back() *= 1.01;
  std::optional<Candidate<N>> best;
  for (std::size_t i = 0; i + 1 < edges.size(); ++i) {
    for (std::size_t j = i + 2; j < edges.size(); ++j) {
      if (edges[j] <= 1.9 * edges[i]) continue;
      FitSettings part = settings;
      part.range = {edges[i], edges[j]};
      auto candidate = candidate_of<N>(records, whole.fit.length, part, whole.fit.lead);
      if (candidate && (!best || candidate->width() < best->width())) best = std::move(candidate);
    }
  }
  return best;
}

template <int N>
void identify(std::span<const Record> raw, const Settings& given, Estimate& estimate) {
  std::vector<Record> records;
  for (const Record& record : raw) records.push_back(filled(record));
  Settings settings = given;
  settings.most_lag = std::max(settings.most_lag, 2.0 * raw.front().sample_period);
  FitSettings fit_settings;
  fit_settings.most_lag = settings.most_lag;

  const auto active = static_cast<double>(active_rows(records));
  const Eigen::VectorXd no_lead = Eigen::VectorXd::Zero(N);
  std::set<Eigen::Index> lengths;
  for (const double share : kLengthShares) {
    const auto length = static_cast<Eigen::Index>(active * share) / 2 * 2;
    if (length >= kShortestSegment) lengths.insert(fast_length(length));
  }
  std::optional<Candidate<N>> chosen;
  bool has_segments = false;
  for (const Eigen::Index length : lengths) {
    has_segments |= segments_of(records, length).size() >= kFewestSegments;
    auto candidate = candidate_of<N>(records, length, fit_settings, no_lead);
    if (candidate && (!chosen || candidate->width() < chosen->width())) chosen = std::move(candidate);
  }
  if (!chosen) {
    estimate.shortage = has_segments ? Shortage::kNotCoherent : Shortage::kTooFewSegments;
    return;
  }
  const BandMisfit excited = chosen->misfit;
  if (!is_acceptable(chosen->misfit)) {
    auto part = best_part<N>(records, *chosen, fit_settings);
    if (part && part->width() < chosen->width()) {
      chosen = std::move(part);
      estimate.is_part_of_band = true;
    }
  }
  // exp(jwd) on a windowed spectrum is exact for small lags alone: a large one is taken from the record.
  const Eigen::VectorXd lag = chosen->fit.p.segment(Likelihood<N>::kImpedance, N) / chosen->fit.w_unit;
  if (lag.cwiseAbs().maxCoeff() > 0.1 * raw.front().sample_period) {
    for (Record& record : records) record = with_force_advanced(record, lag);
    FitSettings aligned = fit_settings;
    aligned.is_lag_known = true;
    const auto& w = chosen->fit.w;
    aligned.range = {0.999 * w[0] / (2.0 * std::numbers::pi),
                     1.001 * w[w.size() - 1] / (2.0 * std::numbers::pi)};
    if (auto again = candidate_of<N>(records, chosen->fit.length, aligned, lag)) chosen = std::move(again);
  }
  set_numbers(*chosen, estimate);
  estimate.segment_duration = static_cast<double>(chosen->fit.length) * raw.front().sample_period;
  estimate.terms = fit_terms<N>(records, chosen->fit);
  Judgement<N> judgement(raw, records, *chosen, settings, estimate);
  judgement.excited_misfit = excited.largest;
  judgement.judge();
  // Where the noise alone leaves an element open, there is no result; where a misfit widens it, one that is
  // suspect.
  const bool is_determined = chosen->fit.relative_width.maxCoeff() <= kMostWidth;
  estimate.outcome = is_determined ? Outcome::kFound : Outcome::kUndetermined;
}

/// Why the records cannot be transformed at all.
Shortage shortage_of(std::span<const Record> records) {
  Eigen::Index usable = 0;
  for (const Record& record : records) {
    for (Eigen::Index i = 0; i < record.samples(); ++i) usable += record.is_row_missing(i) ? 0 : 1;
  }
  if (usable < kFewestRows) return Shortage::kTooFewSamples;
  for (int axis = 0; axis < records.front().axes(); ++axis) {
    bool is_moving = false;
    bool is_forced = false;
    for (const Record& record : records) {
      const Record whole = filled(record);
      is_moving |= whole.displacement.col(axis).maxCoeff() > whole.displacement.col(axis).minCoeff();
      is_forced |= whole.force.col(axis).maxCoeff() > whole.force.col(axis).minCoeff();
    }
    if (!is_moving || !is_forced) return Shortage::kNoMotion;
  }
  return Shortage::kNone;
}

}  // namespace

bool Estimate::is_ok() const {
  return outcome == Outcome::kFound && std::ranges::all_of(checks, &Check::is_passed);
}

Estimate identify(std::span<const Record> records, const Settings& settings) {
  Estimate estimate;
  if (records.empty()) {
    estimate.shortage = Shortage::kTooFewSamples;
    return estimate;
  }
  estimate.axes = records.front().axes();
  estimate.shortage = shortage_of(records);
  if (estimate.shortage != Shortage::kNone) return estimate;
  if (estimate.axes == 1) {
    identify<1>(records, settings, estimate);
  } else {
    identify<2>(records, settings, estimate);
  }
  return estimate;
}

}  // namespace tonus::spectral
