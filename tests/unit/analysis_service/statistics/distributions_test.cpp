#include "analysis_service/statistics/distributions.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <numbers>

namespace tonus::statistics {
namespace {

struct Quantiles {
  double freedom;
  double at_975;
  double at_95;
};

// scipy.stats.t.ppf(0.975, d) and t.ppf(0.95, d).
constexpr Quantiles kScipys[] = {
    {1.0, 12.706204736432095, 6.3137515148009324}, {2.0, 4.3026527299112747, 2.9199855803561555},
    {3.5, 2.9400886379827775, 2.2224334936496004}, {7.0, 2.3646242510102993, 1.8945786050613049},
    {15.0, 2.131449545559323, 1.7530503556925547}, {100.0, 1.9839715184496334, 1.6602343260657499}};

TEST(StudentT, EqualsScipysQuantiles) {
  for (const auto& expected : kScipys) {
    EXPECT_NEAR(student_t_factor(0.95, expected.freedom) / expected.at_975, 1.0, 1e-9);
    EXPECT_NEAR(student_t_factor(0.90, expected.freedom) / expected.at_95, 1.0, 1e-9);
    EXPECT_NEAR(student_t_quantile(0.975, expected.freedom) / expected.at_975, 1.0, 1e-9);
  }
}

TEST(StudentT, IsCauchyWithOneDegreeOfFreedom) {
  EXPECT_NEAR(student_t_factor(0.5, 1.0), 1.0, 1e-14);
  EXPECT_NEAR(student_t_factor(2.0 / std::numbers::pi * std::atan(3.0), 1.0), 3.0, 1e-13);
}

TEST(FisherF, WithOneDegreeAboveIsTheSquareOfStudentsT) {
  for (const auto& expected : kScipys) {
    const double ratio = expected.at_975 * expected.at_975;
    EXPECT_NEAR(fisher_tail(ratio, 1.0, expected.freedom), 0.05, 1e-9);
    EXPECT_NEAR(fisher_quantile(0.95, 1.0, expected.freedom) / ratio, 1.0, 1e-9);
  }
}

TEST(ChiSquared, IsExponentialWithTwoDegreesOfFreedom) {
  EXPECT_NEAR(chi_squared_tail(3.0, 2.0), std::exp(-1.5), 1e-15);
  EXPECT_EQ(chi_squared_tail(0.0, 2.0), 1.0);
}

}  // namespace
}  // namespace tonus::statistics
