#include "services/exchange/csv_export.hpp"

#include <algorithm>
#include <array>
#include <span>
#include <spdlog/fmt/fmt.h>
#include <string>
#include <string_view>
#include <vector>

#include "analysis_service/identification/wire.hpp"
#include "services/core/text_file.hpp"
#include "services/exchange/session_recordings.hpp"
#include "services/exchange/trial_data.hpp"
#include "services/recording/number_text.hpp"

namespace tonus::exchange {
namespace {

namespace fs = std::filesystem;
using archive::Session;
using archive::SessionTrial;

struct ColumnText {
  std::string_view name;
  std::string_view unit;
  std::string_view meaning;
};

constexpr std::array kTrialColumns{
    ColumnText{"attempt", "", "number of the trial, unique in the session"},
    ColumnText{"planned_index", "", "place in the plan, from 0; repeats of a rejected trial keep it"},
    ColumnText{"posture", "", "name of the posture"},
    ColumnText{"set", "", "number of the set"},
    ColumnText{"x_m", "m", "hand's place, x in the shoulder frame"},
    ColumnText{"y_m", "m", "hand's place, y in the shoulder frame"},
    ColumnText{"direction_deg", "deg",
               "of the perturbation, counter-clockwise from the shoulder frame's x axis"},
    ColumnText{"amplitude_m", "m", "of the commanded displacement"},
    ColumnText{"rise_time_s", "s", "of the commanded displacement"},
    ColumnText{"hold_s", "s", "from onset to the end of the perturbation"},
    ColumnText{"wait_s", "s", "at rest before the onset"},
    ColumnText{"bias_x_N", "N", "bias force on the arm, x in the shoulder frame"},
    ColumnText{"bias_y_N", "N", "bias force on the arm, y in the shoulder frame"},
    ColumnText{"instruction", "", "what the subject was told; empty: hold still"},
    ColumnText{"end", "",
               "how the rig ended it: 0 completed, 1 aborted, 2 faulted, 3 not centred, 4 bias not "
               "reached, 5 refused, 6 broken off"},
    ColumnText{"valid", "", "true, false; empty: no verdict"},
    ColumnText{"reason", "", "why it does not count"},
    ColumnText{"epoch", "ns", "start of the rig's agent, UTC; names the stream of samples"},
    ColumnText{"first_sequence", "", "number of the first sample"},
    ColumnText{"onset_sequence", "", "number of the first sample of the perturbation"},
    ColumnText{"last_sequence", "", "number of the last sample"},
    ColumnText{"sample_rate_Hz", "Hz", "samples a second"},
    ColumnText{"expected_samples", "", "of the certificate"},
    ColumnText{"received_samples", "", "of the certificate"},
    ColumnText{"resent_samples", "", "of the certificate"},
    ColumnText{"duplicated_samples", "", "of the certificate"},
    ColumnText{"missing_samples", "", "of the certificate"},
};

constexpr std::array kSampleColumns{
    ColumnText{"sequence", "", "number of the sample in its stream"},
    ColumnText{"time_s", "s", "from the onset of the perturbation, by the sample's number and rate"},
    ColumnText{"acquisition_ns", "ns", "rig's monotonic clock"},
    ColumnText{"phase", "",
               "0 idle, 1 centring, 2 waiting, 3 bias ramp, 4 bias hold, 5 perturbing, 6 returning, "
               "7 safe"},
    ColumnText{"q1_count", "count", "encoder of the inner joint, raw (or converted displacement)"},
    ColumnText{"q2_count", "count", "encoder of the outer joint, raw"},
    ColumnText{"f1_V", "V", "force sensor, first axis, raw (or converted force)"},
    ColumnText{"f2_V", "V", "force sensor, second axis, raw"},
    ColumnText{"x_m", "m",
               "endpoint in the shoulder frame, or the displacement of a one-axis rig in its unit"},
    ColumnText{"y_m", "m", "endpoint in the shoulder frame"},
    ColumnText{"fx_N", "N",
               "force on the arm in the shoulder frame, or the force of a one-axis rig in its unit"},
    ColumnText{"fy_N", "N", "force on the arm in the shoulder frame"},
    ColumnText{"xc_m", "m", "commanded displacement in the shoulder frame, from the posture"},
    ColumnText{"yc_m", "m", "commanded displacement in the shoulder frame"},
    ColumnText{"saturated", "", "1: the force sensor was at its end stop"},
};

constexpr std::array kEstimateColumns{
    ColumnText{"posture", "", "name of the posture"},
    ColumnText{"set", "", "number of the set; 0: all"},
    ColumnText{"bias_x_N", "N", "bias force on the arm, x"},
    ColumnText{"bias_y_N", "N", "bias force on the arm, y"},
    ColumnText{"instruction", "", "what the subject was told"},
    ColumnText{"method", "", "of identification"},
    ColumnText{"model", "", "of the force"},
    ColumnText{"status", "", "0 ok, 1 undetermined, 2 suspect"},
    ColumnText{"trials_used", "", "trials behind the estimate"},
    ColumnText{"quantity", "", "M mass, B damping, K stiffness, X0 spring centre, sigma fitting error"},
    ColumnText{"row", "", "of the element, from 1"},
    ColumnText{"column", "", "of the element, from 1"},
    ColumnText{"value", "see unit", "the estimate"},
    ColumnText{"standard_error", "see unit", "of the value"},
    ColumnText{"low95", "see unit", "lower end of its 95 % interval"},
    ColumnText{"high95", "see unit", "upper end of its 95 % interval"},
    ColumnText{"unit", "", "of value, standard_error, low95 and high95"},
};

/// One line of cells.
class Line {
 public:
  Line& text(std::string_view cell) {
    separate();
    if (cell.find_first_of(",\"\r\n") == std::string_view::npos) {
      line_ += cell;
      return *this;
    }
    line_ += '"';
    for (const char c : cell) {
      if (c == '"') line_ += '"';
      line_ += c;
    }
    line_ += '"';
    return *this;
  }
  Line& number(double value) {
    separate();
    recording::append_number(line_, value);
    return *this;
  }
  template <typename Integer>
  Line& whole(Integer value) {
    separate();
    line_ += fmt::format("{}", value);
    return *this;
  }
  Line& nothing(std::size_t cells = 1) {
    for (; cells > 0; --cells) separate();
    return *this;
  }
  std::string end() {
    is_first_ = true;
    line_ += '\n';
    return std::exchange(line_, {});
  }

