#include "services/formats/hdf5_export.hpp"

#include <array>
#include <limits>
#include <spdlog/fmt/fmt.h>

#include "services/contract/rig.hpp"
#include "services/core/partial_folder.hpp"
#include "services/formats/hdf5_columns.hpp"
#include "services/formats/hdf5_file.hpp"

namespace tonus::formats {
namespace {

using store::Session;
using store::SessionTrial;

/// Writes the attributes that describe `row` to the group.
template <typename Row>
Result<void> set_attributes(Hdf5File& file, const std::string& group,
                            std::span<const Attribute<Row>> attributes, const Row& row) {
  for (const auto& attribute : attributes) {
    TONUS_TRY(std::visit([&](const auto& value) { return file.set(group, attribute.name, value); },
                         attribute.value(row)));
  }
  return {};
}

Result<void> write_rig(Hdf5File& file, const Session& session) {
  if (session.descriptions.empty()) return {};
  const auto& d = session.descriptions.back().value;
  TONUS_TRY(file.make_group("/rig"));
  TONUS_TRY(set_attributes(file, "/rig", rig_attributes(), d));
  const std::string counts = d.kind() == v1::RIG_TWO_LINK ? "count/rad" : "count/" + d.displacement_unit();
  TONUS_TRY(file.write("/rig/link_lengths", d.link_lengths_m(), 0, "m", "inner and outer link"));
  TONUS_TRY(
      file.write("/rig/encoder_counts_per_unit", d.encoder_counts_per_unit(), 0, counts, "of each encoder"));
  TONUS_TRY(file.write("/rig/encoder_zero", d.encoder_zero_count(), 0, "count",
                       "at joint angle or displacement 0"));
  TONUS_TRY(file.write("/rig/encoder_sign", d.encoder_sign(), 0, "1", "+1 or -1"));
  TONUS_TRY(file.write("/rig/force_calibration", d.force_calibration_N_per_V(), 2, d.force_unit() + "/V",
                       "sensor's frame"));
  return file.write("/rig/force_offset", d.force_offset_V(), 0, "V", "at no force");
}

/// The datasets of one number a sample.
Result<void> write_sample_labels(Hdf5File& file, const std::string& group, const v1::TrialOutcome& outcome,
                                 std::span<const v1::RigSample> samples) {
  std::vector<double> time;
  std::vector<std::int64_t> acquisition;
  std::vector<std::uint8_t> phase;
  std::vector<std::uint8_t> flags;
  for (const v1::RigSample& sample : samples) {
    const auto after_onset =
        static_cast<std::int64_t>(outcome.first_sequence() + time.size() - outcome.onset_sequence());
    time.push_back(static_cast<double>(after_onset) / outcome.sample_rate_Hz());
    acquisition.push_back(sample.acquisition_ns());
    phase.push_back(sample.phase());
    flags.push_back(sample.flags());
  }
  TONUS_TRY(file.write(group + "/time", time, 0, "s", "from the onset of the perturbation"));
  TONUS_TRY(file.write(group + "/acquisition", std::span<const std::int64_t>(acquisition), "ns",
                       "rig's monotonic clock"));
  TONUS_TRY(file.write(group + "/phase", std::span<const std::uint8_t>(phase), "1",
                       "0 idle, 1 centring, 2 waiting, 3 bias ramp, 4 bias hold, 5 perturbing, 6 returning, "
                       "7 safe"));
  return file.write(group + "/flags", std::span<const std::uint8_t>(flags), "1",
                    "bit 0: force sensor saturated; bit 1: nothing measured");
}

/// The datasets of two numbers a sample.
Result<void> write_sample_pairs(Hdf5File& file, const std::string& group, const store::TrialRig& rig,
                                std::span<const v1::RigSample> samples) {
  constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();
  std::vector<EndpointSample> converted(samples.size());
  for (std::size_t i = 0; i < samples.size(); ++i) {
    if (!contract::flags_of(samples[i]).is_missing)
      converted[i] = convert(rig.geometry, rig.shoulder, store::raw_of(samples[i]));
  }
  for (const PairDataset& dataset : pair_datasets()) {
    std::vector<double> values(2 * samples.size(), kNothing);
    for (std::size_t i = 0; i < samples.size(); ++i) {
      if (contract::flags_of(samples[i]).is_missing) continue;
      const auto pair = dataset.values(samples[i], converted[i]);
      std::copy(pair.begin(), pair.end(), values.begin() + static_cast<std::ptrdiff_t>(2 * i));
    }
    TONUS_TRY(file.write(group + "/" + dataset.name, values, 2, dataset.unit(rig.description),
                         dataset.description));
  }
  return {};
}

Result<void> write_trial(Hdf5File& file, store::Store& store, const Session& session,
                         const SessionTrial& trial) {
  TONUS_TRY_ASSIGN(const auto rig, store::rig_in_force(session, trial));
  TONUS_TRY_ASSIGN(const auto found, store::read_trial_samples(store, trial));
  const std::string group = fmt::format("/trials/{:04}", trial.attempt);
  TONUS_TRY(file.make_group(group));
  const TrialGroup row{TrialRow(trial), store::why_not_counted(trial), found.absent};
  TONUS_TRY(set_attributes(file, group, trial_attributes(), row));
  TONUS_TRY(write_sample_labels(file, group, trial.outcome->value, found.samples));
  return write_sample_pairs(file, group, rig, found.samples);
}

/// A matrix and what is known of its elements' errors; one number of a one-axis rig.
Result<void> write_matrix(Hdf5File& file, const std::string& path, const v1::MatrixEstimate& m,
                          std::uint32_t axes, const std::string& unit, const std::string& what) {
  const auto write = [&](const std::string& suffix, const std::array<double, 4>& values,
                         const std::string& of) {
    const bool is_one = axes == 1;
    return file.write(path + suffix, std::span(values).first(is_one ? 1 : 4), is_one ? 1 : 2, unit,
                      of + what);
  };
  TONUS_TRY(write("", m.value(), ""));
  TONUS_TRY(write("_standard_error", m.standard_error(), "standard error of "));
  TONUS_TRY(write("_low95", m.low95(), "lower end of the 95 % interval of "));
  TONUS_TRY(write("_high95", m.high95(), "upper end of the 95 % interval of "));
  TONUS_TRY(write("_known_bias", m.known_bias(),
                  "bias of the method, simulated at this estimate (NaN: not simulated), of "));
  const bool is_one = axes == 1;
  TONUS_TRY(file.write(path + "_covariance", std::span(m.covariance()).first(is_one ? 1 : 16), is_one ? 1 : 4,
                       "(" + unit + ")^2", "covariance of the elements, row by row, of " + what));
  if (is_one || !m.has_ellipse()) return {};
  const std::array<double, 12> numbers{m.size(),
                                       m.size_low95(),
                                       m.size_high95(),
                                       m.shape(),
                                       m.shape_low95(),
                                       m.shape_high95(),
                                       m.orientation_deg(),
                                       m.orientation_low95_deg(),
                                       m.orientation_high95_deg(),
                                       m.curl(),
                                       m.curl_low95(),
                                       m.curl_high95()};
  return file.write(
      path + "_ellipse", numbers, 3, "see description",
      "rows: size (square of the matrix's unit), shape, orientation (deg), curl; columns: value, "
      "lower and upper end of its 95 % interval; of " +
          what);
}

Result<void> write_estimate(Hdf5File& file, const v1::Estimate& e, std::size_t number) {
  const std::string group = fmt::format("/estimates/{:03}", number);
  TONUS_TRY(file.make_group(group));
  TONUS_TRY(set_attributes(file, group, estimate_attributes(), e));
  const contract::MatrixUnits units = contract::matrix_units({e.displacement_unit(), e.force_unit()});
  TONUS_TRY(write_matrix(file, group + "/M", e.mass_kg(), e.axes(), units.mass, "mass"));
  TONUS_TRY(write_matrix(file, group + "/B", e.damping_Ns_per_m(), e.axes(), units.damping, "damping"));
  TONUS_TRY(write_matrix(file, group + "/K", e.stiffness_N_per_m(), e.axes(), units.stiffness, "stiffness"));
  const auto vector = [&](const std::string& name, const std::array<double, 2>& values,
                          const std::string& unit, const std::string& what) {
    return file.write(group + "/" + name, std::span(values).first(e.axes()), 0, unit, what);
  };
  TONUS_TRY(vector("X0", e.spring_centre_m().value(), e.displacement_unit(), "spring centre"));
  TONUS_TRY(vector("X0_standard_error", e.spring_centre_m().standard_error(), e.displacement_unit(),
                   "standard error of the spring centre"));
  const bool is_one = e.axes() == 1;
  TONUS_TRY(file.write(group + "/X0_covariance",
                       std::span(e.spring_centre_m().covariance()).first(is_one ? 1 : 4), is_one ? 1 : 2,
                       "(" + e.displacement_unit() + ")^2", "covariance of the spring centre"));
  return vector("sigma", e.sigma_N(), e.force_unit(), "root mean square fitting error");
}

Result<void> write_all(Hdf5File& file, store::Store& store, const Session& session,
                       const Progress& progress) {
  TONUS_TRY(set_attributes(file, "/", session_attributes(), session));
  TONUS_TRY(write_rig(file, session));
  std::uint64_t done = 0;
  for (const SessionTrial& trial : session.trials) {
    if (progress) progress(done++, session.trials.size());
    if (!trial.outcome || !trial.record || !trial.record->has_samples) continue;
    TONUS_TRY(write_trial(file, store, session, trial));
  }
  std::size_t number = 0;
  for (const auto& estimate : store::newest_estimates(session))
    TONUS_TRY(write_estimate(file, estimate, ++number));
  number = 0;
  for (const auto& note : session.notes) {
    const std::string group = fmt::format("/notes/{:03}", ++number);
    TONUS_TRY(file.make_group(group));
    TONUS_TRY(set_attributes(file, group, note_attributes(), NoteRow{session, note.value}));
  }
  if (progress) progress(session.trials.size(), session.trials.size());
  return file.finish();
}

}  // namespace

Result<void> export_hdf5(store::Store& store, const Session& session, const std::filesystem::path& path,
                         const Progress& progress) {
  TONUS_TRY_ASSIGN(auto partial, PartialFile::begin(path));
  TONUS_TRY_ASSIGN(auto file, Hdf5File::create(partial.path()));
  TONUS_TRY(write_all(file, store, session, progress));
  return partial.finish();
}

}  // namespace tonus::formats
