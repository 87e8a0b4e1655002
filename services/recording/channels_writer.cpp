#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "services/core/json_text.hpp"
#include "services/recording/channels.hpp"

namespace tonus::recording {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kTurn = 2.0 * std::numbers::pi;  // rad

/// Part of a trial that a row belongs to, a number.
const Channel kPhase{"phase", "n/a", "MISC", "n/a", "n/a"};

/// The counts per revolution that are read back as exactly these counts per rad; a whole number where one
/// does it.
double counts_per_revolution(double counts_per_unit) {
  const double product = counts_per_unit * kTurn;
  for (const double candidate :
       {std::round(product), product, std::nextafter(product, 0.0), std::nextafter(product, INFINITY)}) {
    if (candidate / kTurn == counts_per_unit) return candidate;
  }
  return product;
}

Json rig_json(const Recording& recording) {
  const RigGeometry& rig = recording.rig;
  const bool is_one_axis = rig.kind == RigKind::kOneAxis;
  const std::size_t axes = is_one_axis ? 1 : 2;
  Json json;
  json["Axes"] = axes;
  if (!recording.is_raw) {
    if (recording.is_force_sign_stated) json["ForceSign"] = static_cast<int>(rig.force_calibration(0, 0));
    return json;
  }
  if (!is_one_axis) json["LinkLengths_m"] = {rig.links.l1, rig.links.l2};
  Json counts = Json::array();
  Json zero = Json::array();
  Json sign = Json::array();
  Json calibration = Json::array();
  Json offset = Json::array();
  for (std::size_t i = 0; i < axes; ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    counts.push_back(counts_per_revolution(rig.counts_per_unit[i]));
    zero.push_back(rig.encoder_zero[i]);
    sign.push_back(rig.encoder_sign[i]);
    offset.push_back(rig.force_offset_V[row]);
    Json calibration_row = Json::array();
    for (std::size_t j = 0; j < axes; ++j)
      calibration_row.push_back(rig.force_calibration(row, static_cast<Eigen::Index>(j)));
    calibration.push_back(calibration_row);
  }
  json["EncoderCountsPerRevolution"] = counts;
  json["EncoderZero_count"] = zero;
  json["EncoderSign"] = sign;
  json["ForceCalibration_N_per_V"] = calibration;
  json["ForceOffset_V"] = offset;
  json["ForceSensorAngle_rad"] = rig.force_sensor_angle;
  if (std::isfinite(rig.force_saturation_V)) json["ForceSaturation_V"] = rig.force_saturation_V;
  json["HandleMass_kg"] = rig.handle_mass;
  return json;
}

}  // namespace

std::vector<Channel> channels_of(const Recording& recording, bool with_converted) {
  std::vector<Channel> channels;
  const std::string& point = recording.tracked_point;
  if (recording.rig.kind == RigKind::kOneAxis) {
    const bool is_turning = recording.displacement_unit == "rad";
    if (recording.is_raw) {
      channels = {{"q1", "n/a", "MISC", point, "count"}, {"f1", "n/a", "MISC", point, "V"}};
    } else {
      channels = {{recording.channel_names[0], is_turning ? "n/a" : "x", is_turning ? "JNTANG" : "POS", point,
                   recording.displacement_unit},
                  {recording.channel_names[1], "n/a", "MISC", point, recording.force_unit}};
    }
    if (!recording.commanded.empty())
      channels.push_back({"xc", "n/a", "MISC", point, recording.displacement_unit});
    if (!recording.phases.empty()) channels.push_back(kPhase);
    return channels;
  }
  if (recording.is_raw) {
    channels = {{"q1", "n/a", "MISC", "inner joint", "count"},
                {"q2", "n/a", "MISC", "outer joint", "count"},
                {"f1", "n/a", "MISC", point, "V"},
                {"f2", "n/a", "MISC", point, "V"}};
  }
  if (!recording.is_raw || with_converted) {
    channels.insert(channels.end(), {{"x", "x", "POS", point, "m"},
                                     {"y", "y", "POS", point, "m"},
                                     {"fx", "n/a", "MISC", point, "N"},
                                     {"fy", "n/a", "MISC", point, "N"}});
  }
  if (!recording.commanded.empty()) {
    channels.insert(channels.end(), {{"xc", "n/a", "MISC", point, "m"}, {"yc", "n/a", "MISC", point, "m"}});
  }
  if (!recording.phases.empty()) channels.push_back(kPhase);
  return channels;
}

std::string channels_text(const std::vector<Channel>& channels) {
  std::string text = "name\tcomponent\ttype\ttracked_point\tunits\n";
  for (const Channel& channel : channels) {
    text += channel.name + "\t" + channel.component + "\t" + channel.type + "\t" +
            (channel.tracked_point.empty() ? "n/a" : channel.tracked_point) + "\t" + channel.units + "\n";
  }
  return text;
}

std::string channels_json(const Recording& recording) {
  Json json;
  json["Rig"] = rig_json(recording);
  if (recording.is_raw && recording.rig.kind == RigKind::kTwoLink) {
    json["ShoulderInRobot"] = {{"x_m", recording.shoulder.origin[0]},
                               {"y_m", recording.shoulder.origin[1]},
                               {"angle_rad", recording.shoulder.angle}};
  }
  if (recording.posture_position) {
    json["Posture"] = {{"name", recording.posture},
                       {"x_m", (*recording.posture_position)[0]},
                       {"y_m", (*recording.posture_position)[1]}};
  }
  return json_text(json, 2) + "\n";
}

}  // namespace tonus::recording
