#include "analysis_service/impedance/state_variable_filter.hpp"

#include <numbers>
#include <unsupported/Eigen/MatrixFunctions>

namespace tonus::impedance {

StateVariableStep StateVariableStep::make(double natural_frequency, double damping_ratio,
                                          double sample_period) {
  const double wn = 2.0 * std::numbers::pi * natural_frequency;
  StateVariableStep step;
  step.stiffness = wn * wn;
  step.damping = 2.0 * damping_ratio * wn;

  // d/dt (s, u, h u') = [A B 0; 0 0 1/h; 0 0 0] (s, u, h u'), its exponential over one period h.
  Eigen::Matrix4d generator = Eigen::Matrix4d::Zero();
  generator(0, 1) = sample_period;
  generator(1, 0) = -step.stiffness * sample_period;
  generator(1, 1) = -step.damping * sample_period;
  generator(1, 2) = step.stiffness * sample_period;
  generator(2, 3) = 1.0;
  const Eigen::Matrix4d transition = generator.exp();

  step.Phi = transition.topLeftCorner<2, 2>();
  step.G1 = transition.block<2, 1>(0, 3);
  step.G0 = transition.block<2, 1>(0, 2) - step.G1;
  return step;
}

}  // namespace tonus::impedance
