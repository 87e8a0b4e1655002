#include "services/recording/channels.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <set>
#include <spdlog/fmt/fmt.h>

#include "services/recording/table.hpp"

namespace tonus::recording {
namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;  // rad
constexpr double kRateTolerance = 1e-3;           // of two statements of one rate

bool are_rates_equal(double a, double b) { return std::abs(a - b) <= kRateTolerance * std::abs(b); }

struct Unit {
  std::string name;    ///< As a recording has it; another one as it stands.
  double scale = 1.0;  ///< What one of the column's unit is in it.
};

/// Units of converted channels and of time stamps, however they are spelt.
Unit unit_named(const std::string& spelt) {
  constexpr double kDegree = kTurn / 360.0;
  struct Known {
    const char* spelling;
    const char* name;
    double scale;
  };
  static constexpr Known kKnown[] = {
      {"Nm", "N m", 1.0},         {"N*m", "N m", 1.0},         {"N.m", "N m", 1.0},
      {"N-m", "N m", 1.0},        {"N·m", "N m", 1.0},         {"N mm", "N m", 1e-3},
      {"Nmm", "N m", 1e-3},       {"N cm", "N m", 1e-2},       {"Ncm", "N m", 1e-2},
      {"mN m", "N m", 1e-3},      {"mNm", "N m", 1e-3},        {"kN m", "N m", 1e3},
      {"kNm", "N m", 1e3},        {"mN", "N", 1e-3},           {"kN", "N", 1e3},
      {"mm", "m", 1e-3},          {"cm", "m", 1e-2},           {"um", "m", 1e-6},
      {"µm", "m", 1e-6},          {"μm", "m", 1e-6},           {"deg", "rad", kDegree},
      {"degree", "rad", kDegree}, {"degrees", "rad", kDegree}, {"°", "rad", kDegree},
      {"ms", "s", 1e-3},          {"us", "s", 1e-6},           {"µs", "s", 1e-6},
  };
  for (const Known& known : kKnown) {
    if (spelt == known.spelling) return {known.name, known.scale};
  }
  return {spelt, 1.0};
}

/// The rows of `_channels.tsv`, with the search for what we can use.
class ChannelTable {
 public:
  explicit ChannelTable(Table table) : table_(std::move(table)) {}

  [[nodiscard]] std::size_t size() const { return table_.rows(); }
  [[nodiscard]] std::string name(std::size_t row) const { return std::string(table_.cell(row, "name")); }
  [[nodiscard]] std::string tracked_point(std::size_t row) const { return table_.text(row, "tracked_point"); }
  [[nodiscard]] std::string unit(std::size_t row) const {
    return unit_named(std::string(table_.cell(row, "units"))).name;
  }
  [[nodiscard]] double scale(std::size_t row) const {
    return unit_named(std::string(table_.cell(row, "units"))).scale;
  }
  [[nodiscard]] bool is_type(std::size_t row, std::string_view type) const {
    return table_.cell(row, "type") == type;
  }

  [[nodiscard]] std::optional<std::size_t> find(std::string_view name) const {
    for (std::size_t row = 0; row < table_.rows(); ++row) {
      if (table_.cell(row, "name") == name) return row;
    }
    return {};
  }

  /// Every name once: which of two columns of one name is meant, nobody can know.
  [[nodiscard]] Result<void> require_distinct_names() const {
    std::set<std::string> seen;
    for (std::size_t row = 0; row < size(); ++row) {
      if (!seen.insert(name(row)).second) return table_.refuse(row, "name", "every name once");
    }
    return {};
  }

  /// Of the channels that are used, a rate that is stated is the recording's.
  [[nodiscard]] Result<void> require_rate(const Columns& columns, double nominal, double used) const {
    for (std::size_t row = 0; row < size(); ++row) {
      if (columns[row].what == Column::kIgnored) continue;
      TONUS_TRY_ASSIGN(const auto stated, table_.number_or_nothing(row, "sampling_frequency"));
      if (!stated || are_rates_equal(*stated, nominal) || are_rates_equal(*stated, used)) continue;
      return table_.refuse(row, "sampling_frequency",
                           fmt::format("{} Hz, the SamplingFrequency of _motion.json", nominal));
    }
    return {};
  }

