#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <vector>

#include "analysis_service/identification/measured_trial.hpp"

namespace tonus::identification {

/// Rows by sequence number, in whatever order they came: disjoint runs without gaps, each in one piece.
/// Memory follows the rows held, not the numbers they bear. The first row that comes with a number stays; a
/// repeat is left out. Not for use by several threads.
class RowStore {
 public:
  /// Takes the rows that are new; returns how many those were.
  std::size_t add(std::uint64_t first_sequence, std::span<const Row> rows);

  /// Frees the rows of a range.
  void erase(const SequenceRange& range);

  /// What of the range is not here, ascending.
  [[nodiscard]] std::vector<SequenceRange> missing(const SequenceRange& range) const;
  [[nodiscard]] bool holds(const SequenceRange& range) const;

  /// Rows from this number up to the first gap; empty where the number itself is not here. Valid until the
  /// next change.
  [[nodiscard]] std::span<const Row> from(std::uint64_t sequence) const;

  /// Copy of a range, with a row that is marked as missing for each that is not here.
  [[nodiscard]] std::vector<Row> copy(const SequenceRange& range) const;

  /// Runs held, ascending.
  [[nodiscard]] std::vector<SequenceRange> runs() const;
  [[nodiscard]] std::size_t rows() const { return rows_; }

 private:
  using Runs =
      std::map<std::uint64_t, std::vector<Row>>;  // by the first number; never empty, never adjoining

  void insert_run(std::uint64_t first_sequence, std::span<const Row> rows);
  [[nodiscard]] static std::uint64_t end_of(const Runs::value_type& run) {
    return run.first + run.second.size();
  }
  /// The first run that ends after `sequence`.
  [[nodiscard]] Runs::const_iterator run_reaching(std::uint64_t sequence) const;

  Runs runs_;
  std::size_t rows_ = 0;
};

}  // namespace tonus::identification
