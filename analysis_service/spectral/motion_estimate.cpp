#include "analysis_service/spectral/motion_estimate.hpp"

#include <Eigen/LU>
#include <array>
#include <cmath>
#include <complex>
#include <numbers>
#include <unsupported/Eigen/FFT>
#include <vector>

namespace tonus::spectral {
namespace {

using Complex = std::complex<double>;

/// Transform behind zeros up to a fast length.
std::vector<Complex> transformed(const Eigen::Ref<const Eigen::VectorXd>& signal, Eigen::Index length,
                                 Eigen::FFT<double>& transform) {
  std::vector<Complex> padded(static_cast<std::size_t>(length));
  for (Eigen::Index i = 0; i < signal.size(); ++i) padded[static_cast<std::size_t>(i)] = signal[i];
  std::vector<Complex> spectrum;
  transform.fwd(spectrum, padded);
  return spectrum;
}

}  // namespace

template <int N>
MotionEstimate motion_estimate(const Record& record, const SegmentFit<N>& fit, double delay,
                               bool is_slow_kept) {
  using Square = Eigen::Matrix<Complex, N, N>;
  constexpr int kSquare = N * N;
  const Eigen::Index rows = record.samples();
  const Eigen::Index length = fast_length(rows);
  Eigen::FFT<double> transform;
  std::array<std::vector<Complex>, N> x;
  std::array<std::vector<Complex>, N> f;
  for (std::size_t i = 0; i < N; ++i) {
    const auto axis = static_cast<Eigen::Index>(i);
    x[i] = transformed(record.displacement.col(axis), length, transform);
    f[i] = transformed(record.force.col(axis), length, transform);
  }
  std::array<std::vector<Complex>, N> both;  // position and velocity of an axis in one transform
  for (auto& spectrum : both) spectrum.assign(static_cast<std::size_t>(length), 0.0);
  const double step = 2.0 * std::numbers::pi / (static_cast<double>(length) * record.sample_period);
  const double low = 0.7 * fit.w[0];
  const double high = 1.2 * fit.w[fit.w.size() - 1];
  for (Eigen::Index k = 1; k < (length + 1) / 2; ++k) {
    const auto at = static_cast<std::size_t>(k);
    const double frequency = step * static_cast<double>(k);
    const bool is_slow = frequency <= low;
    if ((is_slow && !is_slow_kept) || frequency >= high) continue;
    const double w = frequency / fit.w_unit;
    Square Z;
    Eigen::Matrix<Complex, N, 1> X;
    Eigen::Matrix<Complex, N, 1> F;
    Eigen::Matrix<double, N, 1> nx;
    Eigen::Matrix<double, N, 1> nf;
    for (int i = 0; i < N; ++i) {
      for (int j = 0; j < N; ++j)
        Z(i, j) = {fit.p[2 * kSquare + i * N + j] - w * w * fit.p[i * N + j], w * fit.p[kSquare + i * N + j]};
      const double* law = fit.p.data() + Likelihood<N>::kStructural + 4 * i;
      nx[i] = std::exp(law[0] + law[1] * std::log(w));
      nf[i] = std::exp(law[2] + law[3] * std::log(w));
      X[i] = x[static_cast<std::size_t>(i)][at] / fit.displacement_unit[i];
      F[i] = f[static_cast<std::size_t>(i)][at] / fit.force_unit[i] *
             std::polar(1.0, w * fit.p[Likelihood<N>::kImpedance + i]);
    }
    Square noise = Z * nx.asDiagonal() * Z.adjoint();
    for (int i = 0; i < N; ++i) noise(i, i) += nf[i];
    const Eigen::Matrix<Complex, N, 1> R = F - Z * X;
    Eigen::Matrix<Complex, N, 1> estimate = X;
    if (!is_slow) estimate += nx.asDiagonal() * (Z.adjoint() * (noise.inverse() * R));
    for (int i = 0; i < N; ++i) {
      const Complex position = estimate[i] * std::polar(fit.displacement_unit[i], -frequency * delay);
      const Complex velocity = Complex(0.0, frequency) * position;
      const auto mirrored = static_cast<std::size_t>(length - k);
      both[static_cast<std::size_t>(i)][at] = position + Complex(0.0, 1.0) * velocity;
      both[static_cast<std::size_t>(i)][mirrored] =
          std::conj(position) + Complex(0.0, 1.0) * std::conj(velocity);
    }
  }
  MotionEstimate motion{Eigen::MatrixXd(rows, N), Eigen::MatrixXd(rows, N)};
  for (int i = 0; i < N; ++i) {
    std::vector<Complex> signal;
    transform.inv(signal, both[static_cast<std::size_t>(i)]);
    for (Eigen::Index t = 0; t < rows; ++t) {
      motion.position(t, i) = signal[static_cast<std::size_t>(t)].real();
      motion.velocity(t, i) = signal[static_cast<std::size_t>(t)].imag();
    }
  }
  return motion;
}

template MotionEstimate motion_estimate<1>(const Record&, const SegmentFit<1>&, double, bool);
template MotionEstimate motion_estimate<2>(const Record&, const SegmentFit<2>&, double, bool);

}  // namespace tonus::spectral
