#include "services/dashboard/gateway/derived_topics.hpp"

#include <algorithm>
#include <cmath>
#include <gmock/gmock.h>
#include <limits>
#include <nlohmann/json.hpp>
#include <numbers>

#include "services/core/text_file.hpp"
#include "services/dashboard/gateway/topic_table.hpp"
#include "tests/support/process.hpp"

namespace tonus::dashboard {
namespace {

using nlohmann::json;

TEST(DerivedTopics, TheHandIsInMetresAndNewtonsInTheShouldersFrame) {
  RigGeometry rig;
  rig.kind = RigKind::kCartesian;
  rig.counts_per_unit = {1000.0, 1000.0};
  rig.force_calibration = 10.0 * Eigen::Matrix2d::Identity();
  v1::RigSample sample;
  sample.acquisition_ns(5'000'000);
  sample.encoder_count({12.0, -3.0});
  sample.force_V({0.25, 0.1});
  sample.commanded_m({0.005, std::numeric_limits<double>::quiet_NaN()});
  sample.phase(5);
  v1::SampleBlock block;
  block.first_sequence(100);
  block.samples({v1::RigSample(), sample});
  const json hand = json::parse(hand_json(block, rig, {}).value());
  EXPECT_EQ(hand["sequence"], 101);
  EXPECT_EQ(hand["rig_clock_ns"], 5'000'000);
  EXPECT_DOUBLE_EQ(hand["position_m"]["x"], 0.012);
  EXPECT_DOUBLE_EQ(hand["position_m"]["y"], -0.003);
  EXPECT_DOUBLE_EQ(hand["force_N"]["x"], 2.5);
  EXPECT_DOUBLE_EQ(hand["force_N"]["y"], 1.0);
  EXPECT_DOUBLE_EQ(hand["commanded_m"]["x"], 0.005);
  EXPECT_TRUE(hand["commanded_m"]["y"].is_null()) << "not known is not zero";
}

TEST(DerivedTopics, AnEmptyBlockHasNoHand) {
  EXPECT_EQ(hand_json(v1::SampleBlock(), RigGeometry(), {}), std::nullopt);
}

v1::Estimate estimate() {
  v1::Estimate made;
  made.estimate_id({7});
  made.axes(2);
  made.posture("distal");
  made.posture_m({0.1, 0.52});
  auto& matrix = made.stiffness_N_per_m();
  matrix.has_ellipse(true);
  matrix.size(std::numbers::pi * 100.0 * 300.0);
  matrix.shape(3.0);
  matrix.orientation_deg(90.0);
  return made;
}

TEST(DerivedTopics, AnEllipseIsAClosedLineAboutItsPosture) {
  const json scene = json::parse(ellipse_scene_json(estimate(), 3'000'000'001));
  EXPECT_EQ(scene["deletions"].size(), 0U);
  const json& entity = scene["entities"].at(0);
  EXPECT_EQ(entity["frame_id"], "shoulder");
  EXPECT_EQ(entity["timestamp"], (json{{"sec", 3}, {"nsec", 1}}));
  const json& points = entity["lines"][0]["points"];
  double farthest_x = 0.0;
  double farthest_y = 0.0;
  for (const json& point : points) {
    farthest_x = std::max(farthest_x, std::abs(point["x"].get<double>() - 0.1));
    farthest_y = std::max(farthest_y, std::abs(point["y"].get<double>() - 0.52));
  }
  // 300 N/m along y, 100 N/m along x; 0.2 mm for 1 N/m.
  EXPECT_NEAR(farthest_y, 0.06, 1e-9);
  EXPECT_NEAR(farthest_x, 0.02, 1e-9);
}

TEST(DerivedTopics, AnEstimateWithoutEllipseDeletesWhatWasDrawn) {
  auto none = estimate();
  none.status(v1::ESTIMATE_UNDETERMINED);
  const json scene = json::parse(ellipse_scene_json(none, 0));
  EXPECT_EQ(scene["entities"].size(), 0U);
  EXPECT_EQ(scene["deletions"].at(0)["id"], "07" + std::string(30, '0'));
}

/// The fields of our own topics that a layout's panels ask for.
std::vector<std::string> paths_in(const json& layout) {
  std::vector<std::string> paths;
  for (const auto& [id, panel] : layout["configById"].items()) {
    if (panel.contains("paths")) {
      for (const json& path : panel["paths"]) paths.push_back(path["value"]);
    }
    if (panel.contains("topics")) {
      for (const auto& [topic, settings] : panel["topics"].items()) paths.push_back(topic);
    }
    if (panel.contains("topicPath")) paths.push_back(panel["topicPath"]);
  }
  return paths;
}

TEST(DerivedTopics, TheShippedLayoutAsksForTopicsAndFieldsThatExist) {
  const auto text = read_text_file(testing::source_file("deploy/foxglove/tonus.json"));
  ASSERT_TRUE(text);
  const auto offered = offered_topics();
  v1::SampleBlock block;
  block.samples({v1::RigSample()});
  const json hand = json::parse(hand_json(block, RigGeometry(), {}).value());
  const auto paths = paths_in(json::parse(*text));
  EXPECT_GE(paths.size(), 6U);
  for (const std::string& path : paths) {
    const std::string topic = path.substr(0, path.find('.'));
    EXPECT_TRUE(std::any_of(offered.begin(), offered.end(), [&](const OfferedTopic& one) {
      return one.channel.topic == topic;
    })) << topic;
    if (topic != kHandTopic) continue;
    std::string pointer = path.substr(topic.size());
    std::replace(pointer.begin(), pointer.end(), '.', '/');
    EXPECT_TRUE(hand.contains(json::json_pointer(pointer))) << path;
  }
}

}  // namespace
}  // namespace tonus::dashboard
