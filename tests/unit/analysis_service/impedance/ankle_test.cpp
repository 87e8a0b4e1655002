#include <cstdlib>
#include <fstream>
#include <gtest/gtest.h>
#include <sstream>
#include <string>

#include "analysis_service/impedance/identification.hpp"
#include "analysis_service/impedance/verdict.hpp"

namespace tonus::impedance::test {
namespace {

/// One of the measured records of a human ankle (see the data set's README): angle (rad), torque of the ankle
/// on the servo (N m), 1000 Hz. Empty where TONUS_DATA_DIR does not hold it.
std::vector<EndpointSample> ankle_record(int run) {
  const char* folder = std::getenv("TONUS_DATA_DIR");
  if (folder == nullptr) return {};
  std::ifstream in(std::string(folder) + "/ankle/sub-01/motion/sub-01_task-ankle_tracksys-perturbator_run-0" +
                   std::to_string(run) + "_motion.tsv");
  std::vector<EndpointSample> samples;
  EndpointSample sample;
  while (in >> sample.p_SE[0] >> sample.f_S[0]) {
    sample.f_S[0] = -sample.f_S[0];
    samples.push_back(sample);
  }
  return samples;
}

TEST(MeasuredAnkle, HasTheImpedanceThatTheDataSetStates) {
  // Stated there for state-variable filters at 30 Hz and 0.1, whole records, runs 1 to 5.
  const double I[] = {0.0175, 0.0171, 0.0148, 0.0149, 0.0170};
  const double K[] = {105.0, 105.0, 60.0, 161.0, 182.0};
  // Of runs 2 and 5 the model explains less than 80 % of the torque (72.7 and 73.0 %).
  const bool is_explained[] = {true, false, true, true, false};
  for (int run = 1; run <= 5; ++run) {
    const auto samples = ankle_record(run);
    if (samples.empty()) GTEST_SKIP() << "TONUS_DATA_DIR holds no ankle/ data set";
    Preparation preparation;
    preparation.axes = 1;
    preparation.sample_period = 0.001;
    const Trial record = prepare_record(1, samples, preparation).value();
    Options options;
    options.record_method = Method::kStateVariable;
    options.natural_frequency = 30.0;
    const Estimate e = identify({&record, 1}, options).value();
    // The delayed reflex makes (3) miss the response of every run.
    EXPECT_EQ(e.status, Status::kSuspect) << "run " << run;
    EXPECT_TRUE(e.details.contains(Reason::kMisfit)) << "run " << run;
    EXPECT_EQ(e.explained.minCoeff() >= kLeastExplained, is_explained[run - 1]) << "run " << run;
    EXPECT_NEAR(e.value.M(0, 0), I[run - 1], 0.0003) << "run " << run;
    EXPECT_NEAR(e.value.K(0, 0), K[run - 1], 2.0) << "run " << run;
    EXPECT_GT(e.value.B(0, 0), 0.0);
    EXPECT_GT(e.units, 25U);
    EXPECT_LT(e.std.K(0, 0), 0.2 * e.value.K(0, 0));
  }
}

}  // namespace
}  // namespace tonus::impedance::test