  /// The channel of time stamps, in seconds, and its row.
  [[nodiscard]] std::optional<std::size_t> latency() const {
    return only([this](std::size_t row) { return is_type(row, "LATENCY") && unit(row) == "s"; });
  }

  [[nodiscard]] bool has_all(const std::vector<std::string_view>& names) const {
    return std::all_of(names.begin(), names.end(),
                       [this](std::string_view name) { return find(name).has_value(); });
  }

  /// The only row that `is_wanted`, or nothing.
  template <typename Predicate>
  [[nodiscard]] std::optional<std::size_t> only(const Predicate& is_wanted) const {
    std::optional<std::size_t> found;
    for (std::size_t row = 0; row < table_.rows(); ++row) {
      if (!is_wanted(row)) continue;
      if (found) return {};
      found = row;
    }
    return found;
  }

  [[nodiscard]] Result<void> require_unit(std::size_t row, std::string_view needed) const {
    if (unit(row) == needed) return {};
    return table_.refuse(row, "units", fmt::format("'{}' for channel {}", needed, name(row)));
  }

  [[nodiscard]] Error refuse(std::size_t row, std::string_view column, std::string_view allowed) const {
    return table_.refuse(row, column, allowed);
  }

  /// The names, of which a person can read so many.
  [[nodiscard]] std::string names() const {
    constexpr std::size_t kMost = 8;
    std::vector<std::string> listed;
    for (std::size_t row = 0; row < std::min(size(), kMost); ++row) listed.push_back(name(row));
    const std::string more = size() > kMost ? fmt::format(" and {} more", size() - kMost) : "";
    return fmt::format("{}{}", fmt::join(listed, ", "), more);
  }

  /// Whether a channel can be a force or a torque, by its unit.
  [[nodiscard]] bool has_force() const {
    for (std::size_t row = 0; row < size(); ++row) {
      if (unit(row) == "N" || unit(row) == "N m" || unit(row) == "V") return true;
    }
    return false;
  }

