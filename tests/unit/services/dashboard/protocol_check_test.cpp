#include "services/dashboard/gateway/protocol_check.hpp"

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "services/core/text_file.hpp"
#include "services/protocol/protocol.hpp"
#include "tests/support/process.hpp"

namespace tonus::dashboard {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;

/// As tests/acceptance uses it: long enough for the shipped protocols.
v1::RigDescription rig() {
  v1::RigDescription description;
  description.kind(v1::RIG_TWO_LINK);
  description.link_lengths_m({0.30, 0.35});
  description.home_m({0.0, 0.45});
  description.force_calibration_N_per_V({10.0, 0.0, 0.0, 10.0});
  description.force_saturation_V(10.0);
  return description;
}

std::string shipped(const char* name) {
  return read_text_file(testing::source_file(std::string("deploy/protocols/") + name)).value();
}

json checked(const std::string& text, const std::optional<v1::RigDescription>& on = rig()) {
  return json::parse(check_protocol(text, 7, on));
}

std::string with(std::string text, const std::string& old_line, const std::string& new_line) {
  const auto at = text.find(old_line);
  EXPECT_NE(at, std::string::npos) << old_line;
  return text.replace(at, old_line.size(), new_line);
}

int line_of(const std::string& text, const std::string& part) {
  return 1 + static_cast<int>(
                 std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(text.find(part)), '\n'));
}

TEST(ProtocolCheck, APreviewHasTrialsMinutesAndExtremesBesideTheRigsLimits) {
  const json answer = checked(shipped("loaded.toml"));
  EXPECT_EQ(answer["is_accepted"], true);
  EXPECT_EQ(answer["problem"], nullptr);
  EXPECT_EQ(answer["kind"], "loaded");
  const json& preview = answer["preview"];
  EXPECT_EQ(preview["trials"], 288) << "3 postures, 6 sets, 16 trials, as the file's first line says";
  EXPECT_EQ(preview["postures"].size(), 3U);
  EXPECT_GT(preview["duration_s"], 288 * 6.0) << "each trial waits for 3 s, ramps for 2 s, holds for 1 s";
  const auto bias = std::find_if(preview["extremes"].begin(), preview["extremes"].end(),
                                 [](const json& one) { return one["what"] == "bias force"; });
  ASSERT_NE(bias, preview["extremes"].end());
  EXPECT_EQ((*bias)["value"], 1.0) << "the largest of force_N";
  EXPECT_EQ((*bias)["unit"], "N");
}

TEST(ProtocolCheck, ARefusalNamesKeyAndLineAndKeepsTheDocument) {
  const std::string text = with(shipped("loaded.toml"), "force_N = [0.7, 1.0]", "force_N = 90");
  const json answer = checked(text);
  EXPECT_EQ(answer["is_accepted"], false);
  EXPECT_EQ(answer["problem"]["key"], "bias.force_N");
  EXPECT_EQ(answer["problem"]["line"], line_of(text, "force_N = 90"));
  EXPECT_THAT(answer["problem"]["message"].get<std::string>(), HasSubstr("90 is not allowed; expected"));
  EXPECT_EQ(answer["preview"], nullptr);
  EXPECT_EQ(answer["document"]["bias"]["force_N"], 90);
  EXPECT_EQ(answer["document"]["posture"][2]["name"], "distal");
}

TEST(ProtocolCheck, AMissingKeyAnUnknownKeyAndAKeyOfAListAreNamed) {
  const std::string loaded = shipped("loaded.toml");
  EXPECT_EQ(checked(with(loaded, "rise_time_s = 0.2 ", "#"))["problem"]["key"], "perturbation.rise_time_s");
  EXPECT_EQ(checked(with(loaded, "rise_time_s = 0.2 ", "rise_tme_s = 0.2 "))["problem"]["key"],
            "perturbation.rise_time_s");
  EXPECT_EQ(checked(with(loaded, "[0.000, 0.520]", "[0.000, 5]"))["problem"]["key"], "posture[3].position_m");
}

TEST(ProtocolCheck, WhatIsNoTomlHasALineAndNoDocument) {
  const json answer = checked("schema = 1\nthis is no protocol\n");
  EXPECT_EQ(answer["is_accepted"], false);
  EXPECT_EQ(answer["document"], nullptr);
  EXPECT_EQ(answer["problem"]["key"], "");
  EXPECT_EQ(answer["problem"]["line"], 2);
}

TEST(ProtocolCheck, WhatTheRigCannotRunIsRefused) {
  auto small = rig();
  small.link_lengths_m({0.05, 0.05});
  small.home_m({0.0, 0.08});
  const json answer = checked(shipped("unloaded.toml"), small);
  EXPECT_EQ(answer["is_accepted"], false);
  EXPECT_NE(answer["problem"]["message"], "");
}

TEST(ProtocolCheck, WithoutARigAndOfAStudyThereIsNoPreview) {
  for (const json& answer :
       {checked(shipped("unloaded.toml"), std::nullopt), checked(shipped("study.toml"))}) {
    EXPECT_EQ(answer["is_accepted"], true);
    EXPECT_EQ(answer["preview"], nullptr);
  }
}

TEST(ProtocolCheck, KeysAreThoseThatTheCheckerAsksFor) {
  const json kinds = json::parse(protocol_keys_json());
  for (const auto kind : protocol::kProtocolKinds) {
    const auto keys = protocol::protocol_keys(kind);
    const json& given = kinds[protocol::kind_name(kind)];
    ASSERT_EQ(given.size(), keys.size());
    for (std::size_t i = 0; i < keys.size(); ++i) {
      EXPECT_EQ(given[i]["name"], keys[i].name);
      EXPECT_EQ(given[i]["expected"], keys[i].expected);
    }
  }
}

}  // namespace
}  // namespace tonus::dashboard
