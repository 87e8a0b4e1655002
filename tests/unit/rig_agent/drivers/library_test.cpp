#include "rig_agent/drivers/library.hpp"

#include <gtest/gtest.h>

#include "rig_agent/control/rig_loop.hpp"
#include "rig_agent/control/validation.hpp"
#include "services/simulation/profile.hpp"

namespace tonus::drivers {
namespace {

std::string refusal(const std::filesystem::path& file, const std::string& options = "") {
  const auto loaded = Library::load(file, options);
  return loaded ? "accepted" : loaded.error().message;
}

TEST(Library, NamesTheFileThatIsNotThereOrIsNoDriver) {
  EXPECT_EQ(refusal("/nowhere/rig.so"), "driver /nowhere/rig.so: there is no such file");
  EXPECT_NE(refusal(TONUS_SOURCE_DIR "/rig_agent/drivers/tonus_driver.h").find("cannot be loaded"),
            std::string::npos);
  EXPECT_NE(refusal(TONUS_NO_DRIVER).find("is not a driver: it has no function tonus_driver_v1"),
            std::string::npos);
}

TEST(Library, RefusesADriverOfAnotherVersion) {
  EXPECT_NE(refusal(TONUS_FUTURE_DRIVER).find("version: 2"), std::string::npos)
      << refusal(TONUS_FUTURE_DRIVER);
  EXPECT_NE(refusal(TONUS_FUTURE_DRIVER).find("expected 1"), std::string::npos);
}

TEST(Library, HandsOnWhatTheLibrarySaysOfItsOptions) {
  EXPECT_EQ(
      refusal(TONUS_SPRING_RIG, "stiffness=soft"),
      "driver " TONUS_SPRING_RIG
      ": option: stiffness=soft is not allowed; expected stiffness=0..5000 (N/m) and damping=0..500 (N s/m)");
  EXPECT_EQ(refusal(TONUS_SPRING_RIG, "stiffness=100 damping=10"), "accepted");
}

TEST(Library, TakesTheRigsGeometryFromItsDescription) {
  auto driver = Library::load(TONUS_SPRING_RIG, "");
  ASSERT_TRUE(driver) << driver.error().message;
  ASSERT_TRUE((*driver)->configure(0.001));
  EXPECT_EQ((*driver)->geometry().links.l1, 0.30);
  EXPECT_EQ((*driver)->geometry().links.l2, 0.35);
  EXPECT_EQ((*driver)->geometry().force_calibration(1, 1), 4.45);
  EXPECT_TRUE((*driver)->capabilities().has_own_clock);
}

TEST(Library, RunsATrialAndShowsTheHandsStiffnessInIt) {
  // The hand of the example is a spring: at the end of a long hold, force over displacement is its stiffness.
  auto driver = Library::load(TONUS_SPRING_RIG, "stiffness=400 damping=60");
  ASSERT_TRUE(driver) << driver.error().message;
  ASSERT_TRUE((*driver)->configure(0.001));
  ASSERT_TRUE((*driver)->activate());
  auto loop = control::RigLoop::create(**driver, simulation::loop_config(simulation::Profile{}));
  ASSERT_TRUE(loop) << loop.error().message;
  control::Command command;
  command.kind = control::CommandKind::kStartTrial;
  command.program.number = 1;
  command.program.posture = {0.0, 0.38};
  command.program.shoulder = control::shoulder_for({0.30, 0.35}, command.program.posture);
  command.program.wait = 0.5;
  command.program.hold = 4.0;
  ASSERT_TRUE((*loop)->post(command));
  control::TrialResult result;
  control::SampleRecord sample;
  EndpointSample rest;
  EndpointSample end;
  for (int i = 1; i < 20'000 && !(*loop)->next_result(result); ++i) {
    (*loop)->keep_alive();
    (*loop)->step(i * 1'000'000);
    while ((*loop)->next_sample(sample)) {
      const auto endpoint = convert((*driver)->geometry(), command.program.shoulder, sample.raw);
      if (sample.phase == control::Phase::kWaiting) rest = endpoint;
      if (sample.phase == control::Phase::kPerturbing) end = endpoint;
    }
  }
  ASSERT_EQ(result.outcome, control::TrialOutcome::kCompleted) << result.faults;
  const Eigen::Vector2d moved = end.p_SE - rest.p_SE;
  EXPECT_GT(moved.x(), 0.003);
  // One count of each joint is 0.55 mm along x at the handle.
  EXPECT_NEAR((end.f_S - rest.f_S).x(), 400.0 * moved.x(), 400.0 * 0.0006);
}

TEST(Library, HasTheAuxiliaryChannelsThatItDescribesAsTheRigsFileStatesThem) {
  auto driver = Library::load(TONUS_SPRING_RIG, "auxiliary=on");
  ASSERT_TRUE(driver) << driver.error().message;
  (*driver)->state_auxiliary({{"Speed", "MISC", "m/s", 0.001, 2000.0}});
  ASSERT_TRUE((*driver)->configure(0.001));
  const auto channels = (*driver)->auxiliary_channels();
  ASSERT_EQ(channels.size(), 3U);
  EXPECT_EQ(channels[0], (AuxiliaryChannel{"Stretch", "MISC", "mm", 1.0, 1000.0}));
  EXPECT_EQ(channels[1], (AuxiliaryChannel{"Speed", "MISC", "m/s", 0.001, 2000.0}));
  EXPECT_EQ(channels[2].type, "TRIG");
  EXPECT_TRUE((*driver)->capabilities().marks_onset);
}

TEST(Library, RefusesAStatementOfAChannelThatItDoesNotHaveOrOfAnotherRate) {
  const auto refusal_of = [](const AuxiliaryChannel& stated) {
    auto driver = Library::load(TONUS_SPRING_RIG, "auxiliary=on");
    EXPECT_TRUE(driver);
    (*driver)->state_auxiliary({stated});
    const auto configured = (*driver)->configure(0.001);
    return configured ? "accepted" : configured.error().message;
  };
  EXPECT_EQ(refusal_of({"Biceps", "EMG", "mV", 1.0, 2000.0}),
            "driver " TONUS_SPRING_RIG
            ": auxiliary channel Biceps is not allowed; expected one that the library has");
  EXPECT_EQ(refusal_of({"Speed", "MISC", "mm/s", 1.0, 1000.0}),
            "driver " TONUS_SPRING_RIG
            ": auxiliary channel Speed: rate_Hz: 1000 is not allowed; expected 2000, the library's");
}

TEST(Library, OfAnEarlierVersionHasNoAuxiliaryChannels) {
  for (const char* file : {TONUS_FIRST_DRIVER, TONUS_SECOND_DRIVER}) {
    auto driver = Library::load(file, "auxiliary=on");
    ASSERT_TRUE(driver) << driver.error().message;
    ASSERT_TRUE((*driver)->configure(0.001));
    EXPECT_TRUE((*driver)->auxiliary_channels().empty()) << file;
  }
}

}  // namespace
}  // namespace tonus::drivers
