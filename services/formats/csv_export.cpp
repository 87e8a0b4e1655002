#include "services/formats/csv_export.hpp"

#include <cmath>
#include <limits>
#include <spdlog/fmt/fmt.h>
#include <string>

#include "services/contract/rig.hpp"
#include "services/core/partial_folder.hpp"
#include "services/core/text_file.hpp"
#include "services/formats/csv_columns.hpp"
#include "services/store/archived_trial.hpp"

namespace tonus::formats {
namespace {

namespace fs = std::filesystem;
using store::Session;
using store::SessionTrial;

std::string columns_text() {
  return "file,column,unit,meaning\n" + description_of("session.csv", session_columns()) +
         description_of("trials.csv", trial_columns()) + description_of("notes.csv", note_columns()) +
         description_of("estimates.csv", estimate_columns()) +
         description_of("samples/trial-N.csv", sample_columns());
}

Result<std::string> samples_text(store::Store& store, const Session& session, const SessionTrial& trial) {
  TONUS_TRY_ASSIGN(const auto rig, store::rig_in_force(session, trial));
  TONUS_TRY_ASSIGN(const auto found, store::read_trial_samples(store, trial));
  const auto& outcome = trial.outcome->value;
  std::string text = header_of(sample_columns());
  for (std::size_t i = 0; i < found.samples.size(); ++i) {
    SampleRow row;
    row.sequence = outcome.first_sequence() + i;
    const auto after_onset =
        static_cast<double>(static_cast<std::int64_t>(row.sequence - outcome.onset_sequence()));
    row.time = after_onset / outcome.sample_rate_Hz();
    row.sample = found.samples[i];
    row.is_measured = !contract::flags_of(row.sample).is_missing;
    if (row.is_measured) row.converted = convert(rig.geometry, rig.shoulder, store::raw_of(row.sample));
    text += line_of(sample_columns(), row);
  }
  return text;
}

std::string matrix_lines(const v1::Estimate& e, std::string_view name, const v1::MatrixEstimate& m,
                         const std::string& unit) {
  std::string text;
  for (std::uint32_t row = 0; row < e.axes(); ++row) {
    for (std::uint32_t column = 0; column < e.axes(); ++column) {
      const std::size_t i = row * 2 + column;
      text +=
          line_of(estimate_columns(),
                  EstimateRow{e, name, row, column, m.value()[i],
                              EstimateRow::Spread{m.standard_error()[i], m.low95()[i], m.high95()[i]}, unit});
    }
  }
  return text;
}

/// Size, shape, orientation and curl of a matrix's ellipse, and the covariances of its elements.
std::string further_lines(const v1::Estimate& e, const std::string& name, const v1::MatrixEstimate& m,
                          const std::string& unit) {
  constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
  std::string text;
  const auto add = [&](const char* what, double value, double low, double high, const std::string& of) {
    text += line_of(estimate_columns(),
                    EstimateRow{e, name + what, 0, 0, value, EstimateRow::Spread{kUnknown, low, high}, of});
  };
  if (e.axes() == 2 && m.has_ellipse()) {
    add("_size", m.size(), m.size_low95(), m.size_high95(), "(" + unit + ")^2");
    add("_shape", m.shape(), m.shape_low95(), m.shape_high95(), "");
    add("_orientation", m.orientation_deg(), m.orientation_low95_deg(), m.orientation_high95_deg(), "deg");
    add("_curl", m.curl(), m.curl_low95(), m.curl_high95(), "");
  }
  const std::string covariance = name + "_covariance";
  const std::string bias = name + "_known_bias";
  for (std::uint32_t i = 0; i < e.axes() * e.axes(); ++i) {
    for (std::uint32_t j = 0; j < e.axes() * e.axes(); ++j) {
      const double value = m.covariance()[std::size_t{4} * i + j];
      if (std::isfinite(value))
        text += line_of(estimate_columns(), EstimateRow{e, covariance, i, j, value, {}, "(" + unit + ")^2"});
    }
  }
  for (std::uint32_t row = 0; row < e.axes(); ++row) {
    for (std::uint32_t column = 0; column < e.axes(); ++column) {
      const double value = m.known_bias()[std::size_t{2} * row + column];
      if (std::isfinite(value))
        text += line_of(estimate_columns(), EstimateRow{e, bias, row, column, value, {}, unit});
    }
  }
  return text;
}

std::string estimate_lines(const v1::Estimate& e) {
  const contract::MatrixUnits units = contract::matrix_units({e.displacement_unit(), e.force_unit()});
  std::string text = matrix_lines(e, "M", e.mass_kg(), units.mass) +
                     matrix_lines(e, "B", e.damping_Ns_per_m(), units.damping) +
                     matrix_lines(e, "K", e.stiffness_N_per_m(), units.stiffness);
  const auto& centre = e.spring_centre_m();
  for (std::uint32_t i = 0; i < e.axes(); ++i) {
    const EstimateRow::Spread spread{centre.standard_error()[i], centre.low95()[i], centre.high95()[i]};
    text += line_of(estimate_columns(),
                    EstimateRow{e, "X0", i, 0, centre.value()[i], spread, e.displacement_unit()});
  }
  for (std::uint32_t i = 0; i < e.axes(); ++i)
    text += line_of(estimate_columns(), EstimateRow{e, "sigma", i, 0, e.sigma_N()[i], {}, e.force_unit()});
  const auto add = [&](std::string_view name, std::uint32_t axis, double value, const std::string& unit) {
    if (std::isfinite(value))
      text += line_of(estimate_columns(), EstimateRow{e, name, axis, 0, value, {}, unit});
  };
  add("explained_share", 0, e.explained_share(), "");
  for (std::uint32_t i = 0; i < e.axes(); ++i) {
    add("lag", i, e.lag_s()[i], "s");
    add("lag_low95", i, e.lag_low95_s()[i], "s");
    add("lag_high95", i, e.lag_high95_s()[i], "s");
  }
  if (e.band_high_Hz() > 0.0) {
    add("band_low", 0, e.band_low_Hz(), "Hz");
    add("band_high", 0, e.band_high_Hz(), "Hz");
  }
  for (std::uint32_t i = 0; i < e.axes(); ++i) {
    for (std::uint32_t j = 0; j < e.axes(); ++j) {
      const double value = centre.covariance()[std::size_t{2} * i + j];
      if (std::isfinite(value))
        text +=
            line_of(estimate_columns(),
                    EstimateRow{e, "X0_covariance", i, j, value, {}, "(" + e.displacement_unit() + ")^2"});
    }
  }
  text += further_lines(e, "M", e.mass_kg(), units.mass) +
          further_lines(e, "B", e.damping_Ns_per_m(), units.damping) +
          further_lines(e, "K", e.stiffness_N_per_m(), units.stiffness);
  add("independent_units", 0, e.independent_units(), "");
  for (const v1::ModelParameter& parameter : e.parameters()) {
    const EstimateRow::Spread spread{parameter.standard_error(), parameter.low95(), parameter.high95()};
    text += line_of(estimate_columns(),
                    EstimateRow{e, parameter.name(), 0, 0, parameter.value(), spread, parameter.unit()});
  }
  return text;
}

/// The tables in a folder that is there and empty.
Result<void> write_tables(store::Store& store, const Session& session, const fs::path& folder,
                          const Progress& progress) {
  std::error_code error;
  fs::create_directory(folder / "samples", error);
  if (error)
    return fail(ErrorCode::kIo, fmt::format("'{}': cannot be created: {}", folder.string(), error.message()));
  std::string trials = header_of(trial_columns());
  std::uint64_t done = 0;
  for (const SessionTrial& trial : session.trials) {
    if (progress) progress(done++, session.trials.size());
    if (!trial.outcome) continue;
    trials += line_of(trial_columns(), TrialRow(trial));
    if (!trial.record || !trial.record->has_samples) continue;
    TONUS_TRY_ASSIGN(const auto text, samples_text(store, session, trial));
    TONUS_TRY(create_text_file(folder / "samples" / fmt::format("trial-{}.csv", trial.attempt), text));
  }
  TONUS_TRY(create_text_file(folder / "session.csv",
                             header_of(session_columns()) + line_of(session_columns(), session)));
  TONUS_TRY(create_text_file(folder / "trials.csv", trials));
  std::string notes = header_of(note_columns());
  for (const auto& note : session.notes) notes += line_of(note_columns(), NoteRow{session, note.value});
  TONUS_TRY(create_text_file(folder / "notes.csv", notes));
  std::string estimates = header_of(estimate_columns());
  for (const auto& estimate : store::newest_estimates(session)) estimates += estimate_lines(estimate);
  TONUS_TRY(create_text_file(folder / "estimates.csv", estimates));
  TONUS_TRY(create_text_file(folder / "columns.csv", columns_text()));
  if (progress) progress(session.trials.size(), session.trials.size());
  return {};
}

}  // namespace

Result<void> export_csv(store::Store& store, const Session& session, const fs::path& folder,
                        const FurtherFiles& further, const Progress& progress) {
  TONUS_TRY_ASSIGN(auto partial, PartialFolder::begin(folder));
  TONUS_TRY(write_tables(store, session, partial.path(), progress));
  for (const auto& [name, text] : further) TONUS_TRY(create_text_file(partial.path() / name, text));
  return partial.finish();
}

}  // namespace tonus::formats
