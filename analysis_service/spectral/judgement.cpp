#include "analysis_service/spectral/judgement.hpp"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <vector>

#include "analysis_service/spectral/sample_defects.hpp"
#include "analysis_service/statistics/distributions.hpp"

namespace tonus::spectral {
namespace {

constexpr double kLeastExplained = 0.5;
constexpr double kLeastCoherence = 0.5;
constexpr double kFewestBlocks = 6;
constexpr double kMostLagShare = 0.9;  // of the lags searched
constexpr double kMostClipped = 5e-4;
constexpr double kMostHeldShare = 0.05;
constexpr double kMostVariation = 8.0;      // of the blocks over what the noise explains, in variances
constexpr double kVariationMatters = 0.02;  // relative half-width below which it does not
constexpr double kMostPositionChange = 0.2;
constexpr double kHalvesEffect = 0.03;
constexpr double kLevelStrict = 1e-4;   // one-sided, of a term with a small effect
constexpr double kLevelLoose = 5e-3;    // of a term that changes the result by more than its interval
constexpr double kLeastFromEnd = 1e-4;  // s, of a reflex's delay from the end of its search
constexpr double kTiny = 1e-12;

/// Of several values with limits of their own, the one that is furthest over its limit.
struct Furthest {
  double value = 0.0;
  double limit;
  double over = -1.0;

  explicit Furthest(double limit_if_none) : limit(limit_if_none) {}

  void take(double a_value, double its_limit, double its_over) {
    if (its_over <= over) return;
    value = a_value;
    limit = its_limit;
    over = its_over;
  }
};

template <int N>
class Judge {
 public:
  Judge(const Judged<N>& judged, Estimate& estimate) : judged_(judged), estimate_(estimate) {}

  void judge() {
    add_at_least(Test::kExplainedShare, estimate_.explained, kLeastExplained);
    add_at_least(Test::kCoherence, estimate_.coherence, kLeastCoherence);
    judge_halves();
    judge_bands();
    add_at_most(Test::kLag, estimate_.lag.cwiseAbs().maxCoeff(), kMostLagShare * judged_.most_lag);
    add_at_least(Test::kUnits, estimate_.blocks, kFewestBlocks);
    judge_terms(Test::kFriction, {Term::kFriction, Term::kDrag}, N * N);
    judge_terms(Test::kHardening, {Term::kHardening}, N * N);
    judge_position();
    judge_terms(Test::kReflex, {Term::kReflex}, N * N * static_cast<double>(kReflexDelays.size()));
    judge_samples();
    judge_steadiness();
    add_at_most(Test::kWidth, width(), kMostWidth);
    if constexpr (N == 2) judge_symmetry();
    if (estimate_.addition == Addition::kReflex) judge_delay();
  }

 private:
  void add(Test test, double value, double limit, bool is_passed) {
    estimate_.checks.push_back({test, value, limit, is_passed});
  }
  void add_at_least(Test test, double value, double limit) { add(test, value, limit, value >= limit); }
  void add_at_most(Test test, double value, double limit) { add(test, value, limit, value <= limit); }
  void add_at_most(Test test, const Furthest& worst) { add_at_most(test, worst.value, worst.limit); }

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
    Furthest worst(1.0);
    for (const bool is_middle : {false, true}) {
      const HalvesDifference halves = halves_of(judged_.fit, is_middle);
      const double allowed_effect = std::max(kHalvesEffect, width());
      const double allowed =
          std::max(halves.threshold, halves.value * allowed_effect / std::max(halves.effect, kTiny));
      worst.take(halves.value, allowed, halves.value / std::max(allowed, kTiny));
    }
    add_at_most(Test::kHalves, worst);
  }

