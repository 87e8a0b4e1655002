// The comedi driver over a stand-in for the library's calls: it has not met a card.
#include "rig_agent/drivers/comedi.hpp"

#include <gtest/gtest.h>

#include "services/simulation/profile.hpp"
#include "tests/unit/rig_agent/drivers/driver_contract.hpp"
#include "tests/unit/rig_agent/drivers/fake_comedi.hpp"

namespace tonus::drivers {
namespace {

constexpr char kWiring[] = R"(
[comedi]
encoders = { subdevice = 3, channel = [0, 1] }
force = { subdevice = 0, channel = [0, 1], reference = "differential" }
motors = { subdevice = 1, channel = [0, 1], torque_Nm_per_V = [2.5, -2.0] }
emergency_stop = { subdevice = 2, channel = 4 }
)";

ComediConfig wiring(const std::string& text = kWiring) {
  auto config = parse_comedi_config(text, "wiring.toml");
  EXPECT_TRUE(config) << (config ? "" : config.error().message);
  return config ? *config : ComediConfig{};
}

std::string refusal(const std::string& text) {
  const auto config = parse_comedi_config(text, "wiring.toml");
  return config ? "accepted" : config.error().message;
}

std::unique_ptr<Driver> make_driver() {
  fake_card() = FakeCard{};
  return std::make_unique<Comedi>(wiring(), simulation::rig_geometry(simulation::Profile{}));
}

INSTANTIATE_TEST_SUITE_P(Comedi, DriverContract, ::testing::Values(DriverCandidate{"Comedi", make_driver}),
                         [](const auto& candidate) { return candidate.param.name; });

class ComediDriver : public ::testing::Test {
 protected:
  void SetUp() override { fake_card() = FakeCard{}; }

  void activate() {
    driver_ = std::make_unique<Comedi>(config_, simulation::rig_geometry(simulation::Profile{}));
    const auto configured = driver_->configure(0.001);
    ASSERT_TRUE(configured) << configured.error().message;
    ASSERT_TRUE(driver_->activate());
  }
  Reading read() {
    Reading reading;
    EXPECT_EQ(driver_->read(reading), DriverStatus::kOk);
    return reading;
  }
  std::string configure_refusal() {
    driver_ = std::make_unique<Comedi>(config_, simulation::rig_geometry(simulation::Profile{}));
    const auto configured = driver_->configure(0.001);
    return configured ? "accepted" : configured.error().message;
  }

