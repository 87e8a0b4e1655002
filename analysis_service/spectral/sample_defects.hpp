#pragma once

#include <Eigen/Core>

namespace tonus::spectral {

/// Defects of one channel that its samples show.
struct SampleDefects {
  int held_for = 1;            ///< Samples that each value stands for: more than 1 where it was held or drawn
                               ///< as straight lines between samples of a slower rate.
  double held_share = 0.0;     ///< Of the samples that carry nothing of their own: 1 - 1/held_for.
  double clipped_share = 0.0;  ///< Of the samples at an extreme that is held for three samples or more.
};

/// A channel is held where it changes at every r-th sample only, and interpolated where its slope does. One
/// that stands still because it is quantised changes at no fixed step and is not held.
[[nodiscard]] SampleDefects sample_defects_of(const Eigen::Ref<const Eigen::VectorXd>& signal);

}  // namespace tonus::spectral
