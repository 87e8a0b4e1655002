#include "analysis_service/study/loaded_postures.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <numbers>

namespace tonus::study {
namespace {

v1::MatrixEstimate matrix(double xx, double xy, double yx, double yy) {
  v1::MatrixEstimate m;
  m.value({xx, xy, yx, yy});
  return m;
}

v1::Estimate set_of(std::int32_t number, std::array<double, 2> bias, const v1::MatrixEstimate& stiffness) {
  v1::Estimate e;
  e.posture("reference");
  e.posture_index(1);
  e.set_number(number);
  e.bias_N(bias);
  e.axes(2);
  e.method("state_variable");
  e.model("linear");
  e.stiffness_N_per_m(stiffness);
  e.damping_Ns_per_m(matrix(10.0, 0.0, 0.0, 20.0));
  return e;
}

/// First and last set unloaded with K = diag(100, 400) and diag(100, 600) N/m, so diag(100, 500) together.
std::vector<v1::Estimate> session() {
  auto loaded = set_of(2, {1.0, -0.5}, matrix(200.0, 0.0, 0.0, 1000.0));
  v1::VectorEstimate centre;
  centre.value({-0.010, 0.002});
  loaded.spring_centre_m(centre);
  return {loaded, set_of(3, {0.0, 0.0}, matrix(100.0, 0.0, 0.0, 600.0)),
          set_of(1, {0.0, 0.0}, matrix(100.0, 0.0, 0.0, 400.0))};
}

TEST(LoadedPostures, PredictTheSpringCentreFromTheMeanOfTheFirstAndTheLastSet) {
  const auto postures = loaded_postures(session());
  ASSERT_EQ(postures.size(), 1U);
  ASSERT_EQ(postures[0].sets.size(), 1U);
  const LoadedSet& set = postures[0].sets[0];
  EXPECT_EQ(set.set_number, 2);
  // (20) for a force on the arm: -K^-1 (1.0, -0.5) N with K = diag(100, 500) N/m.
  EXPECT_NEAR(set.predicted.x(), -0.010, 1e-12);
  EXPECT_NEAR(set.predicted.y(), 0.001, 1e-12);
  EXPECT_NEAR(set.comparison.magnitude_ratio, std::hypot(10.0, 2.0) / std::hypot(10.0, 1.0), 1e-12);
  EXPECT_NEAR(set.comparison.turn, std::atan2(2.0, -10.0) - std::atan2(1.0, -10.0), 1e-12);
}

TEST(LoadedPostures, CompareStiffnessAndDampingWithTheUnloadedOnes) {
  const LoadedSet set = loaded_postures(session()).at(0).sets.at(0);
  ASSERT_TRUE(set.stiffness && set.damping);
  EXPECT_NEAR(set.stiffness->size_ratio, 4.0, 1e-12);  // both eigenvalues doubled
  EXPECT_NEAR(set.stiffness->shape_ratio, 1.0, 1e-12);
  EXPECT_NEAR(set.stiffness->rotation, 0.0, 1e-12);
  EXPECT_NEAR(set.damping->size_ratio, 1.0, 1e-12);
}

TEST(LoadedPostures, LeaveOutWhatCannotBeCompared) {
  EXPECT_TRUE(loaded_postures({}).empty());
  auto estimates = session();
  estimates.erase(estimates.begin() + 1, estimates.end());  // no unloaded set
  EXPECT_TRUE(loaded_postures(estimates).empty());

  estimates = session();
  estimates[0].status(v1::ESTIMATE_UNDETERMINED);
  EXPECT_TRUE(loaded_postures(estimates).empty());

  estimates = session();
  for (auto& e : estimates) e.model("no_damping");
  EXPECT_TRUE(loaded_postures(estimates).empty());
}

TEST(LoadedPostures, KeepMethodsApart) {
  auto estimates = session();
  for (auto e : session()) {
    e.method("lowpass");
    estimates.push_back(e);
  }
  const auto postures = loaded_postures(estimates);
  ASSERT_EQ(postures.size(), 2U);
  EXPECT_EQ(postures[0].method, "lowpass");
  EXPECT_EQ(postures[1].method, "state_variable");
}

TEST(LoadedPostures, AreWrittenWithUnits) {
  const std::string text = as_text(loaded_postures(session()).at(0));
  EXPECT_NE(text.find("predicted (-10.00, +1.00) mm"), std::string::npos) << text;
  EXPECT_NE(text.find("stiffness: size x 4.00"), std::string::npos) << text;
}

}  // namespace
}  // namespace tonus::study
