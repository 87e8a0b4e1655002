#include "services/dashboard/gateway/derived_topics.hpp"

#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "services/core/id.hpp"
#include "services/core/json_text.hpp"

namespace tonus::dashboard {

// Lichtblick reads JSON schemas only where every object, those in lists too, names its properties.
const char kHandSchema[] = R"({
  "type": "object",
  "title": "The hand in the shoulder frame, in SI",
  "properties": {
    "sequence": {"type": "integer"},
    "rig_clock_ns": {"type": "integer"},
    "position_m": {"type": "object", "properties": {"x": {"type": "number"}, "y": {"type": "number"}}},
    "force_N": {"type": "object", "properties": {"x": {"type": "number"}, "y": {"type": "number"}}},
    "commanded_m": {"type": "object", "properties": {"x": {"type": "number"}, "y": {"type": "number"}}},
    "phase": {"type": "integer"}
  }
})";

const char kSceneSchema[] = R"({
  "type": "object",
  "title": "foxglove.SceneUpdate",
  "properties": {
    "deletions": {"type": "array", "items": {"type": "object", "properties": {
      "timestamp": {"type": "object", "properties": {"sec": {"type": "integer"}, "nsec": {"type": "integer"}}},
      "type": {"type": "integer"}, "id": {"type": "string"}}}},
    "entities": {"type": "array", "items": {"type": "object", "properties": {
      "timestamp": {"type": "object", "properties": {"sec": {"type": "integer"}, "nsec": {"type": "integer"}}},
      "frame_id": {"type": "string"}, "id": {"type": "string"},
      "lifetime": {"type": "object", "properties": {"sec": {"type": "integer"}, "nsec": {"type": "integer"}}},
      "frame_locked": {"type": "boolean"},
      "lines": {"type": "array", "items": {"type": "object", "properties": {
        "type": {"type": "integer"}, "thickness": {"type": "number"}, "scale_invariant": {"type": "boolean"},
        "points": {"type": "array", "items": {"type": "object", "properties": {
          "x": {"type": "number"}, "y": {"type": "number"}, "z": {"type": "number"}}}}}}},
      "texts": {"type": "array", "items": {"type": "object", "properties": {"text": {"type": "string"}}}}}}}
  }
})";

namespace {

using nlohmann::json;

constexpr int kCorners = 72;
constexpr int kLineLoop = 1;    // of foxglove.LinePrimitive
constexpr int kMatchingId = 0;  // of foxglove.SceneEntityDeletion
constexpr std::uint64_t kNsPerS = 1'000'000'000;
const json kNoTurn = {{"x", 0.0}, {"y", 0.0}, {"z", 0.0}, {"w", 1.0}};
const json kBlue = {{"r", 0.0}, {"g", 0.45}, {"b", 0.7}, {"a", 1.0}};

json xy(const Eigen::Vector2d& v) { return {{"x", v.x()}, {"y", v.y()}}; }
json xyz(double x, double y) { return {{"x", x}, {"y", y}, {"z", 0.0}}; }
json stamp(std::uint64_t ns) { return {{"sec", ns / kNsPerS}, {"nsec", ns % kNsPerS}}; }
json pose(double x, double y) { return {{"position", xyz(x, y)}, {"orientation", kNoTurn}}; }

/// Around the ellipse of size pi l1 l2 and shape l2 / l1, its axis l2 at the orientation.
json corners(const v1::MatrixEstimate& matrix, double x, double y) {
  const double one = std::sqrt(matrix.size() / (std::numbers::pi * matrix.shape()));
  const double other = matrix.shape() * one;
  const double angle = matrix.orientation_deg() * std::numbers::pi / 180.0;
  const double major = kMetresPerStiffness * std::max(one, other);
  const double minor = kMetresPerStiffness * std::min(one, other);
  json points = json::array();
  for (int i = 0; i < kCorners; ++i) {
    const double t = 2.0 * std::numbers::pi * i / kCorners;
    const double u = major * std::cos(t);
    const double v = minor * std::sin(t);
    points.push_back(
        xyz(x + u * std::cos(angle) - v * std::sin(angle), y + u * std::sin(angle) + v * std::cos(angle)));
  }
  return points;
}

json entity(const v1::Estimate& estimate, std::uint64_t time_ns) {
  const double x = estimate.posture_m()[0];
  const double y = estimate.posture_m()[1];
  const json line = {{"type", kLineLoop},
                     {"pose", pose(0.0, 0.0)},
                     {"thickness", 2.0},
                     {"scale_invariant", true},
                     {"points", corners(estimate.stiffness_N_per_m(), x, y)},
                     {"color", kBlue},
                     {"colors", json::array()},
                     {"indices", json::array()}};
  const json label = {{"pose", pose(x, y)}, {"billboard", true},
                      {"font_size", 14.0},  {"scale_invariant", true},
                      {"color", kBlue},     {"text", estimate.posture() + ", " + estimate.method()}};
  return {
      {"timestamp", stamp(time_ns)},   {"frame_id", "shoulder"},       {"id", to_hex(estimate.estimate_id())},
      {"lifetime", stamp(0)},          {"frame_locked", false},        {"metadata", json::array()},
      {"arrows", json::array()},       {"cubes", json::array()},       {"spheres", json::array()},
      {"cylinders", json::array()},    {"lines", json::array({line})}, {"triangles", json::array()},
      {"texts", json::array({label})}, {"models", json::array()}};
}

bool has_ellipse(const v1::Estimate& estimate) {
  const auto& matrix = estimate.stiffness_N_per_m();
  return estimate.status() != v1::ESTIMATE_UNDETERMINED && estimate.axes() == 2 && matrix.has_ellipse() &&
         matrix.size() > 0.0 && matrix.shape() > 0.0;
}

}  // namespace

std::optional<std::string> hand_json(const v1::SampleBlock& block, const RigGeometry& geometry,
                                     const ShoulderPose& shoulder) {
  if (block.samples().empty()) return std::nullopt;
  const v1::RigSample& sample = block.samples().back();
  const EndpointSample hand =
      convert(geometry, shoulder, {sample.acquisition_ns(), sample.encoder_count(), sample.force_V()});
  return json_text(json{{"sequence", block.first_sequence() + block.samples().size() - 1},
                        {"rig_clock_ns", sample.acquisition_ns()},
                        {"position_m", xy(hand.p_SE)},
                        {"force_N", xy(hand.f_S)},
                        {"commanded_m", xy({sample.commanded_m()[0], sample.commanded_m()[1]})},
                        {"phase", sample.phase()}},
                   -1);
}

std::string ellipse_scene_json(const v1::Estimate& estimate, std::uint64_t time_ns) {
  json update{{"deletions", json::array()}, {"entities", json::array()}};
  if (has_ellipse(estimate)) {
    update["entities"].push_back(entity(estimate, time_ns));
  } else {
    update["deletions"].push_back(
        {{"timestamp", stamp(time_ns)}, {"type", kMatchingId}, {"id", to_hex(estimate.estimate_id())}});
  }
  return json_text(update, -1);
}

}  // namespace tonus::dashboard
