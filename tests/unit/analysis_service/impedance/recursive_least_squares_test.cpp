#include "analysis_service/impedance/recursive_least_squares.hpp"

#include <Eigen/Dense>
#include <gtest/gtest.h>
#include <random>

#include "analysis_service/impedance/pooled_fit.hpp"

namespace tonus::impedance::test {
namespace {

using Rls = RecursiveLeastSquares<7, 2>;

struct Rows {
  Eigen::MatrixXd phi;
  Eigen::MatrixXd f;
};

/// Rows with columns of the sizes that x", x', x and 1 have.
Rows random_rows(Eigen::Index count, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  const Eigen::Vector<double, 7> scale(1.0, 1.0, 0.08, 0.08, 0.005, 0.005, 1.0);
  Eigen::MatrixXd theta(7, 2);
  theta << 1.4, -0.8, -0.8, 1.3, 11, -8, -7, 21, 180, -100, -95, 340, 0.1, -0.2;
  Rows rows{Eigen::MatrixXd(count, 7), {}};
  for (Eigen::Index i = 0; i < count; ++i) {
    for (Eigen::Index j = 0; j < 7; ++j) rows.phi(i, j) = j == 6 ? 1.0 : scale[j] * normal(random);
  }
  rows.f = rows.phi * theta;
  for (double& value : rows.f.reshaped()) value += 0.05 * normal(random);
  return rows;
}

Rls factor_of(const Rows& rows) {
  Rls rls;
  for (Eigen::Index i = 0; i < rows.phi.rows(); ++i)
    rls.update(rows.phi.row(i).transpose(), rows.f.row(i).transpose());
  return rls;
}

double element_wise(const Eigen::MatrixXd& actual, const Eigen::MatrixXd& expected) {
  return ((actual - expected).array() / expected.array()).abs().maxCoeff();
}

TEST(RecursiveLeastSquares, EqualsTheBatchSolutionAfterEverySample) {
  const Rows rows = random_rows(60, 1);
  Rls rls;
  for (Eigen::Index i = 0; i < 60; ++i) {
    rls.update(rows.phi.row(i).transpose(), rows.f.row(i).transpose());
    if (i < 8) continue;
    const Eigen::MatrixXd batch = rows.phi.topRows(i + 1).colPivHouseholderQr().solve(rows.f.topRows(i + 1));
    EXPECT_LT(element_wise(solve(rls), batch), 1e-9) << "after " << i + 1 << " samples";
  }
}

TEST(RecursiveLeastSquares, HasTheBatchSolutionsResidual) {
  const Rows rows = random_rows(500, 2);
  const Eigen::MatrixXd batch = rows.phi.colPivHouseholderQr().solve(rows.f);
  const Eigen::RowVectorXd expected = (rows.f - rows.phi * batch).colwise().squaredNorm();
  EXPECT_LT(element_wise(factor_of(rows).residual().transpose(), expected), 1e-9);
}

TEST(RecursiveLeastSquares, MergesFactorsIntoTheFactorOfAllRows) {
  const Rows rows = random_rows(300, 3);
  Rls merged;
  for (const auto& [first, count] : {std::pair<Eigen::Index, Eigen::Index>{0, 5}, {5, 95}, {100, 200}}) {
    merged.merge(factor_of({rows.phi.middleRows(first, count), rows.f.middleRows(first, count)}));
  }
  const Rls whole = factor_of(rows);
  EXPECT_EQ(merged.samples(), 300);
  EXPECT_LT(element_wise(solve(merged), solve(whole)), 1e-9);
  EXPECT_LT(element_wise(merged.residual(), whole.residual()), 1e-9);
}

/// The same rows in blocks, the last one shorter.
Rls factor_in_blocks(const Rows& rows) {
  Rls rls;
  for (Eigen::Index first = 0; first < rows.phi.rows(); first += Rls::kBlockRows) {
    const Eigen::Index count = std::min<Eigen::Index>(Rls::kBlockRows, rows.phi.rows() - first);
    Rls::Block block = Rls::Block::Zero();
    block.topLeftCorner(count, 7) = rows.phi.middleRows(first, count);
    block.topRightCorner(count, 2) = rows.f.middleRows(first, count);
    rls.update(block, count);
  }
  return rls;
}

TEST(RecursiveLeastSquares, TakesBlocksOfRowsAsItTakesTheRows) {
  for (const Eigen::Index count : {9, 16, 100, 500}) {
    const Rows rows = random_rows(count, 8);
    const Rls blocks = factor_in_blocks(rows);
    const Rls single = factor_of(rows);
    EXPECT_EQ(blocks.samples(), count);
    EXPECT_LT(element_wise(solve(blocks), solve(single)), 1e-9) << count;
    EXPECT_LT(element_wise(blocks.residual(), single.residual()), 1e-9) << count;
    EXPECT_GT(blocks.R().diagonal().minCoeff(), 0.0);
    EXPECT_LT((blocks.R() - single.R()).norm(), 1e-9 * single.R().norm()) << count;
  }
}

TEST(RecursiveLeastSquares, StaysEqualToTheBatchSolutionOverTenMillionRowsInBlocks) {
  // As with single rows: 100,000 passes over 96 + 4 rows.
  const Rows rows = random_rows(100, 6);
  const Eigen::MatrixXd batch = rows.phi.colPivHouseholderQr().solve(rows.f);
  const Eigen::RowVectorXd residual = (rows.f - rows.phi * batch).colwise().squaredNorm();
  std::vector<Rls::Block> blocks;
  for (Eigen::Index first = 0; first < 100; first += Rls::kBlockRows) {
    const Eigen::Index count = std::min<Eigen::Index>(Rls::kBlockRows, 100 - first);
    blocks.emplace_back(Rls::Block::Zero());
    blocks.back().topLeftCorner(count, 7) = rows.phi.middleRows(first, count);
    blocks.back().topRightCorner(count, 2) = rows.f.middleRows(first, count);
  }
  Rls rls;
  for (int pass = 0; pass < 100'000; ++pass) {
    for (std::size_t i = 0; i < blocks.size(); ++i)
      rls.update(blocks[i], i + 1 < blocks.size() ? Rls::kBlockRows : 100 % Rls::kBlockRows);
  }
  EXPECT_EQ(rls.samples(), 10'000'000);
  EXPECT_LT(element_wise(solve(rls), batch), 1e-9);
  EXPECT_LT(element_wise(rls.residual().transpose() / 1e5, residual), 1e-9);
  EXPECT_GT(rls.R().diagonal().minCoeff(), 0.0);
}

TEST(RecursiveLeastSquares, KnowsNothingBeforeItHasSeenEnough) {
  const Rows rows = random_rows(7, 4);
  Rls rls;
  for (Eigen::Index i = 0; i < 6; ++i) {
    rls.update(rows.phi.row(i).transpose(), rows.f.row(i).transpose());
    EXPECT_GT(scaled_condition<7>(rls.R()), 1e12) << "after " << i + 1;
  }
  rls.update(rows.phi.row(6).transpose(), rows.f.row(6).transpose());
  EXPECT_LT(scaled_condition<7>(rls.R()), 1e6);
}

TEST(RecursiveLeastSquares, HasTheConditionNumberOfTheScaledRegressor) {
  const Rows rows = random_rows(100, 5);
  const Eigen::MatrixXd scaled = rows.phi * rows.phi.colwise().norm().cwiseInverse().asDiagonal();
  const Eigen::VectorXd values = scaled.jacobiSvd().singularValues();
  const double expected = values[0] / values[6];
  const Rls rls = factor_of(rows);
  EXPECT_NEAR(scaled_condition<7>(rls.R()) / expected, 1.0, 1e-9);
  EXPECT_GE(condition_bound<7>(rls.R()), expected);
  EXPECT_LE(condition_bound<7>(rls.R()), 7.0 * expected);
}

TEST(RecursiveLeastSquares, StaysEqualToTheBatchSolutionOverTenMillionUpdates) {
  // 100,000 passes over the same 100 rows: their batch solution is that of one pass, the residual 100,000
  // times.
  const Rows rows = random_rows(100, 6);
  const Eigen::MatrixXd batch = rows.phi.colPivHouseholderQr().solve(rows.f);
  const Eigen::RowVectorXd residual = (rows.f - rows.phi * batch).colwise().squaredNorm();
  std::vector<Rls::Regressor> phi;
  std::vector<Rls::Output> f;
  for (Eigen::Index i = 0; i < 100; ++i) {
    phi.emplace_back(rows.phi.row(i).transpose());
    f.emplace_back(rows.f.row(i).transpose());
  }
  Rls rls;
  for (int pass = 0; pass < 100'000; ++pass) {
    for (std::size_t i = 0; i < 100; ++i) rls.update(phi[i], f[i]);
  }
  EXPECT_EQ(rls.samples(), 10'000'000);
  EXPECT_LT(element_wise(solve(rls), batch), 1e-9);
  EXPECT_LT(element_wise(rls.residual().transpose() / 1e5, residual), 1e-9);
  const Rls::Factor R = rls.R();
  EXPECT_GT(R.diagonal().minCoeff(), 0.0);
  EXPECT_TRUE(R.isUpperTriangular(0.0));
}

TEST(RecursiveLeastSquares, EqualsTheBatchSolutionOfOneAxisAfterEverySample) {
  RecursiveLeastSquares<4, 1> rls;
  std::mt19937_64 random(7);
  std::normal_distribution<double> normal;
  const Eigen::Vector4d theta(0.017, 1.2, 105.0, -0.4);  // kg m2, N m s/rad, N m/rad, N m
  Eigen::MatrixXd phi(60, 4);
  Eigen::VectorXd f(60);
  for (Eigen::Index i = 0; i < 60; ++i) {
    phi.row(i) << 40.0 * normal(random), 0.8 * normal(random), 0.02 * normal(random), 1.0;
    f[i] = phi.row(i).dot(theta) + 0.05 * normal(random);
    rls.update(phi.row(i).transpose(), f.segment<1>(i));
    if (i < 5) continue;
    const Eigen::VectorXd batch = phi.topRows(i + 1).colPivHouseholderQr().solve(f.head(i + 1));
    EXPECT_LT(element_wise(solve(rls), batch), 1e-9) << "after " << i + 1 << " samples";
  }
}

}  // namespace
}  // namespace tonus::impedance::test