  ComediConfig config_ = wiring();
  std::unique_ptr<Comedi> driver_;
};

TEST_F(ComediDriver, ReadsVoltsOverTheChannelsRange) {
  activate();
  fake_card().volts_in = {2.5, -7.25};
  const Reading reading = read();
  EXPECT_NEAR(reading.raw.force_V[0], 2.5, 20.0 / 65535);
  EXPECT_NEAR(reading.raw.force_V[1], -7.25, 20.0 / 65535);
}

TEST_F(ComediDriver, FollowsAJointThroughTheWrapOfItsCounterInBothDirections) {
  activate();
  fake_card().counter = {65'530, 5};
  const auto start = read().raw.encoder_count;
  fake_card().counter = {4, 65'531};  // 10 on, and 10 back.
  const auto end = read().raw.encoder_count;
  EXPECT_EQ(end[0] - start[0], 10.0);
  EXPECT_EQ(end[1] - start[1], -10.0);
}

TEST_F(ComediDriver, SetsTheCountersUpAndCountsFromZeroWhereAModeIsGiven) {
  config_.counter_mode = 0x30;
  activate();
  EXPECT_EQ(fake_card().armed_counters, 2);
  EXPECT_EQ(fake_card().counter_mode, 0x30U);
  EXPECT_EQ(read().raw.encoder_count, (std::array<double, 2>{0.0, 0.0}));
}

TEST_F(ComediDriver, KeepsTheCountsOfCountersThatSomebodyElseHasSetUp) {
  fake_card().counter = {1234, 40'000};
  activate();
  EXPECT_EQ(fake_card().armed_counters, 0);
  EXPECT_EQ(read().raw.encoder_count, (std::array<double, 2>{1234.0, 40'000.0}));
}

TEST_F(ComediDriver, WritesTorqueAsVoltsWithEachMotorsFactorAndClipsAtTheRange) {
  activate();
  ASSERT_EQ(driver_->write({5.0, 5.0}), DriverStatus::kOk);
  EXPECT_NEAR(fake_card().volts_out(0), 2.0, 20.0 / 65535);
  EXPECT_NEAR(fake_card().volts_out(1), -2.5, 20.0 / 65535);
  ASSERT_EQ(driver_->write({1000.0, 1000.0}), DriverStatus::kOk);
  EXPECT_EQ(fake_card().output[0], 65'535U);
  EXPECT_EQ(fake_card().output[1], 0U);
}

TEST_F(ComediDriver, LeavesNoTorqueWhenItIsConfiguredDeactivatedRefusedOrGone) {
  const double step = 20.0 / 65535;
  const auto expect_no_torque = [&] {
    EXPECT_NEAR(fake_card().volts_out(0), 0.0, step);
    EXPECT_NEAR(fake_card().volts_out(1), 0.0, step);
  };
  activate();
  expect_no_torque();
  ASSERT_EQ(driver_->write({5.0, 5.0}), DriverStatus::kOk);
  EXPECT_EQ(driver_->write({std::numeric_limits<double>::quiet_NaN(), 5.0}), DriverStatus::kFailed);
  expect_no_torque();
  ASSERT_EQ(driver_->write({5.0, 5.0}), DriverStatus::kOk);
  driver_->deactivate();
  expect_no_torque();
  ASSERT_TRUE(driver_->activate());
  ASSERT_EQ(driver_->write({5.0, 5.0}), DriverStatus::kOk);
  driver_.reset();
  expect_no_torque();
  EXPECT_EQ(fake_card().open_cards, 0);
}

TEST_F(ComediDriver, SaysThatACardThatDoesNotAnswerIsDisconnected) {
  activate();
  fake_card().is_connected = false;
  Reading reading;
  EXPECT_EQ(driver_->read(reading), DriverStatus::kDisconnected);
  EXPECT_EQ(driver_->write({0.0, 0.0}), DriverStatus::kFailed);
  fake_card().is_connected = true;
  EXPECT_EQ(driver_->read(reading), DriverStatus::kOk);
}

TEST_F(ComediDriver, ReadsTheEmergencyStopFromItsLineAndTheSenseThatTheWiringSays) {
  activate();
  EXPECT_FALSE(read().is_emergency_stop_pressed);
  fake_card().line[4] = 1;
  EXPECT_TRUE(read().is_emergency_stop_pressed);
  config_.is_pressed_when_high = false;
  activate();
  EXPECT_FALSE(read().is_emergency_stop_pressed);
  fake_card().line[4] = 0;
  EXPECT_TRUE(read().is_emergency_stop_pressed);
}

TEST_F(ComediDriver, TakesTheEndOfTheConvertersRangeForASaturatedSensor) {
  fake_card().input_range = {-5.0, 5.0};
  activate();
  fake_card().volts_in = {7.0, 0.0};
  EXPECT_GE(read().raw.force_V[0], driver_->geometry().force_saturation_V);
  fake_card().volts_in = {4.99, 0.0};
  EXPECT_LT(read().raw.force_V[0], driver_->geometry().force_saturation_V);
}

TEST_F(ComediDriver, NamesWhatIsNotThere) {
  fake_card().is_there = false;
  EXPECT_EQ(configure_refusal(), "comedi /dev/comedi0: cannot be opened: No such device");
  fake_card().is_there = true;
  config_.force[1].subdevice = 3;
  EXPECT_NE(configure_refusal().find("type of subdevice 3 of the force: "), std::string::npos);
  config_ = wiring();
  config_.motors[1].channel = 7;
  EXPECT_NE(configure_refusal().find("channel of the motor: 7 is not allowed; expected 0 to 1"),
            std::string::npos);
  config_ = wiring();
  config_.force[0].range = 3;
  EXPECT_NE(configure_refusal().find("force (subdevice 0, channel 0, range 3)"), std::string::npos);
  config_ = wiring();
  config_.counter_mode = 1;
  fake_card().takes_counter_modes = false;
  EXPECT_NE(configure_refusal().find("encoder's counter"), std::string::npos);
  EXPECT_EQ(fake_card().open_cards, 0);
}

TEST(ComediConfig, RefusesAWiringThatIsNotWholeWithOneLine) {
  EXPECT_EQ(refusal(""), "wiring.toml: comedi is missing; expected a table [comedi]");
  EXPECT_EQ(
      refusal("[comedi]\nencoders = { subdevice = 3 }"),
      "wiring.toml:2: comedi.encoders.channel is missing; expected one or two whole numbers, each 0 to 255");
  EXPECT_EQ(refusal("[comedi]\nencoders = { subdevice = [1, 2, 3], channel = 0 }"),
            "wiring.toml:2: comedi.encoders.subdevice: [1, 2, 3] is not allowed; expected one or two whole "
            "numbers, "
            "each 0 to 255");
  const std::string whole =
      "[comedi]\nencoders = { subdevice = 3, channel = 0 }\nforce = { subdevice = 0, channel = 0 }\n";
  const std::string motors = "motors = { subdevice = 1, channel = 0, torque_Nm_per_V = [1.0, -2.0] }\n";
  EXPECT_EQ(refusal(whole + motors + "voltage = 3\n"),
            "wiring.toml:5: comedi.voltage: unknown key; expected one of auxiliary, device, emergency_stop, "
            "enable, encoders, "
            "force, heartbeat, motors, onset");
  EXPECT_EQ(refusal(whole + "motors = { subdevice = 1, channel = 0, torque_Nm_per_V = [1.0, 0.0] }\n"),
            "wiring.toml:4: comedi.motors.torque_Nm_per_V: [1, 0] is not allowed; expected two numbers from "
            "0.001 to "
            "1000, or their negatives");
  EXPECT_TRUE(parse_comedi_config(whole + motors, "wiring.toml"));
}

}  // namespace
}  // namespace tonus::drivers
