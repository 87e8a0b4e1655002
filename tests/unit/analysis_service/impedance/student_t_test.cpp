#include "analysis_service/impedance/student_t.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <numbers>

#include "tests/unit/analysis_service/impedance/reference_vectors.hpp"

namespace tonus::impedance::test {
namespace {

TEST(StudentT, EqualsScipysQuantiles) {
  const Eigen::MatrixXd expected = reference("scipy.txt", "student_t");  // Degrees of freedom, 97.5 %, 95 %.
  for (Eigen::Index i = 0; i < expected.rows(); ++i) {
    EXPECT_NEAR(student_t_factor(0.95, expected(i, 0)) / expected(i, 1), 1.0, 1e-9);
    EXPECT_NEAR(student_t_factor(0.90, expected(i, 0)) / expected(i, 2), 1.0, 1e-9);
  }
}

TEST(StudentT, IsCauchyWithOneDegreeOfFreedom) {
  EXPECT_NEAR(student_t_within(1.0, 1.0), 0.5, 1e-14);
  EXPECT_NEAR(student_t_within(3.0, 1.0), 2.0 / std::numbers::pi * std::atan(3.0), 1e-14);
}

}  // namespace
}  // namespace tonus::impedance::test
