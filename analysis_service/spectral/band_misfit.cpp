#include "analysis_service/spectral/band_misfit.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <vector>

#include "analysis_service/statistics/distributions.hpp"

namespace tonus::spectral {
namespace {

/// Bins of each of kBandCount bands of equal ratio of frequencies; empty ones are left out.
std::vector<std::pair<Eigen::Index, Eigen::Index>> bands_of(const Eigen::ArrayXd& w) {
  std::vector<std::pair<Eigen::Index, Eigen::Index>> bands;
  const double low = std::log(w[0]);
  const double width = (std::log(w[w.size() - 1]) - low) * (1.0 + 1e-9) / kBandCount;
  Eigen::Index first = 0;
  for (int band = 0; band < kBandCount; ++band) {
    Eigen::Index end = first;
    while (end < w.size() && (std::log(w[end]) < low + width * (band + 1) || band + 1 == kBandCount)) ++end;
    if (end > first) bands.emplace_back(first, end);
    first = end;
  }
  return bands;
}

/// Departures by band, N^2 complex values each: sum (<R X0^H> + Z nx)_ij Z_ii* / N_ii over
/// sum |Z_ii|^2 S0_jj / N_ii.
template <int N>
Eigen::ArrayXcd departures(const SegmentFit<N>& fit, const typename Likelihood<N>::Vector& p,
                           const typename Likelihood<N>::Data& data) {
  const auto bands = bands_of(fit.w);
  Eigen::ArrayXcd found(static_cast<Eigen::Index>(bands.size()) * N * N);
  Eigen::Index at = 0;
  for (const auto& [first, end] : bands) {
    Eigen::Matrix<std::complex<double>, N, N> above = Eigen::Matrix<std::complex<double>, N, N>::Zero();
    Eigen::Matrix<double, N, N> below = Eigen::Matrix<double, N, N>::Zero();
    for (Eigen::Index k = first; k < end; ++k) {
      const auto b = fit.likelihood.bin(p, data, k);
      for (int i = 0; i < N; ++i) {
        const double noise = b.noise(i, i).real();
        for (int j = 0; j < N; ++j) {
          const double power = b.XX(j, j).real();
          above(i, j) += (b.RX(i, j) + b.Z(i, j) * b.nx[j]) * std::conj(b.Z(i, i)) / noise;
          below(i, j) += std::max(power - b.nx[j], 0.1 * power) * std::norm(b.Z(i, i)) / noise;
        }
      }
    }
    for (int i = 0; i < N; ++i) {
      for (int j = 0; j < N; ++j) found[at++] = above(i, j) / std::max(below(i, j), 1e-300);
    }
  }
  return found;
}

}  // namespace

bool is_acceptable(const BandMisfit& misfit) {
  return misfit.ratio < kMostRatio || (misfit.ratio < kSmallMisfitRatio && misfit.largest < kSmallMisfit);
}

template <int N>
BandMisfit misfit_of(const SegmentFit<N>& fit) {
  const Eigen::ArrayXcd e = departures(fit, fit.p, fit.all);
  const int m = fit.blocks();
  Eigen::ArrayXXcd by_block(e.size(), m);
  for (int b = 0; b < m; ++b) {
    const typename Likelihood<N>::Vector p = fit.p + fit.shifts.row(b).transpose();
    by_block.col(b) = departures(fit, p, fit.without[static_cast<std::size_t>(b)]);
  }
  by_block.colwise() -= by_block.rowwise().mean().eval();
  const double factor = static_cast<double>(m - 1) / m;
  const Eigen::ArrayXd real = factor * by_block.real().square().rowwise().sum();
  const Eigen::ArrayXd imaginary = factor * by_block.imag().square().rowwise().sum();
  const double freedom = std::max(m - 1, 3);
  const double sum =
      (e.real().square() / real.max(1e-300) + e.imag().square() / imaginary.max(1e-300)).sum() *
      (freedom - 2.0) / freedom;
  BandMisfit misfit;
  misfit.ratio =
      sum / static_cast<double>(std::max<Eigen::Index>(1, 2 * e.size() - Likelihood<N>::kStructural));
  misfit.largest =
      (e.real().square() - 4.0 * real).max(e.imag().square() - 4.0 * imaginary).max(0.0).sqrt().maxCoeff();
  return misfit;
}

template <int N>
Eigen::VectorXd variance_over_bands(const SegmentFit<N>& fit) {
  const auto bands = bands_of(fit.w);
  const auto count = static_cast<Eigen::Index>(bands.size());
  Eigen::MatrixXd shifts(count, Likelihood<N>::kParameters);
  for (Eigen::Index b = 0; b < count; ++b) {
    const auto& [first, end] = bands[static_cast<std::size_t>(b)];
    shifts.row(b) = fit.likelihood.gradient(fit.p, fit.all, first, end).transpose();
  }
  shifts.rowwise() -= shifts.colwise().mean().eval();
  shifts = (shifts * fit.inverse_hessian).eval();
  const double factor =
      static_cast<double>(count) / static_cast<double>(std::max<Eigen::Index>(1, count - 1));
  return factor * shifts.leftCols(Likelihood<N>::kStructural).colwise().squaredNorm().transpose();
}

template <int N>
HalvesDifference halves_of(const SegmentFit<N>& fit, bool is_middle_against_ends) {
  using Model = Likelihood<N>;
  constexpr int kImpedance = Model::kImpedance;
  const int m = fit.blocks();
  typename Model::Data half[2];
  for (auto& data : half) data.moments.assign(fit.all.moments.size(), Model::Moment::Zero());
  for (int b = 0; b < m; ++b) {
    const bool is_first = is_middle_against_ends ? std::abs(b - 0.5 * (m - 1)) < 0.25 * m : b < m / 2;
    auto& data = half[is_first ? 0 : 1];
    const auto& block = fit.only[static_cast<std::size_t>(b)];
    data.segments += block.segments;
    for (std::size_t k = 0; k < data.moments.size(); ++k) data.moments[k] += block.moments[k];
  }
  HalvesDifference difference;
  const double freedom = m - 1 - kImpedance + 1.0;
  if (!(half[0].segments > 0.0) || !(half[1].segments > 0.0)) return difference;
  const Eigen::VectorXd shift = -(fit.inverse_hessian * (fit.likelihood.gradient(fit.p, half[0]) -
                                                         fit.likelihood.gradient(fit.p, half[1])))
                                     .head(kImpedance);
  const double grown = fit.all.segments * (1.0 / half[0].segments + 1.0 / half[1].segments);
  const auto f_limit = [&](double probability, double count, double below) {
    return statistics::fisher_quantile(probability, count, std::max(1.0, below));
  };
  if (freedom >= 3.0) {
    const Eigen::MatrixXd covariance = grown * fit.covariance.topLeftCorner(kImpedance, kImpedance);
    const double F = shift.dot(covariance.ldlt().solve(shift)) * freedom / (kImpedance * (m - 1.0));
    difference.value = std::sqrt(std::max(F, 0.0) / f_limit(0.95, kImpedance, freedom));
    difference.threshold =
        std::sqrt(f_limit(0.999, kImpedance, freedom) / f_limit(0.95, kImpedance, freedom));
  } else {  // too few blocks for a joint statement: the worst element, by Bonferroni
    const double t95 = statistics::student_t_quantile(1.0 - 0.025 / kImpedance, m - 1);
    for (int i = 0; i < kImpedance; ++i)
      difference.value =
          std::max(difference.value, std::abs(shift[i]) / std::sqrt(grown * fit.covariance(i, i)) / t95);
    difference.threshold = statistics::student_t_quantile(1.0 - 0.0005 / kImpedance, m - 1) / t95;
  }
  for (int i = 0; i < kImpedance; ++i)
    difference.effect = std::max(difference.effect, std::abs(shift[i]) / fit.largest_beside(i));
  return difference;
}

template BandMisfit misfit_of<1>(const SegmentFit<1>&);
template BandMisfit misfit_of<2>(const SegmentFit<2>&);
template Eigen::VectorXd variance_over_bands<1>(const SegmentFit<1>&);
template Eigen::VectorXd variance_over_bands<2>(const SegmentFit<2>&);
template HalvesDifference halves_of<1>(const SegmentFit<1>&, bool);
template HalvesDifference halves_of<2>(const SegmentFit<2>&, bool);

}  // namespace tonus::spectral
