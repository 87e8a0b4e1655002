#include "rig_agent/calibration/calibration.hpp"

#include <Eigen/Geometry>
#include <cstdlib>
#include <optional>
#include <spdlog/fmt/fmt.h>
#include <sstream>

#include "services/config/checked_table.hpp"
#include "services/config/toml_text.hpp"
#include "services/core/folder.hpp"
#include "services/core/text_file.hpp"

namespace tonus::calibration {
namespace {

// To nine digits: finer than any sensor, and short enough for a message.
double short_number(double value) { return std::strtod(fmt::format("{:.9g}", value).c_str(), nullptr); }

toml::array pair(const Eigen::Vector2d& v) { return toml::array{short_number(v.x()), short_number(v.y())}; }
toml::array pair(const std::array<double, 2>& v) { return pair(Eigen::Vector2d(v[0], v[1])); }
toml::array rows(const Eigen::Matrix2d& m) {
  return toml::array{pair(m.row(0).transpose()), pair(m.row(1).transpose())};
}

std::optional<Eigen::Vector2d> pair_of(toml::node_view<const toml::node> node) {
  const toml::array* array = node.as_array();
  if (array == nullptr || array->size() != 2) return std::nullopt;
  const auto x = (*array)[0].value<double>();
  const auto y = (*array)[1].value<double>();
  if (!x || !y) return std::nullopt;
  const Eigen::Vector2d value(*x, *y);
  return value.allFinite() ? std::optional(value) : std::nullopt;
}

std::optional<Eigen::Matrix2d> rows_of(toml::node_view<const toml::node> node) {
  const auto first = pair_of(node[0]);
  const auto second = pair_of(node[1]);
  if (!first || !second) return std::nullopt;
  Eigen::Matrix2d m;
  m << first->transpose(), second->transpose();
  return m;
}

std::optional<LoadReading> load_of(const toml::node& node) {
  const toml::table* table = node.as_table();
  if (table == nullptr) return std::nullopt;
  const toml::table& view = *table;
  const auto load = pair_of(view["load_N"]);
  const auto volts = pair_of(view["force_V"]);
  const auto angle = view["sensor_angle_rad"].value<double>();
  if (!load || !volts || !angle) return std::nullopt;
  return LoadReading{*load, *volts, *angle};
}

}  // namespace

KnownForce LoadReading::known_force() const { return {Eigen::Rotation2Dd(-sensor_angle) * -load, volts}; }

Result<Calibration> Calibration::load(const std::filesystem::path& file, const std::string& driver) {
  TONUS_TRY_ASSIGN(const bool is_there, is_present(file));
  if (!is_there) return Calibration(driver);
  auto text = read_text_file(file);
  if (!text) return text.error();
  return parse(*text, file.string(), driver);
}

Result<Calibration> Calibration::parse(std::string_view text, const std::string& source,
                                       const std::string& driver) {
  Calibration calibration(driver);
  TONUS_TRY_ASSIGN(calibration.document_, config::parse_toml(text, source));
  if (auto good = calibration.check(source); !good) return good.error();
  return calibration;
}

Result<void> Calibration::check(const std::string& source) const {
  config::Findings findings{source, {}, {}};
  const auto refuse = [&findings](config::CheckedTable& table, const char* key, const char* expected) {
    table.refuse(key, expected);
    return Result<void>(fail(ErrorCode::kInvalidArgument, *findings.problem));
  };
  const toml::table& view = document_;
  config::CheckedTable root(view, "", 0, findings);
  if (root.text("driver", 0, 80, "") != driver_) {
    return refuse(root, "driver",
                  fmt::format("\"{}\": give the rig another name, or remove the file", driver_).c_str());
  }
  config::CheckedTable in_force = root.optional_table("in_force");
  for (const char* key : {"encoder_zero_count", "force_offset_V"}) {
    if (in_force.has(key) && !pair_of(view["in_force"][key])) return refuse(in_force, key, "two numbers");
  }
  constexpr const char* kMatrix = "force_calibration_N_per_V";
  if (in_force.has(kMatrix) && !rows_of(view["in_force"][kMatrix]))
    return refuse(in_force, kMatrix, "two rows of two numbers");
  if (const toml::array* loads = view["load"].as_array()) {
    for (std::size_t i = 0; i < loads->size(); ++i) {
      if (load_of(*loads->get(i))) continue;
      return fail(ErrorCode::kInvalidArgument,
                  fmt::format("{}: load[{}] is not whole; expected load_N, force_V and sensor_angle_rad",
                              source, i + 1));
    }
  }
  if (findings.problem) return fail(ErrorCode::kInvalidArgument, *findings.problem);
  return {};
}

Result<void> Calibration::save(const std::filesystem::path& file) const {
  return write_text_file(file, text());
}

std::string Calibration::text() const {
  if (document_.empty()) return {};
  std::ostringstream text;
  text << document_ << "\n";
  return text.str();
}

toml::table& Calibration::step(std::string_view name, const Signature& signature) {
  document_.insert_or_assign("driver", driver_);
  document_.insert_or_assign("calibrated_at", signature.at);
  document_.insert_or_assign("calibrated_by", signature.by);
  document_.insert_or_assign(name, toml::table{{"at", signature.at}, {"by", signature.by}});
  return *document_[name].as_table();
}

toml::table& Calibration::in_force() {
  if (!document_["in_force"].is_table()) document_.insert_or_assign("in_force", toml::table{});
  return *document_["in_force"].as_table();
}

void Calibration::set_tare(const RestReading& reading, const Signature& signature) {
  toml::table& tare = step("tare", signature);
  tare.insert("force_V", pair(reading.volts));
  tare.insert("deviation_V", pair(reading.volts_deviation));
  tare.insert("samples", static_cast<std::int64_t>(reading.samples));
  in_force().insert_or_assign("force_offset_V", pair(reading.volts));
}

void Calibration::set_zero(const RestReading& reading, const Eigen::Vector2d& place,
                           const std::array<double, 2>& zero, const Signature& signature) {
  toml::table& table = step("zero", signature);
  table.insert("place_m", pair(place));
  table.insert("encoder_count", pair(reading.encoder_count));
  table.insert("samples", static_cast<std::int64_t>(reading.samples));
  in_force().insert_or_assign("encoder_zero_count", pair(zero));
}

Result<void> Calibration::add_load(const LoadReading& reading, const Signature& signature) {
  if (loads().size() >= kMostLoads) {
    return fail(ErrorCode::kInvalidArgument,
                fmt::format("loads: {} is not allowed; expected at most {}; begin again", loads().size() + 1,
                            kMostLoads));
  }
  document_.insert_or_assign("driver", driver_);
  if (!document_["load"].is_array()) document_.insert_or_assign("load", toml::array{});
  document_["load"].as_array()->push_back(
      toml::table{{"at", signature.at},
                  {"by", signature.by},
                  {"load_N", pair(reading.load)},
                  {"force_V", pair(reading.volts)},
                  {"sensor_angle_rad", short_number(reading.sensor_angle)}});
  return {};
}

void Calibration::forget_loads() { document_.erase("load"); }

std::vector<LoadReading> Calibration::loads() const {
  std::vector<LoadReading> loads;
  const toml::table& root = document_;
  if (const toml::array* array = root["load"].as_array()) {
    for (const toml::node& node : *array) {
      if (const auto load = load_of(node)) loads.push_back(*load);
    }
  }
  return loads;
}

void Calibration::set_force(const ForceFit& fit, const Signature& signature) {
  toml::table& force = step("force", signature);
  force.insert("loads", static_cast<std::int64_t>(loads().size()));
  force.insert("residual_N", short_number(fit.residual));
  in_force().insert_or_assign("force_calibration_N_per_V", rows(fit.matrix));
  in_force().insert_or_assign("force_offset_V", pair(fit.offset));
}

void Calibration::set_spring(const SpringCheck& check, const Signature& signature) {
  toml::table& spring = step("spring", signature);
  spring.insert("nominal_N_per_m", short_number(check.nominal));
  spring.insert("direction", check.direction);
  spring.insert("measured_N_per_m", short_number(check.measured));
  spring.insert("deviation_percent", short_number(check.deviation_percent()));
  spring.insert("stiffness_N_per_m", rows(check.fit.stiffness));
  spring.insert("standard_error_N_per_m", rows(check.fit.standard_error));
  spring.insert("residual_N", short_number(check.fit.residual));
  spring.insert("steps", static_cast<std::int64_t>(check.steps));
}

RigGeometry Calibration::applied_to(const RigGeometry& geometry) const {
  RigGeometry corrected = geometry;
  const auto constants = document_["in_force"];
  if (const auto zero = pair_of(constants["encoder_zero_count"]))
    corrected.encoder_zero = {zero->x(), zero->y()};
  if (const auto offset = pair_of(constants["force_offset_V"])) corrected.force_offset_V = *offset;
  if (const auto matrix = rows_of(constants["force_calibration_N_per_V"]))
    corrected.force_calibration = *matrix;
  return corrected;
}

std::string Calibration::at() const { return document_["calibrated_at"].value_or(std::string()); }
std::string Calibration::by() const { return document_["calibrated_by"].value_or(std::string()); }

}  // namespace tonus::calibration
