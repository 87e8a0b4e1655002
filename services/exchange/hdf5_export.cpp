#include "services/exchange/hdf5_export.hpp"

#include <limits>
#include <spdlog/fmt/fmt.h>

#include "analysis_service/identification/wire.hpp"
#include "services/exchange/hdf5_file.hpp"
#include "services/exchange/session_recordings.hpp"
#include "services/exchange/trial_data.hpp"

namespace tonus::exchange {
namespace {

using archive::Session;
using archive::SessionTrial;

/// Writes to one group, keeping the first error: what follows it is not done.
class Group {
 public:
  Group(Hdf5File& file, std::string path, bool is_root = false) : file_(file), path_(std::move(path)) {
    if (!is_root) outcome_ = file_.make_group(path_);
  }
  template <typename Value>
  Group& set(const std::string& name, const Value& value) {
    if (!outcome_) return *this;
    if constexpr (std::is_floating_point_v<Value>)
      outcome_ = file_.set(path_, name, static_cast<double>(value));
    else if constexpr (std::is_integral_v<Value> || std::is_enum_v<Value>)
      outcome_ = file_.set(path_, name, static_cast<std::int64_t>(value));
    else
      outcome_ = file_.set(path_, name, std::string(value));
    return *this;
  }
  Group& table(const std::string& name, std::span<const double> values, std::size_t columns,
               const std::string& units, const std::string& description) {
    if (outcome_) outcome_ = file_.write(path_ + "/" + name, values, columns, units, description);
    return *this;
  }
  template <typename Value>
  Group& column(const std::string& name, const std::vector<Value>& values, const std::string& units,
                const std::string& description) {
    if (outcome_)
      outcome_ = file_.write(path_ + "/" + name, std::span<const Value>(values), units, description);
    return *this;
  }
  [[nodiscard]] Result<void> outcome() const { return outcome_; }

