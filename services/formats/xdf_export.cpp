#include "services/formats/xdf_export.hpp"

#include <limits>
#include <optional>
#include <set>
#include <spdlog/fmt/fmt.h>

#include "services/contract/names.hpp"
#include "services/contract/rig.hpp"
#include "services/core/partial_folder.hpp"
#include "services/formats/hdf5_columns.hpp"
#include "services/formats/xdf_file.hpp"

namespace tonus::formats {
namespace {

using store::Session;
using store::SessionTrial;

constexpr std::uint32_t kMotion = 1;
constexpr std::uint32_t kEvents = 2;

/// What has been written of a stream.
struct Written {
  std::uint64_t samples = 0;
  double first = 0.0;  ///< s
  double last = 0.0;

  void add(double time) {
    if (samples++ == 0) first = time;
    last = time;
  }
};

/// The samples of a trial that were measured.
struct Measured {
  std::vector<double> times;
  std::vector<double> values;  ///< Row-major.
};

double seconds(std::int64_t ns) { return static_cast<double>(ns) * 1e-9; }

std::string channel_text(const std::string& label, const std::string& unit, const std::string& description) {
  return fmt::format("<channel><label>{}</label><unit>{}</unit><description>{}</description></channel>",
                     xml_text(label), xml_text(unit), xml_text(description));
}

/// Of the stream "tonus motion" or "tonus events".
std::string header_text(const Session& session, const char* of, const char* type, const char* format,
                        std::size_t channels, double rate, const std::string& description) {
  return fmt::format(
      "<?xml version=\"1.0\"?><info><name>tonus {}</name><type>{}</type><channel_count>{}</channel_count>"
      "<nominal_srate>{}</nominal_srate><channel_format>{}</channel_format><source_id>tonus-{}-{}</source_id>"
      "<version>1.0</version><created_at>0</created_at><session_id>{}</session_id><hostname></hostname>"
      "<desc><subject>{}</subject><operator>{}</operator><study>{}</study><pilot>{}</pilot>"
      "<protocol>{}</protocol><started_at>{}</started_at>{}</desc></info>",
      of, type, channels, rate, format, to_hex(session.record.session), of, to_hex(session.record.session),
      xml_text(session.record.subject), xml_text(session.plan.operator_name()),
      xml_text(session.plan.study()), session.plan.is_pilot(), xml_text(session.record.protocol_name),
      xml_text(session.record.started_at), description);
}

std::string motion_header(const Session& session, const v1::RigDescription& rig, double rate) {
  std::string channels;
  for (const PairDataset& dataset : pair_datasets()) {
    for (const int axis : {1, 2}) {
      channels +=
          channel_text(fmt::format("{}_{}", dataset.name, axis), dataset.unit(rig), dataset.description);
    }
  }
  const char* clock = rig.moves_nothing_real()
                          ? "of the simulation or replay, from 0; it compares with no other clock"
                          : "monotonic, of the rig's host";
  return header_text(session, "motion", "MoCap", "double64", 2 * pair_datasets().size(), rate,
                     fmt::format("<clock>{}</clock><channels>{}</channels>", clock, channels));
}

std::string footer_text(const Written& written, const std::string& offsets) {
  return fmt::format(
      "<?xml version=\"1.0\"?><info><first_timestamp>{}</first_timestamp><last_timestamp>{}</last_timestamp>"
      "<sample_count>{}</sample_count><clock_offsets>{}</clock_offsets></info>",
      written.first, written.last, written.samples, offsets);
}

Measured measured(const store::TrialRig& rig, std::span<const v1::RigSample> samples) {
  Measured found;
  for (const v1::RigSample& sample : samples) {
    if (contract::flags_of(sample).is_missing) continue;
    const EndpointSample converted = convert(rig.geometry, rig.shoulder, store::raw_of(sample));
    found.times.push_back(seconds(sample.acquisition_ns()));
    for (const PairDataset& dataset : pair_datasets()) {
      const auto pair = dataset.values(sample, converted);
      found.values.insert(found.values.end(), pair.begin(), pair.end());
    }
  }
  return found;
}

/// Instances of a role in the session.
std::set<Id> instances_of(const Session& session, v1::ServiceRole role) {
  std::set<Id> found;
  for (const auto& configuration : session.configurations) {
    if (configuration.value.role() == role) found.insert(configuration.value.instance_id());
  }
  return found;
}

/// The archive host's clock minus the rig's, s; none: the comparison is between others.
std::optional<double> offset_of(const v1::ClockOffset& offset, const std::set<Id>& rigs,
                                const std::set<Id>& archives) {
  if (archives.contains(offset.asker_id()) && rigs.contains(offset.answerer_id()))
    return -seconds(offset.offset_ns());
  if (rigs.contains(offset.asker_id()) && archives.contains(offset.answerer_id()))
    return seconds(offset.offset_ns());
  return std::nullopt;
}

/// A session on its way into a file.
class Export {
 public:
  Export(XdfFile& file, store::Store& store, const Session& session)
      : file_(file), store_(store), session_(session) {}

  Result<void> write(const SessionTrial& trial) {
    TONUS_TRY_ASSIGN(const auto rig, store::rig_in_force(session_, trial));
    TONUS_TRY_ASSIGN(const auto found, store::read_trial_samples(store_, trial));
    const Measured rows = measured(rig, found.samples);
    if (rows.times.empty()) return {};
    if (motion_.samples == 0) {
      TONUS_TRY(begin(rig.description, trial, rows.times.back()));
    }
    TONUS_TRY(file_.write(kMotion, rows.times, rows.values));
    for (const double time : rows.times) motion_.add(time);
    return write_events(trial, found.samples, rows);
  }

