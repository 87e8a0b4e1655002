#include <cmath>
#include <gtest/gtest.h>

#include "analysis_service/impedance/identification.hpp"
#include "analysis_service/impedance/parameters.hpp"
#include "tests/support/impedance/linear_rig.hpp"

namespace tonus::impedance::test {
namespace {

struct Coverage {
  double share = 0.0;             ///< Of all intervals of M, B, K that contain the truth.
  Eigen::VectorXd ratio_of_stds;  ///< Mean stated standard deviation over the one observed.
  Eigen::VectorXd
      naive_over_stated;  ///< Standard deviation that counts samples as independent over the stated one.
};

Coverage coverage(const SimulatedArm& arm, const SimulatedRig& rig, int conditions) {
  const Eigen::VectorXd truth = flatten({arm.impedance.M, arm.impedance.B, arm.impedance.K, arm.X0});
  Options options;
  options.has_trace = false;
  double inside = 0.0;
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(14);
  Eigen::VectorXd squares = sum;
  Eigen::VectorXd stated = sum;
  Eigen::VectorXd naive = sum;
  for (int seed = 1; seed <= conditions; ++seed) {
    const Estimate e =
        identify(simulate(arm, rig, directions(), static_cast<std::uint64_t>(seed)), options).value();
    const Eigen::VectorXd low = flatten(e.low);
    const Eigen::VectorXd high = flatten(e.high);
    for (Eigen::Index i = 0; i < 12; ++i) inside += low[i] <= truth[i] && truth[i] <= high[i] ? 1.0 : 0.0;
    const Eigen::VectorXd error = flatten(e.value) - truth;
    sum += error;
    squares += error.cwiseAbs2();
    stated += flatten(e.std);
    const Eigen::MatrixXd inverse =
        e.information.R.triangularView<Eigen::Upper>().solve(Eigen::MatrixXd::Identity(7, 7));
    const Eigen::VectorXd spread = inverse.rowwise().norm();
    for (int i = 0; i < 3; ++i) {
      for (int column = 0; column < 2; ++column) {
        for (int row = 0; row < 2; ++row)
          naive[4 * i + 2 * column + row] += spread[2 * i + column] * e.sigma[row];
      }
    }
  }
  const double n = conditions;
  const Eigen::VectorXd observed = (squares / n - (sum / n).cwiseAbs2()).cwiseSqrt();
  return {inside / (12.0 * n), (stated / n).cwiseQuotient(observed), naive.cwiseQuotient(stated).head(12)};
}

TEST(Intervals, ContainTheTruthNineteenTimesInTwentyOnSensorNoise) {
  SimulatedRig rig;
  rig.encoder_counts = 0.0;  // No bias of the method: what remains is what the intervals are about.
  rig.force_resolution = 0.0;
  const Coverage found = coverage(typical_subject(), rig, 150);
  EXPECT_GT(found.share, 0.93);
  EXPECT_LT(found.share, 0.975);
  EXPECT_GT(found.ratio_of_stds.minCoeff(), 0.85);
  EXPECT_LT(found.ratio_of_stds.maxCoeff(), 1.25);
}

TEST(Intervals, ContainTheTruthWithThePublishedEncoders) {
  const Coverage found = coverage(typical_subject(), SimulatedRig{}, 100);
  EXPECT_GT(found.share, 0.92);
  EXPECT_LT(found.share, 0.975);
}

TEST(Intervals, TreatTheTrialAsTheUnitUnderDriftAndTremor) {
  SimulatedArm arm = typical_subject();
  arm.drift_rms = 0.15;
  arm.tremor_rms = 0.05;
  const Coverage found = coverage(arm, SimulatedRig{}, 30);
  EXPECT_GT(found.share, 0.90);
  EXPECT_LT(found.share, 0.985);
  // Samples counted as independent would claim intervals of stiffness several times too narrow.
  EXPECT_LT(found.naive_over_stated.tail(4).maxCoeff(), 1.0 / 3.0);
}

TEST(Intervals, HoldTheOneBySymmetricStudentsFactorAndMoreWhereATermIsInDoubt) {
  const Estimate e =
      identify(simulate(typical_subject(), SimulatedRig{}, directions(), 1), Options{}).value();
  // scipy.stats.t.ppf(0.975, 15) = 2.131449545559323
  const Eigen::VectorXd half = 2.131449545559323 * flatten(e.std);
  const Eigen::VectorXd above = flatten(e.high) - flatten(e.value) - half;
  const Eigen::VectorXd below = flatten(e.value) - flatten(e.low) - half;
  EXPECT_GT(above.minCoeff(), -1e-9 * half.maxCoeff());
  EXPECT_GT(below.minCoeff(), -1e-9 * half.maxCoeff());
  // A change widens to one side; nothing widens the interval of X0.
  EXPECT_LT(above.tail(2).cwiseAbs().maxCoeff(), 1e-9);
  EXPECT_LT(below.tail(2).cwiseAbs().maxCoeff(), 1e-9);
}

TEST(Intervals, AgreeWithTheCovariance) {
  const Estimate e =
      identify(simulate(typical_subject(), SimulatedRig{}, directions(), 1), Options{}).value();
  ASSERT_EQ(e.covariance.rows(), 14);
  // vec(Theta): column = force axis, rows x"1 x"2 x'1 x'2 x1 x2 1. K(1,0) is row 4 of column 1.
  EXPECT_NEAR(std::sqrt(e.covariance(7 + 4, 7 + 4)), e.std.K(1, 0), 1e-9 * e.std.K(1, 0));
  EXPECT_NEAR(std::sqrt(e.covariance(1, 1)), e.std.M(0, 1), 1e-9 * e.std.M(0, 1));
}

TEST(Intervals, CutALongRecordIntoBlocks) {
  // A stochastic record made of the trials' motions one after another, force exact but for noise.
  const auto trials = simulate(typical_subject(), SimulatedRig{}, directions(3), 1);
  Trial record = trials[0];
  const Eigen::Index rows = trials[0].samples();
  record.is_continuous = true;
  record.onset = 0;
  record.displacement.resize(24 * rows, 2);
  record.force.resize(24 * rows, 2);
  for (Eigen::Index i = 0; i < 24; ++i) {
    record.displacement.middleRows(i * rows, rows) = trials[static_cast<std::size_t>(i)].displacement;
    record.force.middleRows(i * rows, rows) = trials[static_cast<std::size_t>(i)].force;
  }
  Options options;
  options.record_method = Method::kStateVariable;
  options.natural_frequency = 2.6;
  const Estimate e = identify({&record, 1}, options).value();
  EXPECT_NE(e.status, Status::kUndetermined);
  EXPECT_GT(e.units, 10U);
  EXPECT_GT(e.std.K(0, 0), 0.0);
  EXPECT_TRUE(e.trace.empty());
}

}  // namespace
}  // namespace tonus::impedance::test
