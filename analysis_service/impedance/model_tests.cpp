#include "analysis_service/impedance/model_tests.hpp"

#include <algorithm>
#include <cmath>
#include <spdlog/fmt/fmt.h>

#include "analysis_service/impedance/force_lag.hpp"
#include "analysis_service/impedance/method_bias.hpp"
#include "analysis_service/impedance/parameters.hpp"
#include "analysis_service/impedance/verdict.hpp"

namespace tonus::impedance {
namespace {

constexpr double kLargestEffect = 1.0;  // Of a term, in 95 % half-widths of what it changes.
// Of the largest element. By less a term is carried by the intervals (carry_doubts) and refuses nothing: in
// data without noise what the discretisation leaves, up to 1 %, is significant.
constexpr double kLeastShare = 0.02;
constexpr double kLargestMisfit = 0.2;  // Of the mean response's force, as what is explained at least.
constexpr double kLargestLag = 0.010;   // s; a smaller one matters where it moves an element.

struct Finding {
  FitTest test = FitTest::kBands;
  Reason reason = Reason::kMisfit;
  const char* what = "";
};

Finding finding_of(refined::Alternative alternative) {
  switch (alternative) {
    case refined::Alternative::kReflex:
      return {FitTest::kReflex, Reason::kReflex, "a force that follows the velocity of 40 ms ago"};
    case refined::Alternative::kHardening:
      return {FitTest::kHardening, Reason::kHardening, "a force that follows the cube of the displacement"};
    case refined::Alternative::kSlack:
      return {FitTest::kPosition, Reason::kSlack, "a force that follows the direction of the displacement"};
    case refined::Alternative::kFriction:
      break;
  }
  return {FitTest::kFriction, Reason::kFriction, "a force that follows the direction of the velocity"};
}

void check_misfit(const refined::Estimate& found, Estimate& estimate) {
  const bool is_misfit = found.misfit.p < kModelSignificance && found.misfit.share > kLargestMisfit;
  add_check(FitTest::kBands, found.misfit.share, kLargestMisfit, !is_misfit, Reason::kMisfit,
            fmt::format("the model leaves {:.3g} % of the force's mean response, at most {:.3g} %",
                        100.0 * found.misfit.share, 100.0 * kLargestMisfit),
            estimate);
}

void check_terms(const refined::Estimate& found, Estimate& estimate) {
  for (const refined::AlternativeTest& test : found.alternatives) {
    const Finding finding = finding_of(test.alternative);
    const bool is_found =
        test.p < kModelSignificance && test.effect > kLargestEffect && test.share > kLeastShare;
    // Without significance the effect is that of noise; the check states it at its limit then.
    const double value = is_found ? test.effect : std::min(test.effect, kLargestEffect);
    add_check(
        finding.test, value, kLargestEffect, !is_found, finding.reason,
        fmt::format("{} is significant and changes an element by {:.2f} of its 95 % half-width, at most "
                    "{:.2f}, and by {:.2g} % of its matrix",
                    finding.what, test.effect, kLargestEffect, 100.0 * test.share),
        estimate);
  }
}

/// The force is late where the lag is more than half a sample, which is what encoder and sensor of a sound
/// rig may be apart, beyond its interval, and moves an element or is large. (10) is linear in the lag: one
/// that a scan found beyond what is tolerated there is stated as scanned. True where that is so: every other
/// test is of that lag then.
bool check_lag(const refined::LagTest& test, Estimate& estimate) {
  Eigen::Index axis = 0;
  double lag = test.lag.cwiseAbs().maxCoeff(&axis);
  const bool is_large = lag > kLargestLag || (test.effect > kLargestEffect && test.share > kLeastShare);
  const bool is_beyond_a_sample = lag - 1.96 * test.std[axis] > 0.5 * test.sample_period;
  const bool is_late = test.p < kModelSignificance && is_large && is_beyond_a_sample;
  const bool is_scanned =
      estimate.force_lag.size() > 0 && estimate.force_lag.cwiseAbs().maxCoeff() > kLagTolerated;
  if (is_late && is_scanned) {
    lag = estimate.force_lag.cwiseAbs().maxCoeff(&axis);
  } else {
    estimate.force_lag = test.lag;
  }
  const double half = 1.96 * test.std[axis];
  add_check(FitTest::kLag, lag, is_late ? std::min(kLargestLag, half) : std::max(kLargestLag, lag), !is_late,
            Reason::kForceShifted,
            fmt::format("the force is {:.2f} ms {} than the displacement, give or take {:.2f} ms", 1e3 * lag,
                        estimate.force_lag[axis] > 0.0 ? "later" : "earlier", 1e3 * half),
            estimate);
  return is_late && is_scanned;
}

}  // namespace

void check_against_model(const refined::Estimate& found, Estimate& estimate) {
  if (check_lag(found.lag, estimate)) return;
  check_misfit(found, estimate);
  check_terms(found, estimate);
}

void check_against_mean_motion(const refined::Estimate& found, Estimate& estimate) {
  if (!check_lag(found.lag, estimate)) check_terms(found, estimate);
}

void carry_doubts(const refined::Estimate& found, Estimate& estimate) {
  const auto axes = static_cast<int>(found.theta.cols());
  for (const refined::AlternativeTest& test : found.alternatives) {
    if (test.change.size() == 0 || !(test.p < kDoubtfulBelow)) continue;
    widen(parameters_from(test.change, axes), estimate);
  }
}

}  // namespace tonus::impedance
