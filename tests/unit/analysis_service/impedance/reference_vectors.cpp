#include "tests/unit/analysis_service/impedance/reference_vectors.hpp"

#include <fstream>
#include <gtest/gtest.h>

namespace tonus::impedance::test {

Eigen::MatrixXd reference(const std::string& file, const std::string& name) {
  std::ifstream in(std::string(TONUS_REFERENCE_DIR) + "/" + file);
  std::string block;
  Eigen::Index rows = 0;
  Eigen::Index columns = 0;
  while (in >> block >> rows >> columns) {
    Eigen::MatrixXd values(rows, columns);
    for (Eigen::Index i = 0; i < rows; ++i) {
      for (Eigen::Index j = 0; j < columns; ++j) in >> values(i, j);
    }
    if (block == name && in) return values;
  }
  ADD_FAILURE() << "no block " << name << " in " << file;
  return {};
}

std::vector<Trial> reference_trials() {
  std::ifstream in(std::string(TONUS_REFERENCE_DIR) + "/record.txt");
  std::vector<std::vector<EndpointSample>> samples;
  std::size_t trial = 0;
  EndpointSample sample;
  while (in >> trial >> sample.p_SE.x() >> sample.p_SE.y() >> sample.f_S.x() >> sample.f_S.y()) {
    samples.resize(trial);
    samples.back().push_back(sample);
  }
  Preparation preparation;
  preparation.sample_period = 0.005;
  std::vector<Trial> trials;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    trials.push_back(prepare_trial(static_cast<std::uint32_t>(i + 1), samples[i], 20, preparation).value());
  }
  EXPECT_EQ(trials.size(), 4U);
  return trials;
}

double difference(const Eigen::MatrixXd& actual, const Eigen::MatrixXd& expected) {
  if (actual.rows() != expected.rows() || actual.cols() != expected.cols() || expected.size() == 0)
    return 1e300;
  return (actual - expected).cwiseAbs().maxCoeff() / expected.cwiseAbs().maxCoeff();
}

}  // namespace tonus::impedance::test
