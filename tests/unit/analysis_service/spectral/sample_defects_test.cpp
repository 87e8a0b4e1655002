#include "analysis_service/spectral/sample_defects.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>

namespace tonus::spectral {
namespace {

Eigen::VectorXd motion(Eigen::Index rows) {
  Eigen::VectorXd signal(rows);
  for (Eigen::Index i = 0; i < rows; ++i) {
    const auto t = static_cast<double>(i);
    signal[i] = std::sin(0.013 * t) + 0.4 * std::sin(0.0371 * t + 1.0) + 0.2 * std::sin(0.0917 * t + 2.0);
  }
  return signal;
}

TEST(SampleDefects, SoundSignalHasNone) {
  const SampleDefects defects = sample_defects_of(motion(5000));
  EXPECT_EQ(defects.held_for, 1);
  EXPECT_EQ(defects.clipped_share, 0.0);
}

TEST(SampleDefects, HeldSamplesAreCounted) {
  const Eigen::VectorXd smooth = motion(5000);
  Eigen::VectorXd held = smooth;
  for (Eigen::Index i = 0; i < held.size(); ++i) held[i] = smooth[i / 10 * 10];
  const SampleDefects defects = sample_defects_of(held);
  EXPECT_EQ(defects.held_for, 10);
  EXPECT_DOUBLE_EQ(defects.held_share, 0.9);
}

TEST(SampleDefects, SamplesJoinedByStraightLinesAreCountedAsHeld) {
  const Eigen::VectorXd smooth = motion(5011);
  Eigen::VectorXd joined = smooth;
  for (Eigen::Index i = 0; i + 10 < joined.size(); ++i) {
    const Eigen::Index from = i / 10 * 10;
    joined[i] = smooth[from] + static_cast<double>(i - from) / 10.0 * (smooth[from + 10] - smooth[from]);
  }
  EXPECT_EQ(sample_defects_of(joined.head(5000)).held_for, 10);
}

TEST(SampleDefects, SteadyStepsOfAnEncoderAreNeitherHeldNorClipped) {
  Eigen::VectorXd signal = motion(5000);
  for (double& value : signal) value = 0.05 * std::round(value / 0.05);
  const SampleDefects defects = sample_defects_of(signal);
  EXPECT_EQ(defects.held_for, 1);
  EXPECT_EQ(defects.clipped_share, 0.0);
}

TEST(SampleDefects, ClippedShareIsThatOfTheSamplesAtTheEnd) {
  Eigen::VectorXd signal = motion(5000);
  Eigen::Index beyond = 0;
  for (double& value : signal) {
    beyond += value > 1.0 ? 1 : 0;
    value = std::min(value, 1.0);
  }
  ASSERT_GT(beyond, 100);
  EXPECT_DOUBLE_EQ(sample_defects_of(signal).clipped_share, static_cast<double>(beyond) / 5000.0);
}

}  // namespace
}  // namespace tonus::spectral
