#include "analysis_service/impedance/butterworth.hpp"

#include <cmath>
#include <numbers>

namespace tonus::impedance {
namespace {

/// One run in place, transposed direct form II, from the steady state of a constant at the first sample.
void run(const SecondOrderFilter& f, Eigen::VectorXd& u) {
  const double gain = (f.b[0] + f.b[1] + f.b[2]) / (f.a[0] + f.a[1] + f.a[2]);
  double z1 = (gain - f.b[0]) * u[0];
  double z2 = (f.b[2] - f.a[2] * gain) * u[0];
  for (double& sample : u) {
    const double input = sample;
    sample = f.b[0] * input + z1;
    z1 = f.b[1] * input - f.a[1] * sample + z2;
    z2 = f.b[2] * input - f.a[2] * sample;
  }
}

}  // namespace

SecondOrderFilter butterworth_lowpass(double cutoff, double sample_period) {
  const double c = std::tan(std::numbers::pi * cutoff * sample_period);
  const double norm = 1.0 + std::numbers::sqrt2 * c + c * c;
  const double b0 = c * c / norm;
  return {{b0, 2.0 * b0, b0},
          {1.0, 2.0 * (c * c - 1.0) / norm, (1.0 - std::numbers::sqrt2 * c + c * c) / norm}};
}

Signals zero_phase(const SecondOrderFilter& filter, const Signals& signals) {
  const Eigen::Index rows = signals.rows();
  const Eigen::Index pad = kZeroPhasePadding;
  Signals filtered(rows, signals.cols());
  Eigen::VectorXd extended(rows + 2 * pad);
  for (Eigen::Index axis = 0; axis < signals.cols(); ++axis) {
    const auto u = signals.col(axis);
    for (Eigen::Index k = 0; k < pad; ++k) {
      extended[k] = 2.0 * u[0] - u[pad - k];
      extended[pad + rows + k] = 2.0 * u[rows - 1] - u[rows - 2 - k];
    }
    extended.segment(pad, rows) = u;
    run(filter, extended);
    extended.reverseInPlace();
    run(filter, extended);
    extended.reverseInPlace();
    filtered.col(axis) = extended.segment(pad, rows);
  }
  return filtered;
}

Signals central_difference(const Signals& signals, double sample_period) {
  const Eigen::Index last = signals.rows() - 1;
  Signals rate(signals.rows(), signals.cols());
  rate.row(0) = (signals.row(1) - signals.row(0)) / sample_period;
  rate.row(last) = (signals.row(last) - signals.row(last - 1)) / sample_period;
  rate.middleRows(1, last - 1) =
      (signals.middleRows(2, last - 1) - signals.middleRows(0, last - 1)) / (2.0 * sample_period);
  return rate;
}

Signals second_difference(const Signals& signals, double sample_period) {
  const Eigen::Index last = signals.rows() - 1;
  Signals acceleration(signals.rows(), signals.cols());
  acceleration.middleRows(1, last - 1) =
      (signals.middleRows(2, last - 1) - 2.0 * signals.middleRows(1, last - 1) +
       signals.middleRows(0, last - 1)) /
      (sample_period * sample_period);
  acceleration.row(0) = acceleration.row(1);
  acceleration.row(last) = acceleration.row(last - 1);
  return acceleration;
}

}  // namespace tonus::impedance
