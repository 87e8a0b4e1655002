#include "analysis_service/spectral/bin_choice.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <complex>
#include <numbers>
#include <utility>

namespace tonus::spectral {
namespace {

using Complex = std::complex<double>;

constexpr double kLeastPower = 1e-3;  // of the strongest bin, in force or motion

/// Least squared canonical correlation of F and X0 of a bin, its bias for `freedom` segments taken away.
template <int N>
double coherence_of(const Eigen::Matrix<Complex, N, N>& FF, const Eigen::Matrix<Complex, N, N>& FX,
                    const Eigen::Matrix<Complex, N, N>& XX, double freedom) {
  using Square = Eigen::Matrix<Complex, N, N>;
  const Eigen::LLT<Square> force(FF);
  const Eigen::LLT<Square> motion(XX);
  if (force.info() != Eigen::Success || motion.info() != Eigen::Success) return 0.0;
  Square half = force.matrixL().solve(FX);
  half = motion.matrixL().solve(half.adjoint().eval());
  const Square product = half * half.adjoint();
  const double least = Eigen::SelfAdjointEigenSolver<Square>(product).eigenvalues()[0];
  const double bias = N / freedom;
  return std::clamp((least - bias) / (1.0 - bias), 0.0, 1.0);
}

}  // namespace

template <int N>
BinChoice choose_bins(const std::vector<Eigen::MatrixXcd>& Y, const std::vector<std::size_t>& active,
                      const Eigen::ArrayXd& w, double least_coherence, const FrequencyRange& range) {
  using Square = Eigen::Matrix<Complex, N, N>;
  const Eigen::Index bins = w.size();
  Eigen::MatrixXd force(N, bins);
  Eigen::MatrixXd motion(N, bins);
  BinChoice choice;
  choice.coherence.resize(bins);
  for (Eigen::Index k = 0; k < bins; ++k) {
    Square FF = Square::Zero();
    Square FX = Square::Zero();
    Square XX = Square::Zero();
    for (const std::size_t s : active) {
      const Eigen::Matrix<Complex, N, 1> f = Y[s].col(k).template head<N>();
      const Eigen::Matrix<Complex, N, 1> x = Y[s].col(k).template tail<N>();
      FF += f * f.adjoint();
      FX += f * x.adjoint();
      XX += x * x.adjoint();
    }
    force.col(k) = FF.diagonal().real();
    motion.col(k) = XX.diagonal().real();
    choice.coherence[k] = coherence_of<N>(FF, FX, XX, static_cast<double>(active.size()) / kOverlap);
  }
  std::vector<Eigen::Index>& chosen = choice.bins;
  for (Eigen::Index k = 0; k < bins; ++k) {
    const double hz = w[k] / (2.0 * std::numbers::pi);
    bool is_used = choice.coherence[k] > least_coherence && hz >= range.low && hz <= range.high;
    for (int i = 0; i < N; ++i)
      is_used = is_used && (force(i, k) > kLeastPower * force.row(i).maxCoeff() ||
                            motion(i, k) > kLeastPower * motion.row(i).maxCoeff());
    if (is_used) chosen.push_back(k);
  }
  constexpr Eigen::Index kMost = N == 1 ? 200 : 120;
  const auto count = static_cast<Eigen::Index>(chosen.size());
  if (count <= kMost) return choice;
  std::vector<Eigen::Index> thinned;
  for (Eigen::Index i = 0; i < kMost; ++i)
    thinned.push_back(chosen[static_cast<std::size_t>(i * (count - 1) / (kMost - 1))]);
  chosen = std::move(thinned);
  return choice;
}

double noise_floor(const std::vector<Eigen::MatrixXcd>& Y, const std::vector<std::size_t>& active, int row,
                   Eigen::Index first) {
  constexpr Eigen::Index kFewest = 8;
  constexpr double kQuantile = 0.25;
  const Eigen::Index bins = Y.front().cols() - first;
  if (bins < kFewest) return 0.0;
  std::vector<double> power(static_cast<std::size_t>(bins), 0.0);
  for (const std::size_t s : active) {
    for (Eigen::Index k = 0; k < bins; ++k)
      power[static_cast<std::size_t>(k)] +=
          std::norm(Y[s](row, first + k)) / static_cast<double>(active.size());
  }
  const auto at = static_cast<std::ptrdiff_t>(kQuantile * static_cast<double>(bins));
  std::nth_element(power.begin(), power.begin() + at, power.end());
  return power[static_cast<std::size_t>(at)];
}

template BinChoice choose_bins<1>(const std::vector<Eigen::MatrixXcd>&, const std::vector<std::size_t>&,
                                  const Eigen::ArrayXd&, double, const FrequencyRange&);
template BinChoice choose_bins<2>(const std::vector<Eigen::MatrixXcd>&, const std::vector<std::size_t>&,
                                  const Eigen::ArrayXd&, double, const FrequencyRange&);

}  // namespace tonus::spectral
