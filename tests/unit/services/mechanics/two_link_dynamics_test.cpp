#include "services/mechanics/two_link_dynamics.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <limits>

namespace tonus::control {
namespace {

constexpr double kRounding = 16.0 * std::numeric_limits<double>::epsilon();

double largest_difference(const TwoLinkState& a, const TwoLinkState& b) {
  return std::max({(a.point - b.point).cwiseAbs().maxCoeff(), (a.jacobian - b.jacobian).cwiseAbs().maxCoeff(),
                   std::abs(a.sin_q2 - b.sin_q2), std::abs(a.cos_q2 - b.cos_q2),
                   std::abs(a.sin_q12 - b.sin_q12), std::abs(a.cos_q12 - b.cos_q12)});
}

// The sines of the C library at the same angles are the independent program.
TEST(TwoLinkState, MovedByAStepIsWithinRoundingOfTheOneEvaluatedThere) {
  const TwoLink links{0.30, 0.35};
  for (double q1 = -3.0; q1 <= 3.0; q1 += 0.37) {
    for (double q2 = -3.0; q2 <= 3.0; q2 += 0.41) {
      const Eigen::Vector2d q(q1, q2);
      const TwoLinkState here(links, q);
      for (const double d : {0.0, 1e-7, -3e-4, 0.004, -0.005, 0.02, 1.0}) {
        const Eigen::Vector2d step(d, -0.3 * d);
        EXPECT_LE(largest_difference(here.moved_by(links, q, step), TwoLinkState(links, q + step)), kRounding)
            << q1 << ' ' << q2 << ' ' << d;
      }
    }
  }
}

TEST(TwoLinkState, MovedByWhatIsNoNumberIsNone) {
  const TwoLink links{0.30, 0.35};
  const Eigen::Vector2d q(0.5, 1.0);
  const TwoLinkState lost = TwoLinkState(links, q).moved_by(links, q, {std::nan(""), 0.0});
  EXPECT_TRUE(std::isnan(lost.point.x()));
}

}  // namespace
}  // namespace tonus::control
