#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "analysis_service/impedance/trial.hpp"

namespace tonus::impedance::test {

/// A block of reference/<file>, written by the script beside it. Fails the test and is empty where it is
/// absent.
[[nodiscard]] Eigen::MatrixXd reference(const std::string& file, const std::string& name);

/// The four trials of reference/record.txt, prepared: 20 samples of rest and 100 of motion at 200 Hz.
[[nodiscard]] std::vector<Trial> reference_trials();

/// Largest difference over the largest magnitude of `expected`.
[[nodiscard]] double difference(const Eigen::MatrixXd& actual, const Eigen::MatrixXd& expected);

}  // namespace tonus::impedance::test
