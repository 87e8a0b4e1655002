#include "services/simulation/true_impedance.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <numbers>

namespace tonus::simulation {
namespace {

TEST(TrueImpedance, AgreesWithARightAngleWorkedOutByHand) {
  // t1 = 0, t2 = 90 deg, l1 = l2 = 0.3 m: the hand at (0.3, 0.3), J = [[-0.3, -0.3], [0.3, 0]], so
  // J^-1 = [[0, 1], [-1, -1]] / 0.3, and for R = [[a, b], [b, c]]: J^-T R J^-1 = [[c, c - b], [c - b, a - 2b
  // + c]] / 0.09.
  SubjectProfile subject;
  subject.links = {0.3, 0.3};
  subject.stiffness = {20.0, 15.0, 6.0};  // a = 26, b = 6, c = 21.
  subject.link_masses = {2.0, 1.5};
  subject.link_radii = {0.0, 0.0};  // a = 0.06 + 0.135 + 0.045 = 0.24, b = c = 0.045: no coupling at 90 deg.
  const CartesianImpedance z = true_impedance(subject, {0.3, 0.3});
  EXPECT_NEAR(z.stiffness(0, 0), 21.0 / 0.09, 1e-9);
  EXPECT_NEAR(z.stiffness(0, 1), 15.0 / 0.09, 1e-9);
  EXPECT_NEAR(z.stiffness(1, 0), 15.0 / 0.09, 1e-9);
  EXPECT_NEAR(z.stiffness(1, 1), 35.0 / 0.09, 1e-9);
  EXPECT_NEAR(z.mass(0, 0), 0.5, 1e-9);  // m2 / 3: the forearm turning about the elbow.
  EXPECT_NEAR(z.mass(0, 1), 0.0, 1e-9);
  EXPECT_NEAR(z.mass(1, 1), 2.0 / 3.0 + 1.5,
              1e-9);  // m1 / 3 + m2: the upper arm turns, the forearm moves along.
  EXPECT_EQ(z.spring_centre, Eigen::Vector2d::Zero());
}

TEST(TrueImpedance, CountsTheRadiiOfTheCylinders) {
  SubjectProfile thin;
  thin.link_radii = {0.0, 0.0};
  const SubjectProfile thick;
  const control::TwoLinkInertia difference{
      cylinder_inertia(thick).inner - cylinder_inertia(thin).inner,
      cylinder_inertia(thick).outer - cylinder_inertia(thin).outer,
      cylinder_inertia(thick).coupling - cylinder_inertia(thin).coupling};
  EXPECT_NEAR(difference.inner, 2.0 * 0.045 * 0.045 / 4.0, 1e-12);
  EXPECT_NEAR(difference.outer, 1.5 * 0.036 * 0.036 / 4.0, 1e-12);
  EXPECT_EQ(difference.coupling, 0.0);
}

}  // namespace
}  // namespace tonus::simulation
