#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>
#include <spdlog/fmt/fmt.h>

#include "services/core/json_text.hpp"
#include "services/core/partial_folder.hpp"
#include "services/core/text_file.hpp"
#include "services/recording/auxiliary_files.hpp"
#include "services/recording/channels.hpp"
#include "services/recording/dataset.hpp"
#include "services/recording/events.hpp"
#include "services/recording/file_name.hpp"
#include "services/recording/motion_rows.hpp"
#include "services/recording/participants.hpp"
#include "services/recording/sessions.hpp"

namespace tonus::recording {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

std::string dump(const Json& json) { return json_text(json, 2) + "\n"; }

Result<void> make_folder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) return fail(ErrorCode::kIo, folder.string() + ": cannot be created: " + error.message());
  return {};
}

bool has_unit_scales(const RigGeometry& rig) {
  const bool is_plain_force =
      rig.force_offset_V.isZero(0.0) && std::abs(rig.force_calibration(0, 0)) == 1.0 &&
      (rig.kind == RigKind::kOneAxis || rig.force_calibration == Eigen::Matrix2d::Identity());
  return is_plain_force && rig.counts_per_unit[0] == 1.0 && rig.encoder_zero[0] == 0.0 &&
         rig.encoder_sign[0] == 1.0 &&
         (rig.kind == RigKind::kOneAxis ||
          (rig.counts_per_unit[1] == 1.0 && rig.encoder_zero[1] == 0.0 && rig.encoder_sign[1] == 1.0));
}

/// The recording as its file holds it: converted channels without scales, a posture label, channel names.
Recording as_written(const Recording& given) {
  Recording recording = given;
  if (recording.acquisition.empty()) recording.acquisition = to_label(recording.posture);
  if (recording.rig.kind == RigKind::kCartesian) recording.is_raw = false;
  if (recording.rig.kind == RigKind::kTwoLink) recording.is_raw = true;
  if (recording.channel_names[0].empty()) recording.channel_names[0] = "displacement";
  if (recording.channel_names[1].empty()) recording.channel_names[1] = "force";
  if (recording.is_raw || has_unit_scales(recording.rig)) return recording;
  for (Row& row : recording.rows) {
    if (row.is_missing) continue;
    const EndpointSample converted = convert(given.rig, given.shoulder, row.raw);
    row.raw.encoder_count = {converted.p_SE[0], converted.p_SE[1]};
    row.raw.force_V = {converted.f_S[0], converted.f_S[1]};
  }
  recording.rig.counts_per_unit = {1.0, 1.0};
  recording.rig.encoder_zero = {};
  recording.rig.encoder_sign = {1.0, 1.0};
  recording.rig.force_calibration.setIdentity();
  recording.rig.force_offset_V.setZero();
  recording.is_force_sign_stated = true;
  return recording;
}

Result<void> check(const Recording& recording) {
  const auto refuse = [&recording](const std::string& reason) {
    return fail(ErrorCode::kInvalidArgument, "recording " + describe(recording) + ": " + reason);
  };
  if (!(recording.sampling_frequency > 0.0)) {
    return refuse(fmt::format("sampling frequency {} Hz is not allowed; expected more than 0",
                              recording.sampling_frequency));
  }
  if (recording.rows.empty()) return refuse("has no row; expected one");
  if (!recording.commanded.empty() && recording.commanded.size() != recording.rows.size()) {
    return refuse(fmt::format("{} commanded displacements are not allowed; expected {}, one for each row",
                              recording.commanded.size(), recording.rows.size()));
  }
  if (!recording.phases.empty() && recording.phases.size() != recording.rows.size()) {
    return refuse(fmt::format("{} phases are not allowed; expected {}, one for each row",
                              recording.phases.size(), recording.rows.size()));
  }
  if (const auto good = check_auxiliary(recording); !good) return refuse(good.error().message);
  for (const Row& row : recording.rows) {
    const bool is_finite = std::isfinite(row.raw.encoder_count[0]) &&
                           std::isfinite(row.raw.encoder_count[1]) && std::isfinite(row.raw.force_V[0]) &&
                           std::isfinite(row.raw.force_V[1]);
    if (!row.is_missing && !is_finite)
      return refuse("has a row that is neither finite nor marked as missing");
  }
  return {};
}

std::string motion_json(const Recording& recording, const std::vector<Channel>& channels) {
  const auto count = [&channels](const char* type) {
    return std::count_if(channels.begin(), channels.end(),
                         [type](const Channel& c) { return c.type == type; });
  };
  Json json;
  json["TaskName"] = recording.task;
  if (!recording.task_description.empty()) json["TaskDescription"] = recording.task_description;
  json["SamplingFrequency"] = recording.sampling_frequency;
  json["TrackingSystemName"] = recording.tracking_system;
  json["MotionChannelCount"] = count("POS") + count("JNTANG");
  json["POSChannelCount"] = count("POS");
  json["JNTANGChannelCount"] = count("JNTANG");
  json["MISCChannelCount"] = count("MISC");
  const bool has_missing = std::any_of(recording.rows.begin(), recording.rows.end(),
                                       [](const Row& row) { return row.is_missing; });
  json["MissingValues"] = has_missing ? "n/a" : "none";
  return dump(json);
}

