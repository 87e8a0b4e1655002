#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <vector>

#include "analysis_service/spectral/record.hpp"

namespace tonus::spectral {

/// Pieces of a record in which the input is on: those whose power exceeds 0.05 of the mean of the strongest
/// twentieth (three at least). `power`: a row a piece, a column an axis; each axis counts alike. By ascending
/// index.
[[nodiscard]] std::vector<std::size_t> pieces_with_input(const Eigen::MatrixXd& power);

/// Rows of all records in which the input is on, from the power of motion in about 120 pieces.
[[nodiscard]] Eigen::Index rows_with_input(std::span<const Record> records);

}  // namespace tonus::spectral
