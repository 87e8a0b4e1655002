#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "services/formats/csv_table.hpp"
#include "services/mechanics/rig_geometry.hpp"
#include "services/store/session_reader.hpp"

#include <idl/estimate.h>
#include <idl/rig.h>

/// The columns of every CSV file of a session: one table each makes the header, the rows and columns.csv.
namespace tonus::formats {

[[nodiscard]] std::span<const CsvColumn<store::Session>> session_columns();

struct NoteRow {
  const store::Session& session;
  const v1::SessionNote& note;
};
[[nodiscard]] std::span<const CsvColumn<NoteRow>> note_columns();

/// Why an estimate is not ok: separated by "; "; empty: it is.
[[nodiscard]] std::string reasons_text(const v1::Estimate& estimate);

/// A trial with an outcome.
struct TrialRow {
  explicit TrialRow(const store::SessionTrial& of)
      : trial(of), outcome(of.outcome->value), program(outcome.program()) {
    if (trial.record) certificate = trial.record->certificate;
  }
  const store::SessionTrial& trial;
  const v1::TrialOutcome& outcome;
  const v1::TrialProgram& program;
  store::Certificate certificate;
};
[[nodiscard]] std::span<const CsvColumn<TrialRow>> trial_columns();

struct SampleRow {
  std::uint64_t sequence = 0;
  double time = 0.0;         ///< s from the onset.
  bool is_measured = false;  ///< False: only the above are filled in.
  v1::RigSample sample{};
  EndpointSample converted{};
};
[[nodiscard]] std::span<const CsvColumn<SampleRow>> sample_columns();

/// An element of a matrix or vector of an estimate.
struct EstimateRow {
  struct Spread {
    double standard_error = 0.0;
    double low95 = 0.0;
    double high95 = 0.0;
  };
  const v1::Estimate& estimate;
  std::string_view quantity;
  std::uint32_t row = 0;  ///< From 0, as the column.
  std::uint32_t column = 0;
  double value = 0.0;
  std::optional<Spread> spread;
  std::string unit;
};
[[nodiscard]] std::span<const CsvColumn<EstimateRow>> estimate_columns();

}  // namespace tonus::formats