  void judge_bands() {
    const BandMisfit& misfit = judged_.misfit;
    const double significant = misfit.largest * std::sqrt(kMostRatio / std::max(misfit.ratio, kTiny));
    double limit = std::max(significant, misfit.ratio < kSmallMisfitRatio ? kSmallMisfit : 0.0);
    double value = misfit.largest;
    if (estimate_.is_part_of_band) {  // of the band that was excited the model holds in a part alone
      value = std::max(value, judged_.excited_misfit);
      limit = std::min(limit, kSmallMisfit);
    }
    add(Test::kBands, value, limit, !estimate_.is_part_of_band && is_acceptable(misfit));
  }

  [[nodiscard]] double t_at(double level, double comparisons) const {
    return statistics::student_t_quantile(1.0 - level / comparisons, estimate_.blocks - 1);
  }

  /// How far a change (relative to the largest element) of this t is over what is both significant and
  /// matters.
  [[nodiscard]] double over(double t, double change, double comparisons) const {
    t = std::max(std::abs(t), kTiny);
    change = std::max(change, kTiny);
    const double half_width = width();
    return 1.0 /
           std::min(std::max(t_at(kLevelStrict, comparisons) / t, std::max(0.01, 0.5 * half_width) / change),
                    std::max(t_at(kLevelLoose, comparisons) / t, std::max(0.02, half_width) / change));
  }

  /// A delay within its standard error of the end of the search may lie beyond it.
  void judge_delay() {
    for (const Parameter& parameter : estimate_.parameters) {
      if (parameter.kind != Parameter::Kind::kReflexDelay) continue;
      const double from_end = std::min(parameter.value - kShortestReflex, kLongestReflex - parameter.value);
      add_at_least(Test::kAtBound, from_end, std::max(kLeastFromEnd, parameter.error));
    }
  }

  /// Mass is symmetric (kinetic energy is a square): where it is not, the force is not that of these axes.
  void judge_symmetry() {
    const double difference = estimate_.M(0, 1) - estimate_.M(1, 0);
    const Eigen::MatrixXd& C = estimate_.covariance;
    const double variance = C(1, 1) + C(2, 2) - 2.0 * C(1, 2);
    const double share = std::abs(difference) / std::max(estimate_.M.cwiseAbs().maxCoeff(), kTiny);
    const double how_far = over(difference / std::sqrt(std::max(variance, 1e-300)), 0.5 * share, 1.0);
    add_at_most(Test::kSymmetry, share, share / how_far);
  }

  /// A term fails where it is significant and changes the result: the share at which both begin is the limit.
  void judge_terms(Test test, std::initializer_list<Term> terms, double comparisons) {
    Furthest worst(1.0);
    for (const TermFit& term : estimate_.terms) {
      if (std::ranges::find(terms, term.term) == terms.end()) continue;
      const double how_far = over(term.t, term.change, comparisons);
      worst.take(term.share, term.share / how_far, how_far);
    }
    add_at_most(test, worst);
  }

  void judge_position() {
    const double strict = t_at(kLevelStrict, N * N);
    Furthest worst(kMostPositionChange);
    for (const TermFit& term : estimate_.terms) {
      if (term.term != Term::kPosition) continue;
      const double allowed =
          std::max(kMostPositionChange, term.stiffness_change * strict / std::max(std::abs(term.t), kTiny));
      worst.take(term.stiffness_change, allowed, term.stiffness_change / allowed);
    }
    add_at_most(Test::kPosition, worst);
  }

  void judge_samples() {
    double clipped = 0.0;
    double held = 0.0;
    for (const Record& record : judged_.raw) {
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
    const double value = std::sqrt(judged_.fit.variation);
    const double limit = std::sqrt(kMostVariation);
    add_at_most(Test::kSteadiness, value, width() > kVariationMatters ? limit : std::max(value, limit));
  }

  const Judged<N>& judged_;
  Estimate& estimate_;
};

}  // namespace

template <int N>
void judge(const Judged<N>& judged, Estimate& estimate) {
  Judge<N>(judged, estimate).judge();
}

template void judge<1>(const Judged<1>&, Estimate&);
template void judge<2>(const Judged<2>&, Estimate&);

}  // namespace tonus::spectral
