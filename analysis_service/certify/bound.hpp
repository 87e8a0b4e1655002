#pragma once

#include <Eigen/Core>
#include <vector>

#include "analysis_service/certify/drawn_session.hpp"

namespace tonus::certify {

/// Cramer-Rao bound of the parameters theta of F = regressors theta + e, e Gaussian of covariance Gamma:
/// inverse of the sum over trials of X' Gamma^-1 X. `axes_regressors` of each trial act on every axis with
/// coefficients of their own (rows x q); Gamma is (axes rows) square, the rows of the first axis first.
/// Returns the covariance of vec(theta), (axes q) square.
[[nodiscard]] Eigen::MatrixXd cramer_rao(const std::vector<Eigen::MatrixXd>& regressors,
                                         const Eigen::MatrixXd& gamma, int axes);

/// Standard deviation that no unbiased estimate of M, B, K (in that order, column by column) can go below in
/// this condition, with one offset common to the trials.
///
/// Law: with the motion an unknown of its own at every sample, what carries the parameters is e = F - Z x
/// alone (Z the arm): its mean has the regressors of the motion that the command makes, and its covariance is
/// that of the force noise, of the arm's own force, and of the displacement noise seen through Z. All of
/// these are stationary; Gamma is the Toeplitz matrix of their joint spectrum at the sampling rate. The bound
/// knows these spectra, and counts nothing that the disturbance itself moves. Encoder steps count as white
/// noise of step^2/12.
[[nodiscard]] Eigen::VectorXd bound_of(const Truth& truth, const Design& design, const Setting& setting);

}  // namespace tonus::certify