  Result<void> finish() {
    if (motion_.samples == 0) {
      return fail(ErrorCode::kNotFound,
                  fmt::format("session {}: no trial has samples", to_hex(session_.record.session)));
    }
    TONUS_TRY(write_notes_until(std::nullopt, std::numeric_limits<double>::infinity()));
    TONUS_TRY(file_.end_stream(kMotion, footer_text(motion_, offsets_)));
    TONUS_TRY(file_.end_stream(kEvents, footer_text(events_, offsets_)));
    return file_.finish();
  }

 private:
  Result<void> begin(const v1::RigDescription& rig, const SessionTrial& trial, double last_time) {
    TONUS_TRY(
        file_.begin_stream(kMotion, motion_header(session_, rig, trial.outcome->value.sample_rate_Hz())));
    TONUS_TRY(file_.begin_stream(kEvents, header_text(session_, "events", "Markers", "string", 1, 0.0, "")));
    if (rig.moves_nothing_real()) return {};
    // The outcome came when the last sample had just been taken: near enough for when an offset was measured.
    const double utc_minus_rig = static_cast<double>(trial.outcome->received_ns) * 1e-9 - last_time;
    const auto rigs = instances_of(session_, v1::ROLE_RIG);
    const auto archives = instances_of(session_, v1::ROLE_ARCHIVE);
    for (const auto& arrival : session_.clock_offsets) {
      const auto offset = offset_of(arrival.value, rigs, archives);
      if (!offset) continue;
      const double time = static_cast<double>(arrival.value.measured_ns()) * 1e-9 - utc_minus_rig;
      TONUS_TRY(file_.write_clock_offset(kMotion, time, *offset));
      TONUS_TRY(file_.write_clock_offset(kEvents, time, *offset));
      offsets_ += fmt::format("<offset><time>{}</time><value>{}</value></offset>", time, *offset);
    }
    return {};
  }

  Result<void> write_event(double time, const std::string& text) {
    events_.add(time);
    return file_.write(kEvents, time, text);
  }

  /// Those of this start of the rig's agent, up to this time, that are not written yet.
  Result<void> write_notes_until(std::optional<std::uint64_t> epoch, double time) {
    for (std::size_t i = 0; i < session_.notes.size(); ++i) {
      const v1::SessionNote& note = session_.notes[i].value;
      const double written = seconds(note.rig_clock_ns());
      if (!note.has_rig_clock() || written > time || (epoch && note.epoch() != *epoch)) continue;
      if (!written_notes_.insert(i).second) continue;
      const auto attempt = store::attempt_of(session_, note);
      TONUS_TRY(write_event(
          written,
          fmt::format("{}{}{}: {}", note.kind(), note.written_by().empty() ? "" : " by " + note.written_by(),
                      attempt > 0 ? fmt::format(" on trial {}", attempt) : "", note.text())));
    }
    return {};
  }

  Result<void> write_events(const SessionTrial& trial, std::span<const v1::RigSample> samples,
                            const Measured& rows) {
    const v1::TrialOutcome& outcome = trial.outcome->value;
    const v1::TrialProgram& program = outcome.program();
    TONUS_TRY(write_notes_until(outcome.epoch(), rows.times.front()));
    TONUS_TRY(write_event(rows.times.front(), fmt::format("trial {} begins", trial.attempt)));
    const std::uint64_t onset = outcome.onset_sequence() - outcome.first_sequence();
    if (program.kind() == v1::TRIAL_PERTURBATION && onset < samples.size() &&
        !contract::flags_of(samples[onset]).is_missing) {
      TONUS_TRY(write_event(seconds(samples[onset].acquisition_ns()),
                            fmt::format("trial {} onset, {}, {} deg, {} m", trial.attempt, program.posture(),
                                        program.direction_deg(), program.amplitude_m())));
    }
    TONUS_TRY(write_notes_until(outcome.epoch(), rows.times.back()));
    const std::string why = store::why_not_counted(trial);
    return write_event(rows.times.back(),
                       fmt::format("trial {} ends, {}, {}", trial.attempt, v1::end_name(outcome.end()),
                                   why.empty() ? "valid" : "not valid: " + why));
  }

  XdfFile& file_;
  store::Store& store_;
  const Session& session_;
  Written motion_;
  Written events_;
  std::set<std::size_t> written_notes_;
  std::string offsets_;  ///< For the footers.
};

}  // namespace

Result<void> export_xdf(store::Store& store, const Session& session, const std::filesystem::path& path,
                        const Progress& progress) {
  TONUS_TRY_ASSIGN(auto partial, PartialFile::begin(path));
  TONUS_TRY_ASSIGN(auto file, XdfFile::create(partial.path()));
  Export all(file, store, session);
  std::uint64_t done = 0;
  for (const SessionTrial& trial : session.trials) {
    if (progress) progress(done++, session.trials.size());
    if (!trial.outcome || !trial.record || !trial.record->has_samples) continue;
    TONUS_TRY(all.write(trial));
  }
  TONUS_TRY(all.finish());
  if (progress) progress(session.trials.size(), session.trials.size());
  return partial.finish();
}

}  // namespace tonus::formats
