#include "analysis_service/spectral/nonlinear_terms.hpp"

#include <Eigen/LU>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <unsupported/Eigen/FFT>

namespace tonus::spectral {
namespace {

using Complex = std::complex<double>;

/// Motion estimated from both signals within the fitted band: x^ and its rate.
template <int N>
struct Motion {
  Eigen::MatrixXd position;
  Eigen::MatrixXd velocity;
};

/// Transform behind zeros up to a fast length.
std::vector<Complex> transformed(const Eigen::Ref<const Eigen::VectorXd>& signal, Eigen::Index length,
                                 Eigen::FFT<double>& transform) {
  std::vector<Complex> padded(static_cast<std::size_t>(length));
  for (Eigen::Index i = 0; i < signal.size(); ++i) padded[static_cast<std::size_t>(i)] = signal[i];
  std::vector<Complex> spectrum;
  transform.fwd(spectrum, padded);
  return spectrum;
}

template <int N>
Motion<N> motion_of(const Record& record, const SegmentFit<N>& fit) {
  using Square = Eigen::Matrix<Complex, N, N>;
  constexpr int kSquare = N * N;
  const Eigen::Index rows = record.samples();
  const Eigen::Index length = fast_length(rows);
  Eigen::FFT<double> transform;
  std::array<std::vector<Complex>, N> x;
  std::array<std::vector<Complex>, N> f;
  for (int i = 0; i < N; ++i) {
    x[i] = transformed(record.displacement.col(i), length, transform);
    f[i] = transformed(record.force.col(i), length, transform);
  }
  std::array<std::vector<Complex>, N> both;  // position and velocity of an axis in one transform
  for (auto& spectrum : both) spectrum.assign(static_cast<std::size_t>(length), 0.0);
  const double step = 2.0 * std::numbers::pi / (static_cast<double>(length) * record.sample_period);
  const double low = 0.7 * fit.w[0];
  const double high = 1.2 * fit.w[fit.w.size() - 1];
  for (Eigen::Index k = 1; k < (length + 1) / 2; ++k) {
    const auto at = static_cast<std::size_t>(k);
    const double frequency = step * static_cast<double>(k);
    if (frequency <= low || frequency >= high) continue;
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
    const Eigen::Matrix<Complex, N, 1> estimate = X + nx.asDiagonal() * (Z.adjoint() * (noise.inverse() * R));
    for (int i = 0; i < N; ++i) {
      const Complex position = estimate[i] * fit.displacement_unit[i];
      const Complex velocity = Complex(0.0, frequency) * position;
      const auto mirrored = static_cast<std::size_t>(length - k);
      both[static_cast<std::size_t>(i)][at] = position + Complex(0.0, 1.0) * velocity;
      both[static_cast<std::size_t>(i)][mirrored] =
          std::conj(position) + Complex(0.0, 1.0) * std::conj(velocity);
    }
  }
  Motion<N> motion{Eigen::MatrixXd(rows, N), Eigen::MatrixXd(rows, N)};
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

double value_of(Term term, double position, double velocity) {
  switch (term) {
    case Term::kFriction:
      return velocity > 0.0 ? 1.0 : velocity < 0.0 ? -1.0 : 0.0;
    case Term::kHardening:
      return position * position * position;
    case Term::kDrag:
      return velocity * std::abs(velocity);
    case Term::kPosition:
      return position * position;
  }
  return 0.0;
}

/// What one of a coefficient on scaled signals is in SI.
double unit_of(Term term, double force, double position, double velocity) {
  switch (term) {
    case Term::kFriction:
      return force;
    case Term::kHardening:
      return force / (position * position * position);
    case Term::kDrag:
      return force / (velocity * velocity);
    case Term::kPosition:
      return force / (position * position);
  }
  return force;
}

struct Normal {
  Eigen::MatrixXd A;
  Eigen::VectorXd b;
};

Eigen::VectorXd solved(const Eigen::MatrixXd& A, const Eigen::VectorXd& b) {
  return A.completeOrthogonalDecomposition().solve(b);
}

}  // namespace

template <int N>
std::vector<TermFit> fit_terms(std::span<const Record> records, const SegmentFit<N>& fit) {
  constexpr int kLinear = 3 * N + 1;  // X2, X1, X0 of the axes, and the lag
  constexpr int kTermCount = static_cast<int>(kTerms.size());
  std::vector<Motion<N>> motions;
  Eigen::ArrayXd spread_x = Eigen::ArrayXd::Zero(N);
  Eigen::ArrayXd spread_v = Eigen::ArrayXd::Zero(N);
  double rows = 0.0;
  for (const Record& record : records) {
    motions.push_back(motion_of<N>(record, fit));
    spread_x += motions.back().position.colwise().squaredNorm().transpose().array();
    spread_v += motions.back().velocity.colwise().squaredNorm().transpose().array();
    rows += static_cast<double>(record.samples());
  }
  spread_x = (spread_x / rows).sqrt();
  spread_v = (spread_v / rows).sqrt();

  std::vector<Record> estimated;  // x^ through the same windows
  std::vector<Eigen::MatrixXd> signals;
  for (std::size_t r = 0; r < records.size(); ++r) {
    const Motion<N>& motion = motions[r];
    Eigen::MatrixXd terms(motion.position.rows(), kTermCount * N);
    for (Eigen::Index t = 0; t < terms.rows(); ++t) {
      for (int j = 0; j < N; ++j) {
        const double x = motion.position(t, j) / spread_x[j];
        const double v = motion.velocity(t, j) / spread_v[j];
        for (int n = 0; n < kTermCount; ++n)
          terms(t, n * N + j) = value_of(kTerms[static_cast<std::size_t>(n)], x, v);
      }
    }
    signals.push_back(std::move(terms));
    estimated.push_back({records[r].sample_period, motion.position, records[r].force, {}});
  }
  const Bins range{fit.bins.front(), fit.bins.back() + 1};
  const auto H = windowed_spectra(estimated, fit.segments, fit.length, range);
  const auto S = windowed_spectra(signals, fit.segments, fit.length, fit.bins);

  const int m = fit.blocks();
  const Eigen::Index bins = fit.w.size();
  Eigen::MatrixXd weight(N, bins);
  for (Eigen::Index k = 0; k < bins; ++k) {
    const auto b = fit.likelihood.bin(fit.p, fit.all, k);
    weight.col(k) = b.noise.diagonal().real().cwiseMax(1e-300).cwiseInverse();
  }
  std::vector<TermFit> found;
  for (int i = 0; i < N; ++i) {
    const int lag_at = Likelihood<N>::kImpedance + i;
    // By block: normal equations of the linear part, all terms together; single terms are picked out of them.
    const int size = kLinear + kTermCount * N;
    std::vector<Normal> blocks(static_cast<std::size_t>(m),
                               {Eigen::MatrixXd::Zero(size, size), Eigen::VectorXd::Zero(size)});
    double force_power = 0.0;
    Eigen::VectorXcd row(size);
    for (std::size_t s = 0; s < fit.segments.size(); ++s) {
      Normal& normal = blocks[static_cast<std::size_t>(fit.block_of[s])];
      for (Eigen::Index k = 0; k < bins; ++k) {
        const double w = fit.likelihood.w()[k];
        const Eigen::Index at = fit.bins[static_cast<std::size_t>(k)] - range.first;
        const auto y = fit.Y[s].col(k);
        Complex F = y[i] * std::polar(1.0, w * fit.p[lag_at]);
        Complex R = F;
        for (int j = 0; j < N; ++j) {
          R -= fit.p[i * N + j] * y[N + j] + fit.p[N * N + i * N + j] * y[2 * N + j] +
               fit.p[2 * N * N + i * N + j] * y[3 * N + j];
          row[j] = H[s](N + j, at) / (fit.displacement_unit[j] * fit.w_unit * fit.w_unit);
          row[N + j] = H[s](2 * N + j, at) / (fit.displacement_unit[j] * fit.w_unit);
          row[2 * N + j] = H[s](3 * N + j, at) / fit.displacement_unit[j];
        }
        row[3 * N] = Complex(0.0, -w) * F;
        row.tail(kTermCount * N) = S[s].col(k);
        normal.A.noalias() += weight(i, k) * (row.conjugate() * row.transpose()).real();
        normal.b += weight(i, k) * (row.conjugate() * R).real();
        force_power += weight(i, k) * std::norm(F);
      }
    }
    Normal all{Eigen::MatrixXd::Zero(size, size), Eigen::VectorXd::Zero(size)};
    for (const Normal& block : blocks) {
      all.A += block.A;
      all.b += block.b;
    }
    const Eigen::VectorXd plain = solved(all.A.topLeftCorner(kLinear, kLinear), all.b.head(kLinear));
    for (int n = 0; n < kTermCount; ++n) {
      for (int j = 0; j < N; ++j) {
        std::vector<int> with(kLinear + 1);
        for (int c = 0; c < kLinear; ++c) with[static_cast<std::size_t>(c)] = c;
        with.back() = kLinear + n * N + j;
        const Eigen::VectorXd theta = solved(all.A(with, with), all.b(with));
        Eigen::MatrixXd by_block(kLinear + 1, m);
        for (int b = 0; b < m; ++b) {
          const Normal& block = blocks[static_cast<std::size_t>(b)];
          by_block.col(b) = solved(all.A(with, with) - block.A(with, with), all.b(with) - block.b(with));
        }
        by_block.colwise() -= by_block.rowwise().mean().eval();
        const Eigen::VectorXd error =
            (static_cast<double>(m - 1) / m * by_block.rowwise().squaredNorm()).cwiseSqrt();
        TermFit term;
        term.term = kTerms[static_cast<std::size_t>(n)];
        term.force_axis = i;
        term.motion_axis = j;
        const double unit = unit_of(term.term, fit.force_unit[i], spread_x[j], spread_v[j]);
        term.coefficient = theta[kLinear] * unit;
        term.standard_error = error[kLinear] * unit;
        term.t = theta[kLinear] / std::max(error[kLinear], 1e-300);
        term.share = std::abs(theta[kLinear]) *
                     std::sqrt(all.A(with.back(), with.back()) / std::max(force_power, 1e-300));
        term.impedance.resize(3 * N);
        term.impedance_error.resize(3 * N);
        for (int part = 0; part < 3; ++part) {
          for (int c = 0; c < N; ++c) {
            const int element = part * N * N + i * N + c;
            const double shift = theta[part * N + c] - plain[part * N + c];
            term.change = std::max(term.change, std::abs(shift) / fit.largest_beside(element));
            term.impedance[part * N + c] = (fit.p[element] + theta[part * N + c]) * fit.unit[element];
            term.impedance_error[part * N + c] = error[part * N + c] * fit.unit[element];
          }
        }
        if (term.term == Term::kPosition) {
          const double stiffness = fit.largest_beside(2 * N * N) * fit.unit[2 * N * N + i * N + j];
          term.stiffness_change = std::abs(4.0 * term.coefficient * spread_x[j] / stiffness);
        }
        found.push_back(std::move(term));
      }
    }
  }
  return found;
}

template std::vector<TermFit> fit_terms<1>(std::span<const Record>, const SegmentFit<1>&);
template std::vector<TermFit> fit_terms<2>(std::span<const Record>, const SegmentFit<2>&);

}  // namespace tonus::spectral
