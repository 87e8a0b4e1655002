#include "analysis_service/spectral/likelihood.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace tonus::spectral {
namespace {

constexpr double kLevelSpread = 3.0;   // of the prior on ln of a noise's level
constexpr double kSlopeSpread = 1.0;   // and on the exponent of its law
constexpr double kLeastShare = 1e-12;  // of the displacement's power that is taken as motion
constexpr double kStep = 1e-5;         // of the Hessian's differences

double clamped_exp(double x) { return std::exp(std::clamp(x, -80.0, 40.0)); }

}  // namespace

template <int N>
typename Likelihood<N>::Bin Likelihood<N>::bin(const Vector& p, const Data& data, Eigen::Index k) const {
  constexpr int kSquare = N * N;
  const double w = w_[k];
  const Moment& G = data.moments[static_cast<std::size_t>(k)];
  Bin b;
  b.A.setZero();
  for (int i = 0; i < N; ++i) {
    b.A(i, i) = std::polar(1.0, w * p[kImpedance + i]);
    for (int j = 0; j < N; ++j) {
      const double M = p[i * N + j];
      const double B = p[kSquare + i * N + j];
      const double K = p[2 * kSquare + i * N + j];
      b.A(i, N + j) = -M;
      b.A(i, 2 * N + j) = -B;
      b.A(i, 3 * N + j) = -K;
      b.Z(i, j) = {K - w * w * M, w * B};
    }
    const double* law = p.data() + kStructural + 4 * i;
    b.nx[i] = clamped_exp(law[0] + law[1] * log_w_[k]);
    b.nf[i] = clamped_exp(law[2] + law[3] * log_w_[k]);
  }
  b.AG.noalias() = b.A * G;
  b.AG /= data.segments;
  b.RR.noalias() = b.AG * b.A.adjoint();
  b.RX = b.AG.template rightCols<N>();
  b.XX = G.template bottomRightCorner<N, N>() / data.segments;
  b.noise.noalias() = b.Z * b.nx.asDiagonal() * b.Z.adjoint();
  for (int i = 0; i < N; ++i) b.noise(i, i) += b.nf[i];
  b.N_inverse = b.noise.inverse();
  return b;
}

template <int N>
double Likelihood<N>::value(const Vector& p, const Data& data) const {
  double sum = 0.0;
  for (Eigen::Index k = 0; k < bins(); ++k) {
    const Bin b = bin(p, data, k);
    const Square T = b.nx.asDiagonal() * b.Z.adjoint() * b.N_inverse;
    const Square TRX = T * b.RX;
    const Square P = b.XX + TRX + TRX.adjoint() + T * b.RR * T.adjoint();
    const double least = kLeastShare * std::abs(b.XX.determinant());
    sum += std::log(std::abs(b.noise.determinant())) + (b.N_inverse * b.RR).trace().real() +
           std::log(std::max(P.determinant().real(), least));
  }
  sum *= weight_;
  if (!has_centre_) return sum;
  for (int i = kStructural; i < kParameters; ++i) {
    const double spread = (i - kStructural) % 2 == 0 ? kLevelSpread : kSlopeSpread;
    const double off = (p[i] - centre_[i]) / spread;
    sum += 0.5 * off * off;
  }
  return sum;
}

template <int N>
typename Likelihood<N>::Vector Likelihood<N>::gradient(const Vector& p, const Data& data, Eigen::Index first,
                                                       Eigen::Index end) const {
  constexpr int kSquare = N * N;
  Vector slope = Vector::Zero();
  for (Eigen::Index k = first; k < end; ++k) {
    const Bin b = bin(p, data, k);
    const double w = w_[k];
    const Moment& G = data.moments[static_cast<std::size_t>(k)];
    const Square T = b.nx.asDiagonal() * b.Z.adjoint() * b.N_inverse;
    const Square TRX = T * b.RX;
    const Square P = b.XX + TRX + TRX.adjoint() + T * b.RR * T.adjoint();
    const Square U = P.inverse();
    // dV = 2 Re tr(dA L) + tr(dN D) + 2 Re tr(dT W), T = nx Z^H N^-1 (equation 8).
    const Square W = (b.RX + b.RR * T.adjoint()) * U;
    const Eigen::Matrix<Complex, 4 * N, N> GQ =
        G.template rightCols<N>() / data.segments + b.AG.adjoint() * T.adjoint();
    const Eigen::Matrix<Complex, 4 * N, N> L = b.AG.adjoint() * b.N_inverse + GQ * (U * T);
    const Square H = b.N_inverse * W * T;
    const Square D = b.N_inverse - b.N_inverse * b.RR * b.N_inverse - H - H.adjoint();
    const Square NWn = b.N_inverse * W * b.nx.asDiagonal();
    const Square C = b.nx.asDiagonal() * b.Z.adjoint() * D + NWn.adjoint();
    const Square ZNW = b.Z.adjoint() * b.N_inverse * W;
    const Square ZDZ = b.Z.adjoint() * D * b.Z;
    for (int i = 0; i < N; ++i) {
      for (int j = 0; j < N; ++j) {
        slope[i * N + j] += -2.0 * L(N + j, i).real() - 2.0 * w * w * C(j, i).real();
        slope[kSquare + i * N + j] += -2.0 * L(2 * N + j, i).real() - 2.0 * w * C(j, i).imag();
        slope[2 * kSquare + i * N + j] += -2.0 * L(3 * N + j, i).real() + 2.0 * C(j, i).real();
      }
      slope[kImpedance + i] += 2.0 * (Complex(0.0, w) * b.A(i, i) * L(i, i)).real();
      const double by_nx = (2.0 * ZNW(i, i).real() + ZDZ(i, i).real()) * b.nx[i];
      const double by_nf = D(i, i).real() * b.nf[i];
      double* law = slope.data() + kStructural + 4 * i;
      law[0] += by_nx;
      law[1] += by_nx * log_w_[k];
      law[2] += by_nf;
      law[3] += by_nf * log_w_[k];
    }
  }
  slope *= weight_;
  if (!has_centre_ || first != 0 || end != bins()) return slope;
  for (int i = kStructural; i < kParameters; ++i) {
    const double spread = (i - kStructural) % 2 == 0 ? kLevelSpread : kSlopeSpread;
    slope[i] += (p[i] - centre_[i]) / (spread * spread);
  }
  return slope;
}

template <int N>
typename Likelihood<N>::Hessian Likelihood<N>::hessian(const Vector& p, const Data& data) const {
  Hessian H(kParameters, kParameters);
  for (int i = 0; i < kParameters; ++i) {
    Vector up = p;
    Vector down = p;
    up[i] += kStep;
    down[i] -= kStep;
    H.col(i) = (gradient(up, data) - gradient(down, data)) / (2.0 * kStep);
  }
  return 0.5 * (H + H.transpose());
}

template class Likelihood<1>;
template class Likelihood<2>;

}  // namespace tonus::spectral
