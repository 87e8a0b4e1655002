#include "analysis_service/impedance/constrained.hpp"

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include "analysis_service/impedance/fit_signals.hpp"
#include "analysis_service/impedance/link_masses.hpp"
#include "tests/support/impedance/linear_rig.hpp"
#include "tests/unit/analysis_service/impedance/reference_vectors.hpp"

namespace tonus::impedance::test {
namespace {

TEST(Constrained, GivesTheUnconstrainedDampingForTheUnconstrainedMassAndStiffness) {
  const Estimate e =
      identify(simulate(typical_subject(), SimulatedRig{}, directions(), 1), Options{}).value();
  const ConstrainedDamping c = constrain(e, e.value.M, e.value.K).value();
  EXPECT_LT(difference(c.B, e.value.B), 1e-9);
  EXPECT_LT(difference(c.X0, e.value.X0), 1e-6);
  EXPECT_LT(difference(c.sigma, e.sigma), 1e-9);
  EXPECT_LT(c.change, 1e-9);
}

TEST(Constrained, EqualsTheBatchFitOfWhatTheHeldTermsLeave) {
  const auto trials = reference_trials();
  Options options;
  options.window = 0.5;
  options.natural_frequency = 2.3;
  const Estimate e = identify(trials, options).value();
  Eigen::Matrix2d M;
  M << 1.5, -0.7, -0.7, 1.2;
  Eigen::Matrix2d K;
  K << 170.0, -90.0, -90.0, 330.0;
  Eigen::MatrixXd phi(400, 3);
  Eigen::MatrixXd rest(400, 2);
  for (Eigen::Index i = 0; i < 4; ++i) {
    const FitSignals s = fit_signals(trials[static_cast<std::size_t>(i)], options, 2.3);
    phi.middleRows(100 * i, 100) << s.velocity_terms.middleRows(20, 100), Eigen::VectorXd::Ones(100);
    rest.middleRows(100 * i, 100) =
        (s.force - s.acceleration * M.transpose() - s.displacement * K.transpose()).middleRows(20, 100);
  }
  const Eigen::MatrixXd theta = phi.colPivHouseholderQr().solve(rest);
  const ConstrainedDamping c = constrain(e, M, K).value();
  EXPECT_LT(difference(c.B, theta.topRows(2).transpose()), 1e-9);
  const Eigen::VectorXd sigma =
      ((rest - phi * theta).colwise().squaredNorm() / 400.0).cwiseSqrt().transpose();
  EXPECT_LT(difference(c.sigma, sigma), 1e-9);
  EXPECT_NEAR(c.change, (c.B - e.value.B).cwiseAbs().maxCoeff() / e.value.B.cwiseAbs().maxCoeff(), 1e-12);
}

TEST(Constrained, ChangesDampingByLessThanFivePercentForMassesOfTheLinks) {
  // Published: under 5 % of the largest element, mass from the link masses, stiffness unconstrained.
  std::vector<PostureMass> postures;
  std::vector<Estimate> estimates;
  for (const auto& position : published_positions()) {
    estimates.push_back(
        identify(simulate(typical_subject(position), SimulatedRig{}, directions(), 1), Options{}).value());
    postures.push_back({position, Eigen::Matrix2d(estimates.back().value.M), postures.size() != 2});
  }
  const LinkMasses masses = fit_link_masses(postures, {0.30, 0.35, 0.045, 0.035}).value();
  EXPECT_NEAR(masses.mass[0], 1.8, 0.1);
  EXPECT_NEAR(masses.mass[1], 1.5, 0.05);
  for (std::size_t i = 0; i < estimates.size(); ++i) {
    EXPECT_LT(constrain(estimates[i], masses.modelled[i], estimates[i].value.K)->change, 0.05)
        << "position " << i;
  }
}

TEST(Constrained, RefusesAnEstimateWithoutNumbersOrOfAnotherModel) {
  EXPECT_FALSE(constrain(Estimate{}, Eigen::Matrix2d::Identity(), Eigen::Matrix2d::Identity()));
  Options options;
  options.model = Model::kNoDamping;
  const Estimate e = identify(simulate(typical_subject(), SimulatedRig{}, directions(), 1), options).value();
  EXPECT_EQ(constrain(e, e.value.M, e.value.K).error().message,
            "constrained fit: estimate: suspect of model no_damping is not allowed; expected a determined "
            "one of model "
            "linear");
}

}  // namespace
}  // namespace tonus::impedance::test