 private:
  Hdf5File& file_;
  std::string path_;
  Result<void> outcome_;
};

Result<void> write_root(Hdf5File& file, const Session& session) {
  Group root(file, "/", true);
  root.set("format", "tonus session").set("format_version", 1);
  root.set("session_id", to_hex(session.record.session)).set("rig_id", to_hex(session.record.rig));
  root.set("subject", session.record.subject).set("protocol_name", session.record.protocol_name);
  root.set("protocol_toml", session.plan.protocol_toml()).set("seed", session.record.seed);
  root.set("started_at", session.record.started_at).set("software_version", session.record.software_version);
  return root.outcome();
}

Result<void> write_rig(Hdf5File& file, const Session& session) {
  if (session.descriptions.empty()) return {};
  const auto& d = session.descriptions.back().value;
  Group rig(file, "/rig");
  rig.set("name", d.name()).set("driver", d.driver()).set("kind", d.kind());
  rig.set("displacement_unit", d.displacement_unit()).set("force_unit", d.force_unit());
  rig.set("force_sensor_angle_rad", d.force_sensor_angle_rad())
      .set("force_saturation_V", d.force_saturation_V());
  rig.set("handle_mass_kg", d.handle_mass_kg()).set("sample_rate_Hz", d.sample_rate_Hz());
  rig.set("calibrated_at", d.calibrated_at()).set("calibrated_by", d.calibrated_by());
  const std::string displacement =
      d.kind() == v1::RIG_TWO_LINK ? "count/rad" : "count/" + d.displacement_unit();
  rig.table("link_lengths", d.link_lengths_m(), 0, "m", "inner and outer link");
  rig.table("encoder_counts_per_unit", d.encoder_counts_per_unit(), 0, displacement, "of each encoder");
  rig.table("encoder_zero", d.encoder_zero_count(), 0, "count", "at joint angle or displacement 0");
  rig.table("encoder_sign", d.encoder_sign(), 0, "1", "+1 or -1");
  rig.table("force_calibration", d.force_calibration_N_per_V(), 2, d.force_unit() + "/V", "sensor's frame");
  rig.table("force_offset", d.force_offset_V(), 0, "V", "at no force");
  return rig.outcome();
}

Result<void> write_trial(Hdf5File& file, const Session& session, const SessionTrial& trial,
                         const TrialSamples& found) {
  const auto description = description_of(session, trial);
  if (!description) return description.error();
  const auto rig = identification::from_wire(*description);
  if (!rig) return rig.error();
  const auto& outcome = trial.outcome->value;
  const auto& program = outcome.program();
  const ShoulderPose shoulder = shoulder_of(trial);
  const std::size_t n = found.samples.size();
  constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();
  std::vector<double> time(n);
  std::vector<std::int64_t> acquisition(n);
  std::vector<std::uint8_t> phase(n);
  std::vector<std::uint8_t> flags(n);
  std::vector<double> encoder(2 * n, kNothing);
  std::vector<double> volts(2 * n, kNothing);
  std::vector<double> endpoint(2 * n, kNothing);
  std::vector<double> force(2 * n, kNothing);
  std::vector<double> commanded(2 * n, kNothing);
  for (std::size_t i = 0; i < n; ++i) {
    const v1::RigSample& sample = found.samples[i];
    const auto after_onset =
        static_cast<std::int64_t>(outcome.first_sequence() + i - outcome.onset_sequence());
    time[i] = static_cast<double>(after_onset) / outcome.sample_rate_Hz();
    acquisition[i] = sample.acquisition_ns();
    phase[i] = sample.phase();
    flags[i] = sample.flags();
    if ((sample.flags() & kNotMeasured) != 0) continue;
    const EndpointSample converted =
        convert(*rig, shoulder, {sample.acquisition_ns(), sample.encoder_count(), sample.force_V()});
    for (std::size_t axis = 0; axis < 2; ++axis) {
      const auto component = static_cast<Eigen::Index>(axis);
      encoder[2 * i + axis] = sample.encoder_count()[axis];
      volts[2 * i + axis] = sample.force_V()[axis];
      endpoint[2 * i + axis] = converted.p_SE[component];
      force[2 * i + axis] = converted.f_S[component];
      commanded[2 * i + axis] = sample.commanded_m()[axis];
    }
  }
  Group group(file, fmt::format("/trials/{:04}", trial.attempt));
  group.set("attempt", trial.attempt).set("posture", program.posture()).set("set", program.set_number());
  group.set("posture_x_m", program.posture_m()[0]).set("posture_y_m", program.posture_m()[1]);
  group.set("direction_deg", program.direction_deg()).set("amplitude_m", program.amplitude_m());
  group.set("rise_time_s", program.rise_time_s()).set("hold_s", program.hold_s());
  group.set("bias_x_N", program.bias_N()[0]).set("bias_y_N", program.bias_N()[1]);
  group.set("instruction", program.instruction()).set("end", outcome.end()).set("detail", outcome.detail());
  group.set("sample_rate_Hz", outcome.sample_rate_Hz()).set("epoch", outcome.epoch());
  group.set("first_sequence", outcome.first_sequence()).set("onset_sequence", outcome.onset_sequence());
  const std::string reason = why_not_counted(trial);
  group.set("is_valid", reason.empty()).set("reason", reason);
  group.set("missing_samples", found.absent);
  const std::string& unit = description->displacement_unit();
  group.table("time", time, 0, "s", "from the onset of the perturbation");
  group.column("acquisition", acquisition, "ns", "rig's monotonic clock");
  group.column("phase", phase, "1",
               "0 idle, 1 centring, 2 waiting, 3 bias ramp, 4 bias hold, 5 perturbing, 6 returning, 7 safe");
  group.column("flags", flags, "1", "bit 0: force sensor saturated; bit 1: nothing measured");
  group.table("encoder", encoder, 2, "count", "raw");
  group.table("force_raw", volts, 2, "V", "raw, in the sensor's frame");
  group.table("endpoint", endpoint, 2, unit, "in the shoulder frame; one-axis rigs: displacement");
  group.table("force", force, 2, description->force_unit(), "on the arm, in the shoulder frame");
  group.table("commanded", commanded, 2, unit, "commanded displacement from the posture, shoulder frame");
  return group.outcome();
}

Result<void> write_estimate(Hdf5File& file, const v1::Estimate& e, std::size_t number) {
  Group group(file, fmt::format("/estimates/{:03}", number));
  group.set("posture", e.posture()).set("set", e.set_number()).set("instruction", e.instruction());
  group.set("bias_x_N", e.bias_N()[0]).set("bias_y_N", e.bias_N()[1]);
  group.set("method", e.method()).set("model", e.model()).set("status", e.status());
  group.set("trials_used", e.trials_used()).set("samples", e.samples()).set("window_s", e.window_s());
  group.set("condition_number", e.condition_number()).set("degrees_of_freedom", e.degrees_of_freedom());
  group.set("natural_frequency_Hz", e.natural_frequency_Hz()).set("damping_ratio", e.damping_ratio());
  group.set("cutoff_Hz", e.cutoff_Hz());
  const bool is_turning = e.displacement_unit() == "rad";
  const auto matrix = [&](const std::string& name, const v1::MatrixEstimate& m, const std::string& unit,
                          const std::string& what) {
    const auto write = [&](const std::string& suffix, const std::array<double, 4>& values,
                           const std::string& of) {
      if (e.axes() == 1)
        group.table(name + suffix, std::span(values).first(1), 1, unit, of + what);
      else
        group.table(name + suffix, values, 2, unit, of + what);
    };
    write("", m.value(), "");
    write("_standard_error", m.standard_error(), "standard error of ");
    write("_low95", m.low95(), "lower end of the 95 % interval of ");
    write("_high95", m.high95(), "upper end of the 95 % interval of ");
  };
  matrix("M", e.mass_kg(), is_turning ? "kg m2" : "kg", "mass");
  matrix("B", e.damping_Ns_per_m(), is_turning ? "N m s/rad" : "N s/m", "damping");
  matrix("K", e.stiffness_N_per_m(), is_turning ? "N m/rad" : "N/m", "stiffness");
  const auto axes = static_cast<std::size_t>(e.axes());
  group.table("X0", std::span(e.spring_centre_m().value()).first(axes), 0, e.displacement_unit(),
              "spring centre");
  group.table("X0_standard_error", std::span(e.spring_centre_m().standard_error()).first(axes), 0,
              e.displacement_unit(), "standard error of the spring centre");
  group.table("sigma", std::span(e.sigma_N()).first(axes), 0, e.force_unit(),
              "root mean square fitting error");
  return group.outcome();
}

Result<void> write_all(Hdf5File& file, archive::Store& store, const Session& session,
                       const Progress& progress) {
  if (auto done = write_root(file, session); !done) return done;
  if (auto done = write_rig(file, session); !done) return done;
  std::uint64_t done_trials = 0;
  for (const SessionTrial& trial : session.trials) {
    if (progress) progress(done_trials++, session.trials.size());
    if (!trial.outcome || !trial.record || !trial.record->has_samples) continue;
    const auto found = read_all_samples(store, trial);
    if (!found) return found.error();
    if (auto done = write_trial(file, session, trial, *found); !done) return done;
  }
  std::size_t number = 0;
  for (const auto& estimate : archive::newest_estimates(session)) {
    if (auto done = write_estimate(file, estimate, ++number); !done) return done;
  }
  if (progress) progress(session.trials.size(), session.trials.size());
  return file.finish();
}

}  // namespace

Result<void> export_hdf5(archive::Store& store, const Session& session, const std::filesystem::path& path,
                         const Progress& progress) {
  auto file = Hdf5File::create(path);
  if (!file) return file.error();
  auto written = write_all(*file, store, session, progress);
  if (!written) {
    std::error_code ignored;
    std::filesystem::remove(path, ignored);
  }
  return written;
}

}  // namespace tonus::exchange