 private:
  void separate() {
    if (!is_first_) line_ += ',';
    is_first_ = false;
  }
  std::string line_;
  bool is_first_ = true;
};

std::string header(std::span<const ColumnText> columns) {
  Line line;
  for (const auto& column : columns) line.text(column.name);
  return line.end();
}

std::string columns_text() {
  std::string text = "file,column,unit,meaning\n";
  const auto describe = [&text](std::string_view file, std::span<const ColumnText> columns) {
    for (const auto& column : columns)
      text += Line().text(file).text(column.name).text(column.unit).text(column.meaning).end();
  };
  describe("trials.csv", kTrialColumns);
  describe("estimates.csv", kEstimateColumns);
  describe("samples/trial-N.csv", kSampleColumns);
  return text;
}

std::string trial_line(const SessionTrial& trial) {
  const auto& outcome = trial.outcome->value;
  const auto& program = outcome.program();
  Line line;
  line.whole(program.attempt())
      .whole(program.planned_index())
      .text(program.posture())
      .whole(program.set_number());
  line.number(program.posture_m()[0]).number(program.posture_m()[1]);
  line.number(program.direction_deg()).number(program.amplitude_m()).number(program.rise_time_s());
  line.number(program.hold_s()).number(program.wait_s());
  line.number(program.bias_N()[0]).number(program.bias_N()[1]).text(program.instruction());
  line.whole(static_cast<std::uint32_t>(outcome.end()));
  line.text(!trial.verdict ? "" : trial.verdict->value.is_valid() ? "true" : "false");
  line.text(trial.verdict ? why_not_counted(trial) : std::string());
  line.whole(outcome.epoch()).whole(outcome.first_sequence()).whole(outcome.onset_sequence());
  line.whole(outcome.last_sequence()).number(outcome.sample_rate_Hz());
  const archive::Certificate counts = trial.record ? trial.record->certificate : archive::Certificate{};
  line.whole(counts.expected).whole(counts.received).whole(counts.resent).whole(counts.duplicated);
  return line.whole(counts.missing).end();
}

Result<std::string> samples_text(const Session& session, const SessionTrial& trial,
                                 const TrialSamples& found) {
  const auto description = description_of(session, trial);
  if (!description) return description.error();
  const auto rig = identification::from_wire(*description);
  if (!rig) return rig.error();
  const ShoulderPose shoulder = shoulder_of(trial);
  const auto& outcome = trial.outcome->value;
  std::string text = header(kSampleColumns);
  Line line;
  for (std::size_t i = 0; i < found.samples.size(); ++i) {
    const v1::RigSample& sample = found.samples[i];
    const std::uint64_t sequence = outcome.first_sequence() + i;
    const auto after_onset =
        static_cast<double>(static_cast<std::int64_t>(sequence - outcome.onset_sequence()));
    line.whole(sequence).number(after_onset / outcome.sample_rate_Hz());
    if ((sample.flags() & kNotMeasured) != 0) {
      text += line.nothing(kSampleColumns.size() - 2).end();
      continue;
    }
    line.whole(sample.acquisition_ns()).whole(static_cast<unsigned>(sample.phase()));
    const RawSample raw{sample.acquisition_ns(), sample.encoder_count(), sample.force_V()};
    const EndpointSample converted = convert(*rig, shoulder, raw);
    line.number(raw.encoder_count[0])
        .number(raw.encoder_count[1])
        .number(raw.force_V[0])
        .number(raw.force_V[1]);
    line.number(converted.p_SE[0])
        .number(converted.p_SE[1])
        .number(converted.f_S[0])
        .number(converted.f_S[1]);
    line.number(sample.commanded_m()[0]).number(sample.commanded_m()[1]);
    text += line.whole((sample.flags() & kSaturated) != 0 ? 1 : 0).end();
  }
  return text;
}

struct Units {
  std::string mass = "kg";
  std::string damping = "N s/m";
  std::string stiffness = "N/m";
};

Units units_of(const v1::Estimate& estimate) {
  if (estimate.displacement_unit() == "rad") return {"kg m2", "N m s/rad", "N m/rad"};
  return {};
}

std::string estimate_lines(const v1::Estimate& e) {
  std::string text;
  const auto begin = [&e](Line& line) {
    line.text(e.posture()).whole(e.set_number()).number(e.bias_N()[0]).number(e.bias_N()[1]);
    line.text(e.instruction()).text(e.method()).text(e.model()).whole(static_cast<std::uint32_t>(e.status()));
    line.whole(e.trials_used());
  };
  const auto matrix = [&](const char* name, const v1::MatrixEstimate& m, const std::string& unit) {
    for (std::uint32_t row = 0; row < e.axes(); ++row) {
      for (std::uint32_t column = 0; column < e.axes(); ++column) {
        const std::size_t i = row * 2 + column;
        Line line;
        begin(line);
        line.text(name).whole(row + 1).whole(column + 1).number(m.value()[i]).number(m.standard_error()[i]);
        text += line.number(m.low95()[i]).number(m.high95()[i]).text(unit).end();
      }
    }
  };
  const Units units = units_of(e);
  matrix("M", e.mass_kg(), units.mass);
  matrix("B", e.damping_Ns_per_m(), units.damping);
  matrix("K", e.stiffness_N_per_m(), units.stiffness);
  const auto& centre = e.spring_centre_m();
  for (std::uint32_t axis = 0; axis < e.axes(); ++axis) {
    Line line;
    begin(line);
    line.text("X0")
        .whole(axis + 1)
        .whole(1)
        .number(centre.value()[axis])
        .number(centre.standard_error()[axis]);
    text += line.number(centre.low95()[axis]).number(centre.high95()[axis]).text(e.displacement_unit()).end();
  }
  for (std::uint32_t axis = 0; axis < e.axes(); ++axis) {
    Line line;
    begin(line);
    text += line.text("sigma")
                .whole(axis + 1)
                .whole(1)
                .number(e.sigma_N()[axis])
                .nothing(3)
                .text(e.force_unit())
                .end();
  }
  return text;
}

}  // namespace

Result<void> export_csv(archive::Store& store, const Session& session, const fs::path& folder,
                        const Progress& progress) {
  std::error_code error;
  if (fs::exists(folder, error)) {
    return fail(ErrorCode::kAlreadyExists,
                fmt::format("'{}': is there already: a path that does not exist is needed", folder.string()));
  }
  fs::create_directories(folder / "samples", error);
  if (error)
    return fail(ErrorCode::kIo, fmt::format("'{}': cannot be made: {}", folder.string(), error.message()));

  std::string trials = header(kTrialColumns);
  std::uint64_t done = 0;
  for (const SessionTrial& trial : session.trials) {
    if (progress) progress(done++, session.trials.size());
    if (!trial.outcome) continue;
    trials += trial_line(trial);
    if (!trial.record || !trial.record->has_samples) continue;
    const auto found = read_all_samples(store, trial);
    if (!found) return found.error();
    const auto text = samples_text(session, trial, *found);
    if (!text) return text.error();
    const fs::path file = folder / "samples" / fmt::format("trial-{}.csv", trial.attempt);
    if (auto written = write_text_file(file, *text); !written) return written;
  }
  std::string estimates = header(kEstimateColumns);
  for (const auto& estimate : archive::newest_estimates(session)) estimates += estimate_lines(estimate);
  const std::pair<const char*, std::string> files[] = {{"trials.csv", std::move(trials)},
                                                       {"estimates.csv", std::move(estimates)},
                                                       {"columns.csv", columns_text()}};
  for (const auto& [name, text] : files) {
    if (auto written = write_text_file(folder / name, text); !written) return written;
  }
  if (progress) progress(session.trials.size(), session.trials.size());
  return {};
}

}  // namespace tonus::exchange
