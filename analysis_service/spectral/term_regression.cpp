#include "analysis_service/spectral/term_regression.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <complex>

namespace tonus::spectral {
namespace {

using Complex = std::complex<double>;

Eigen::VectorXd solved(const Eigen::MatrixXd& A, const Eigen::VectorXd& b) {
  return A.completeOrthogonalDecomposition().solve(b);
}

}  // namespace

template <int N>
TermRegression TermRegression::make(const SegmentFit<N>& fit, int i, std::span<const Eigen::MatrixXcd> motion,
                                    Eigen::Index first_bin, std::span<const Eigen::MatrixXcd> terms,
                                    const Eigen::VectorXd& removed) {
  TermRegression regression;
  regression.linear_ = 3 * N + 1;
  const Eigen::Index size = regression.linear_ + removed.size();
  const Normal none{Eigen::MatrixXd::Zero(size, size), Eigen::VectorXd::Zero(size)};
  regression.blocks_.assign(static_cast<std::size_t>(fit.blocks()), none);
  regression.all_ = none;
  const Eigen::Index bins = fit.w.size();
  Eigen::ArrayXd weight(bins);
  for (Eigen::Index k = 0; k < bins; ++k)
    weight[k] = 1.0 / std::max(fit.likelihood.bin(fit.p, fit.all, k).noise(i, i).real(), 1e-300);
  const double lag = fit.p[Likelihood<N>::kImpedance + i];
  Eigen::VectorXcd row(size);
  for (std::size_t s = 0; s < fit.segments.size(); ++s) {
    Normal& normal = regression.blocks_[static_cast<std::size_t>(fit.block_of[s])];
    for (Eigen::Index k = 0; k < bins; ++k) {
      const double w = fit.likelihood.w()[k];
      const Eigen::Index at = fit.bins[static_cast<std::size_t>(k)] - first_bin;
      const auto y = fit.Y[s].col(k);
      const Complex F = y[i] * std::polar(1.0, w * lag);
      Complex R = F;
      for (int j = 0; j < N; ++j) {
        R -= fit.p[i * N + j] * y[N + j] + fit.p[N * N + i * N + j] * y[2 * N + j] +
             fit.p[2 * N * N + i * N + j] * y[3 * N + j];
        row[j] = motion[s](N + j, at) / (fit.displacement_unit[j] * fit.w_unit * fit.w_unit);
        row[N + j] = motion[s](2 * N + j, at) / (fit.displacement_unit[j] * fit.w_unit);
        row[2 * N + j] = motion[s](3 * N + j, at) / fit.displacement_unit[j];
      }
      row[3 * N] = Complex(0.0, -w) * F;
      row.tail(removed.size()) = terms[s].col(k);
      R += removed.cast<Complex>().cwiseProduct(terms[s].col(k)).sum();
      normal.A.noalias() += weight[k] * (row.conjugate() * row.transpose()).real();
      normal.b += weight[k] * (row.conjugate() * R).real();
      regression.force_power_ += weight[k] * std::norm(F);
    }
  }
  for (const Normal& block : regression.blocks_) {
    regression.all_.A += block.A;
    regression.all_.b += block.b;
  }
  regression.plain_ = solved(regression.all_.A.topLeftCorner(regression.linear_, regression.linear_),
                             regression.all_.b.head(regression.linear_));
  return regression;
}

TermRegression::Solution TermRegression::solve(std::span<const int> terms) const {
  std::vector<int> columns;
  columns.reserve(static_cast<std::size_t>(linear_) + terms.size());
  for (int c = 0; c < linear_; ++c) columns.push_back(c);
  for (const int term : terms) columns.push_back(linear_ + term);
  Solution solution;
  solution.theta = solved(all_.A(columns, columns), all_.b(columns));
  solution.explained = solution.theta.dot(all_.b(columns));
  solution.reduction = solution.explained - plain_.dot(all_.b.head(linear_));
  solution.without_block.resize(solution.theta.size(), static_cast<Eigen::Index>(blocks_.size()));
  solution.explained_without_block.resize(solution.without_block.cols());
  for (std::size_t b = 0; b < blocks_.size(); ++b) {
    const Normal& block = blocks_[b];
    const auto at = static_cast<Eigen::Index>(b);
    const Eigen::VectorXd rest = all_.b(columns) - block.b(columns);
    solution.without_block.col(at) = solved(all_.A(columns, columns) - block.A(columns, columns), rest);
    solution.explained_without_block[at] = solution.without_block.col(at).dot(rest);
  }
  return solution;
}

double TermRegression::share(int term, double coefficient) const {
  const int at = linear_ + term;
  return std::abs(coefficient) * std::sqrt(all_.A(at, at) / std::max(force_power_, 1e-300));
}

Eigen::VectorXd TermRegression::standard_errors(const Eigen::MatrixXd& without_block) {
  const auto m = static_cast<double>(without_block.cols());
  const Eigen::MatrixXd about = without_block.colwise() - without_block.rowwise().mean();
  return ((m - 1.0) / m * about.rowwise().squaredNorm()).cwiseSqrt();
}

template TermRegression TermRegression::make(const SegmentFit<1>&, int, std::span<const Eigen::MatrixXcd>,
                                             Eigen::Index, std::span<const Eigen::MatrixXcd>,
                                             const Eigen::VectorXd&);
template TermRegression TermRegression::make(const SegmentFit<2>&, int, std::span<const Eigen::MatrixXcd>,
                                             Eigen::Index, std::span<const Eigen::MatrixXcd>,
                                             const Eigen::VectorXd&);

}  // namespace tonus::spectral