std::string description_json(const WriteOptions& options) {
  Json json;
  json["Name"] = options.name;
  json["BIDSVersion"] = "1.9.0";
  json["DatasetType"] = "raw";
  if (!options.license.empty()) json["License"] = options.license;
  if (!options.authors.empty()) json["Authors"] = options.authors;
  Json program = {{"Name", "tonus"}};
  if (!options.software_version.empty()) program["Version"] = options.software_version;
  json["GeneratedBy"] = Json::array({program});
  return dump(json);
}

constexpr const char* kReadme =
    "Recordings of arm or joint impedance experiments: displacement of a limb that a manipulandum perturbs, "
    "and the\n"
    "force of the rig on the limb. One run is one posture. Channels q1, q2 (encoder counts) and f1, f2 "
    "(volts) are raw;\n"
    "the _channels.json beside them has the rig's constants that convert them. x, y are the endpoint and fx, "
    "fy the force\n"
    "on the arm, in the shoulder frame; xc, yc the commanded displacement. The _events.tsv has a row a "
    "perturbation.\n"
    "Files of tracksys-auxiliaryxN, where there are any, have the rig's other channels (EMG, triggers), N "
    "values a row.\n";

Result<void> write_run(const fs::path& root, const Recording& recording, const WriteOptions& options) {
  TONUS_TRY_ASSIGN(const auto stem_name, run_stem(recording));
  TONUS_TRY_ASSIGN(const auto events_name, run_stem(recording, false));
  const fs::path folder = root / run_folder(recording);
  TONUS_TRY(make_folder(folder));
  const std::string stem = (folder / stem_name).string();
  const std::string events_stem = (folder / events_name).string();
  const std::vector<Channel> channels = channels_of(recording, options.with_converted);
  const std::pair<std::string, std::string> files[] = {
      {stem + "_motion.tsv", rows_text(recording, options.with_converted)},
      {stem + "_motion.json", motion_json(recording, channels)},
      {stem + "_channels.tsv", channels_text(channels)},
      {stem + "_channels.json", channels_json(recording)},
      {events_stem + "_events.tsv", events_text(recording)},
      {events_stem + "_events.json", events_json(recording)},
  };
  for (const auto& [path, text] : files) {
    TONUS_TRY(create_text_file(path, text));
  }
  return write_auxiliary(folder, recording);
}

Result<void> write_all(const fs::path& root, const std::vector<Recording>& recordings,
                       const WriteOptions& options) {
  std::set<std::string> stems;
  std::vector<Participant> participants;
  for (const Recording& given : recordings) {
    const Recording recording = as_written(given);
    TONUS_TRY(check(recording));
    TONUS_TRY_ASSIGN(const auto stem, run_stem(recording, false));
    if (!stems.insert(stem).second) {
      return fail(
          ErrorCode::kInvalidArgument,
          fmt::format("recording {}: labels '{}' occur twice; expected once", describe(recording), stem));
    }
    TONUS_TRY(write_run(root, recording, options));
    const bool is_known =
        std::any_of(participants.begin(), participants.end(),
                    [&](const Participant& known) { return known.id == recording.participant.id; });
    if (!is_known) participants.push_back(recording.participant);
  }
  TONUS_TRY(write_sessions(root, recordings));
  const std::pair<const char*, std::string> files[] = {
      {"dataset_description.json", description_json(options)},
      {"participants.tsv", participants_text(participants)},
      {"participants.json", participants_json(participants)},
      {"README", kReadme},
  };
  for (const auto& [name, text] : files) {
    TONUS_TRY(create_text_file(root / name, text));
  }
  for (const auto& [name, text] : options.further_files) {
    TONUS_TRY(make_folder((root / name).parent_path()));
    TONUS_TRY(create_text_file(root / name, text));
  }
  return {};
}

}  // namespace

Result<void> write_dataset(const fs::path& root, const std::vector<Recording>& recordings,
                           const WriteOptions& options) {
  if (recordings.empty()) {
    return fail(ErrorCode::kInvalidArgument,
                "dataset '" + root.string() + "': no recording given; expected one");
  }
  auto partial = PartialFolder::begin(root);
  if (!partial) return fail(partial.error().code, "dataset " + partial.error().message);
  TONUS_TRY(write_all(partial->path(), recordings, options));
  return partial->finish();
}

}  // namespace tonus::recording