 private:
  Table table_;
};

struct Assignment {
  std::string_view name;
  Column column;
  std::string_view unit;
};

Result<void> assign(const ChannelTable& table, const std::vector<Assignment>& wanted, Columns& columns) {
  for (const Assignment& assignment : wanted) {
    const std::size_t row = *table.find(assignment.name);
    TONUS_TRY(table.require_unit(row, assignment.unit));
    columns[row].what = assignment.column;
  }
  return {};
}

/// xc and yc, where they are; one-axis rigs have xc alone.
Result<void> assign_commanded(const ChannelTable& table, const Recording& recording, Columns& columns) {
  const bool has_one_axis = recording.rig.kind == RigKind::kOneAxis;
  if (!table.find("xc")) return {};
  if (has_one_axis) return assign(table, {{"xc", Column::kCommanded0, recording.displacement_unit}}, columns);
  if (!table.find("yc")) return {};
  return assign(table, {{"xc", Column::kCommanded0, "m"}, {"yc", Column::kCommanded1, "m"}}, columns);
}

/// "Rig" of `_channels.json`, for raw channels of one or two axes.
Result<RigGeometry> read_rig(const JsonFile& json, std::size_t axes) {
  RigGeometry rig;
  rig.kind = axes == 2 ? RigKind::kTwoLink : RigKind::kOneAxis;
  TONUS_TRY_ASSIGN(const auto stated_axes, json.number("Rig.Axes"));
  if (stated_axes != static_cast<double>(axes)) {
    return json.refuse("Rig.Axes", fmt::format("{} for these channels", axes));
  }
  if (axes == 2) {
    TONUS_TRY_ASSIGN(const auto lengths, json.numbers("Rig.LinkLengths_m", 2));
    rig.links = {lengths[0], lengths[1]};
  }
  TONUS_TRY_ASSIGN(const auto counts, json.numbers("Rig.EncoderCountsPerRevolution", axes));
  TONUS_TRY_ASSIGN(const auto zero, json.numbers("Rig.EncoderZero_count", axes));
  TONUS_TRY_ASSIGN(const auto sign, json.numbers("Rig.EncoderSign", axes));
  TONUS_TRY_ASSIGN(const auto calibration, json.matrix("Rig.ForceCalibration_N_per_V", axes));
  TONUS_TRY_ASSIGN(const auto offset, json.numbers("Rig.ForceOffset_V", axes));
  rig.counts_per_unit = {1.0, 1.0};
  rig.force_calibration.setIdentity();
  for (std::size_t i = 0; i < axes; ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    rig.counts_per_unit[i] = counts[i] / kTurn;
    rig.encoder_zero[i] = zero[i];
    rig.encoder_sign[i] = sign[i];
    rig.force_offset_V[row] = offset[i];
    for (std::size_t j = 0; j < axes; ++j) {
      rig.force_calibration(row, static_cast<Eigen::Index>(j)) = calibration[i * axes + j];
    }
  }
  TONUS_TRY_ASSIGN(const auto angle,
                   json.number("Rig.ForceSensorAngle_rad", axes == 2 ? std::optional<double>() : 0.0));
  TONUS_TRY_ASSIGN(const auto mass, json.number("Rig.HandleMass_kg", 0.0));
  TONUS_TRY_ASSIGN(const auto saturation, json.number("Rig.ForceSaturation_V", rig.force_saturation_V));
  rig.force_sensor_angle = angle;
  rig.handle_mass = mass;
  rig.force_saturation_V = saturation;
  if (const auto valid = validate(rig); !valid) {
    return fail(ErrorCode::kInvalidArgument, json.path().string() + ": " + valid.error().message);
  }
  return rig;
}

Result<void> read_posture(const JsonFile& json, Recording& recording) {
  recording.posture = recording.acquisition;
  if (json.has("Posture")) {
    TONUS_TRY_ASSIGN(const auto name, json.text("Posture.name", recording.acquisition));
    TONUS_TRY_ASSIGN(const auto x, json.number("Posture.x_m"));
    TONUS_TRY_ASSIGN(const auto y, json.number("Posture.y_m"));
    recording.posture = name;
    recording.posture_position = Eigen::Vector2d(x, y);
  }
  return {};
}

Result<void> read_shoulder(const JsonFile& json, Recording& recording) {
  TONUS_TRY_ASSIGN(const auto x, json.number("ShoulderInRobot.x_m"));
  TONUS_TRY_ASSIGN(const auto y, json.number("ShoulderInRobot.y_m"));
  TONUS_TRY_ASSIGN(const auto angle, json.number("ShoulderInRobot.angle_rad"));
  recording.shoulder = {{x, y}, angle};
  return {};
}

Result<void> read_raw(const ChannelTable& table, const JsonFile& json, std::size_t axes, Recording& recording,
                      Columns& columns) {
  TONUS_TRY_ASSIGN(auto rig, read_rig(json, axes));
  recording.is_raw = true;
  recording.rig = rig;
  if (axes == 1) {
    recording.displacement_unit = "rad";
    recording.force_unit = "N m";
    recording.channel_names = {"q1", "f1"};
    return assign(table, {{"q1", Column::kCount0, "count"}, {"f1", Column::kForce0, "V"}}, columns);
  }
  TONUS_TRY(read_shoulder(json, recording));
  return assign(table,
                {{"q1", Column::kCount0, "count"},
                 {"q2", Column::kCount1, "count"},
                 {"f1", Column::kForce0, "V"},
                 {"f2", Column::kForce1, "V"}},
                columns);
}

Result<void> read_cartesian(const ChannelTable& table, Recording& recording, Columns& columns) {
  recording.rig = converted_rig(RigKind::kCartesian);
  return assign(table,
                {{"x", Column::kCount0, "m"},
                 {"y", Column::kCount1, "m"},
                 {"fx", Column::kForce0, "N"},
                 {"fy", Column::kForce1, "N"}},
                columns);
}

Result<void> read_one_axis(const ChannelTable& table, const JsonFile& json, std::size_t displacement,
                           std::size_t force, Recording& recording, Columns& columns) {
  const std::string unit = table.unit(displacement);
  if (unit != "m" && unit != "rad") return table.refuse(displacement, "units", "'m' or 'rad'");
  recording.displacement_unit = unit;
  recording.force_unit = unit == "m" ? "N" : "N m";
  TONUS_TRY(table.require_unit(force, recording.force_unit));
  recording.rig = converted_rig(RigKind::kOneAxis);
  recording.is_force_sign_stated = json.has("Rig.ForceSign");
  if (recording.is_force_sign_stated) {
    const auto sign = json.number("Rig.ForceSign");
    if (!sign || std::abs(*sign) != 1.0) return json.refuse("Rig.ForceSign", "1 or -1");
    recording.rig.force_calibration(0, 0) = *sign;
  }
  recording.channel_names = {table.name(displacement), table.name(force)};
  recording.tracked_point = table.tracked_point(displacement);
  columns[displacement].what = Column::kCount0;
  columns[force].what = Column::kForce0;
  return {};
}

/// Chooses what to read from what there is.
Result<void> choose(const ChannelTable& table, const JsonFile& json, const std::filesystem::path& file,
                    Recording& recording, Columns& columns) {
  if (table.has_all({"q1", "q2", "f1", "f2"})) return read_raw(table, json, 2, recording, columns);
  if (table.has_all({"x", "y", "fx", "fy"})) return read_cartesian(table, recording, columns);
  const bool has_second_axis = table.find("q2") || table.find("f2");
  if (table.has_all({"q1", "f1"}) && !has_second_axis) return read_raw(table, json, 1, recording, columns);

  const auto displacement = table.only(
      [&table](std::size_t row) { return table.is_type(row, "JNTANG") || table.is_type(row, "POS"); });
  const auto force = table.only([&table](std::size_t row) {
    return table.is_type(row, "MISC") && (table.unit(row) == "N" || table.unit(row) == "N m");
  });
  if (displacement && force) return read_one_axis(table, json, *displacement, *force, recording, columns);
  return fail(
      ErrorCode::kInvalidArgument,
      fmt::format(
          "{}: channels {} are not allowed: needed are q1, q2, f1, f2, or x, y, fx, fy, or one channel "
          "of type JNTANG or POS and one of type MISC in N or N m{}",
          file.string(), table.names(),
          table.has_force()
              ? ""
              : "; without a force nothing can be identified: leave these files out of the dataset"));
}

}  // namespace

Result<Columns> read_channels(const std::filesystem::path& table_file, const JsonFile& json,
                              Recording& recording, double nominal) {
  TONUS_TRY_ASSIGN(auto table, Table::read(table_file));
  TONUS_TRY(table.require({"name", "type", "units"}));
  const ChannelTable channels(std::move(table));
  TONUS_TRY(channels.require_distinct_names());
  Columns columns(channels.size());
  TONUS_TRY(read_posture(json, recording));
  TONUS_TRY(choose(channels, json, table_file, recording, columns));
  TONUS_TRY(assign_commanded(channels, recording, columns));
  if (const auto phase = channels.find("phase")) columns[*phase].what = Column::kPhase;
  TONUS_TRY(channels.require_rate(columns, nominal, recording.sampling_frequency));
  if (const auto latency = channels.latency(); latency && columns[*latency].what == Column::kIgnored)
    columns[*latency].what = Column::kLatency;
  for (std::size_t row = 0; row < columns.size(); ++row) {
    if (columns[row].what != Column::kIgnored) columns[row].scale = channels.scale(row);
  }
  return columns;
}

}  // namespace tonus::recording
