#include <gtest/gtest.h>
#include <string>
#include <utility>

#include "services/protocol/protocol.hpp"
#include "tests/support/scheduler_lab/lab.hpp"

namespace tonus::protocol {
namespace {

using scheduler::testing::small_loaded_protocol;
using scheduler::testing::small_protocol;

/// The small protocol with one line replaced.
std::string with(std::string text, const std::string& from, const std::string& to) {
  const auto at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

std::string error_of(const std::string& text) {
  const auto protocol = parse_protocol(text, "p.toml");
  EXPECT_FALSE(protocol.has_value());
  if (protocol) return {};
  EXPECT_EQ(protocol.error().code, ErrorCode::kInvalidArgument);
  return protocol.error().message;
}

TEST(ProtocolParser, ReadsAnUnloadedProtocol) {
  const auto p =
      parse_protocol(small_protocol("shoulder_angle_rad = 0.5\nconfirm_posture = true\n"), "p.toml");
  ASSERT_TRUE(p.has_value()) << p.error().message;
  EXPECT_EQ(p->kind, ProtocolKind::kUnloaded);
  EXPECT_EQ(p->name, "small");
  ASSERT_EQ(p->postures.size(), 2u);
  EXPECT_EQ(p->postures[1].name, "far");
  EXPECT_EQ(p->postures[1].position, Eigen::Vector2d(0.0, 0.52));
  EXPECT_EQ(p->perturbation.directions, 2);
  EXPECT_EQ(p->perturbation.repeats, 1);
  EXPECT_EQ(p->perturbation.hold.low, 1.5);
  EXPECT_EQ(p->perturbation.hold.high, 2.0);
  EXPECT_EQ(p->shoulder_angle, 0.5);
  EXPECT_TRUE(p->confirms_posture);
  EXPECT_EQ(p->cue.target_diameter, 0.010);
}

TEST(ProtocolParser, ReadsALoadedProtocol) {
  const auto p = parse_protocol(small_loaded_protocol(), "p.toml");
  ASSERT_TRUE(p.has_value()) << p.error().message;
  ASSERT_TRUE(p->bias.has_value());
  EXPECT_EQ(p->bias->axes, (std::vector{BiasAxis::kNone, BiasAxis::kMajorPlus, BiasAxis::kMinorMinus}));
  EXPECT_EQ(p->bias->force.low, 0.7);
  EXPECT_EQ(p->bias->hold.low, 1.0);
  EXPECT_EQ(p->bias->hold.high, 1.0);
  EXPECT_EQ(p->bias->method, "state_variable");
}

struct Bad {
  const char* from;
  const char* to;
  const char* message;
};

class BadProtocol : public ::testing::TestWithParam<Bad> {};

TEST_P(BadProtocol, IsRefusedWithFileLineKeyValueAndLimits) {
  EXPECT_EQ(error_of(with(small_protocol(), GetParam().from, GetParam().to)), GetParam().message);
}

INSTANTIATE_TEST_SUITE_P(
    Unloaded, BadProtocol,
    ::testing::Values(
        Bad{"schema = 1", "schema = 2",
            "p.toml:1: schema: 2 is not allowed; expected a whole number, 1 to 1"},
        Bad{"schema = 1\n", "", "p.toml:1: schema is missing; expected a whole number, 1 to 1"},
        Bad{"\"unloaded\"", "\"unload\"",
            "p.toml:2: kind: \"unload\" is not allowed; expected one of unloaded, loaded, instruction, "
            "recording, "
            "study"},
        Bad{"name = \"small\"", "name = \"\"",
            "p.toml:3: name: \"\" is not allowed; expected text of 1 to 80 characters"},
        Bad{"amplitude_m = 0.005", "amplitude_m = 0.5",
            "p.toml:14: perturbation.amplitude_m: 0.5 is not allowed; expected 0.0005 to 0.03 m"},
        Bad{"amplitude_m = 0.005", "amplitude_m = \"5 mm\"",
            "p.toml:14: perturbation.amplitude_m: \"5 mm\" is not allowed; expected 0.0005 to 0.03 m"},
        Bad{"amplitude_m = 0.005", "amplitude_m = nan",
            "p.toml:14: perturbation.amplitude_m: nan is not allowed; expected 0.0005 to 0.03 m"},
        Bad{"amplitude_m = 0.005\n", "",
            "p.toml:11: perturbation.amplitude_m is missing; expected 0.0005 to 0.03 m"},
        Bad{"amplitude_m = 0.005", "amplitude_mm = 5",
            "p.toml:11: perturbation.amplitude_m is missing; expected 0.0005 to 0.03 m"},
        Bad{"sets = 2", "sets = 2.5",
            "p.toml:13: perturbation.sets: 2.5 is not allowed; expected a whole number, 1 to 20"},
        Bad{"directions = 2", "directions = 0",
            "p.toml:12: perturbation.directions: 0 is not allowed; expected a whole number, 1 to 64"},
        Bad{"hold_s = [1.5, 2.0]", "hold_s = [2.0, 1.5]",
            "p.toml:16: perturbation.hold_s: [2, 1.5] is not allowed; expected [low, high] with low <= high, "
            "or one "
            "number, 0.2 to 30 s"},
        Bad{"hold_s = [1.5, 2.0]", "hold_s = 0.3",
            "p.toml:16: perturbation.hold_s: 0.3 is not allowed; expected at least rise_time_s + end_rest_s "
            "= 0.4 s"},
        Bad{"wait_s = [3.0, 5.0]", "wait_s = [3.0, 500.0]",
            "p.toml:17: perturbation.wait_s: [3, 500] is not allowed; expected [low, high] with low <= high, "
            "or one "
            "number, 0.2 to 60 s"},
        Bad{"[0.0, 0.52]", "[0.0, 0.95]",
            "p.toml:10: posture[2].position_m: [0, 0.95] is not allowed; expected 0.1 to 0.9 m from the "
            "shoulder "
            "(this is 0.950 m)"},
        Bad{"[0.0, 0.52]", "[0.0, 0.3, 0.1]",
            "p.toml:10: posture[2].position_m: [0, 0.3, 0.1] is not allowed; expected [x, y], each -1 to 1 "
            "m"},
        Bad{"\"far\"", "\"near\"",
            "p.toml:9: posture[2].name: \"near\" is not allowed; expected each name once"},
        Bad{"\"far\"", "\"far away\"",
            "p.toml:9: posture[2].name: \"far away\" is not allowed; expected letters, digits, _ and - only"},
        Bad{"sets = 2\n", "sets = 2\nspeed = 1\n",
            "p.toml:14: perturbation.speed: unknown key; expected one of amplitude_m, directions, "
            "end_rest_s, "
            "first_direction_deg, hold_s, repeats, rise_time_s, second_amplitude_m, sets, wait_s"},
        Bad{"sets = 2\n", "sets = 2\nrepeatz = 1\n",
            "p.toml:14: perturbation.repeatz: unknown key; did you mean repeats?"},
        Bad{"name = \"small\"", "name = \"small\"\nrejection_limit = 0",
            "p.toml:4: rejection_limit: 0 is not allowed; expected a whole number, 1 to 1000"},
        Bad{"name = \"small\"", "name = \"small\"\nconfirm_posture = 1",
            "p.toml:4: confirm_posture: 1 is not allowed; expected true or false"},
        Bad{"name = \"small\"", "name = \"small\"\nbias = 1",
            "p.toml:4: bias: unknown key; expected one of antagonists, confirm_posture, "
            "cue, kind, limits, name, perturbation, "
            "posture, reference_contraction, "
            "rejection_limit, schema, shoulder_angle_rad, stop_when"}));

TEST(ProtocolParser, RefusesAnEarlyEndBesideReferenceContractions) {
  const std::string text = with(small_protocol(), "sets = 2", "sets = 8") +
                           "\n[stop_when]\nstiffness = 0.05\n[reference_contraction]\ntrials = 2\n";
  EXPECT_NE(error_of(text).find("expected none beside reference_contraction"), std::string::npos)
      << error_of(text);
}

TEST(ProtocolParser, RefusesABiasThatDoesNotFitItsSets) {
  EXPECT_EQ(
      error_of(with(small_loaded_protocol(), "\"-minor\"]", "\"-minor\", \"none\"]")),
      "p.toml:15: bias.sets_along: [\"none\", \"+major\", \"-minor\", \"none\"] is not allowed; expected one "
      "entry for each "
      "of the 3 sets");
  EXPECT_EQ(
      error_of(with(small_loaded_protocol(), "[\"none\"", "[\"+minor\"")),
      "p.toml:15: bias.sets_along: [\"+minor\", \"+major\", \"-minor\"] is not allowed; expected none as the "
      "first: the stiffness of set one gives the axes");
  EXPECT_EQ(
      error_of(with(small_loaded_protocol(), "threshold_N = 0.2", "threshold_N = 0.8")),
      "p.toml:19: bias.threshold_N: 0.8 is not allowed; expected less than the smallest bias force, 0.7 N");
}

TEST(ProtocolParser, NamesTheLineOfWhatIsNoToml) {
  const auto message = error_of("schema = 1\nkind = \n");
  EXPECT_EQ(message.rfind("p.toml:2: not TOML: ", 0), 0u) << message;
}

TEST(ProtocolParser, RefusesWhatDoesNotFitOneMessage) {
  EXPECT_EQ(error_of(std::string(40001, '#')),
            "p.toml: a protocol of 40001 bytes is not allowed; expected at most 40000");
}

TEST(ProtocolParser, ReadsRecordingsWholeAndByEvents) {
  const auto p = parse_protocol(R"(schema = 1
kind = "recording"
name = "ankle"
[[recording]]
name = "run-01"
duration_s = 60.0
[[recording]]
name = "run-02"
play = "events"
events = 2
[[recording.event]]
direction_deg = 45.0
[[recording.event]]
set = 2
bias_N = [0.5, 0.0]
)",
                                "p.toml");
  ASSERT_TRUE(p.has_value()) << p.error().message;
  ASSERT_EQ(p->recordings.size(), 2u);
  EXPECT_TRUE(p->recordings[0].is_whole);
  EXPECT_FALSE(p->recordings[1].is_whole);
  EXPECT_EQ(p->recordings[1].events[1].bias, Eigen::Vector2d(0.5, 0.0));
}

TEST(ProtocolParser, RefusesEventsThatAreNotCounted) {
  const std::string head = "schema = 1\nkind = \"recording\"\nname = \"r\"\n[[recording]]\nname = \"a\"\n";
  EXPECT_EQ(error_of(head + "play = \"events\"\n"),
            "p.toml:6: recording[1].play: \"events\" is not allowed; expected \"whole\", or \"events\" "
            "together with "
            "the key "
            "events, their number");
  EXPECT_EQ(
      error_of(head + "play = \"events\"\nevents = 3\n[[recording.event]]\nset = 1\n"),
      "p.toml:7: recording[1].events: 3 is not allowed; expected as many as there are tables [[event]], 1");
}

TEST(ProtocolParser, RefusesMoreTrialsThanASessionHolds) {
  auto text = with(small_protocol(), "directions = 2", "directions = 64\nrepeats = 20");
  text = with(text, "sets = 2", "sets = 20");
  EXPECT_EQ(error_of(text),
            "p.toml:11: perturbation: a protocol of 51200 trials is not allowed; expected 1 to 20000");
}

}  // namespace
}  // namespace tonus::protocol
