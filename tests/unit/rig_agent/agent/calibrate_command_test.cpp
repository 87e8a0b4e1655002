// Calibration on a simulated bench: what the profile hides from the description is found again.
#include "rig_agent/agent/calibrate_command.hpp"

#include <Eigen/LU>
#include <fstream>
#include <gtest/gtest.h>
#include <spdlog/fmt/fmt.h>

#include "idl/topics.hpp"
#include "services/bus/typed.hpp"
#include "services/simulation/profile.hpp"
#include "tests/support/temporary_folder.hpp"

namespace tonus::rig {
namespace {

class CalibrateCommand : public ::testing::Test {
 protected:
  void SetUp() override {
    options_.by = "Ada";
    clock_.advance(std::chrono::hours(24 * 365));
  }

  /// Runs a step on a bench that the text of a profile describes.
  Result<std::string> run(const CalibrationStep& step, const std::string& profile_text) {
    std::ofstream(folder_ / "profile.toml") << profile_text;
    RigOptions rig_options;
    rig_options.profile = (folder_ / "profile.toml").string();
    auto rig_folder = RigFolder::take(folder_.path(), "rig");
    if (!rig_folder) return rig_folder.error();
    auto rig = Rig::create(rig_options, "rig", rig_folder->calibration());
    if (!rig) return rig.error();
    return step(*rig, *rig_folder, options_, clock_);
  }

  /// The geometry that an agent of the same rig would use next.
  RigGeometry geometry_in_force() {
    RigOptions rig_options;
    auto rig = Rig::create(rig_options, "rig", folder_ / "rig" / "rig" / "calibration.toml");
    EXPECT_TRUE(rig) << (rig ? "" : rig.error().message);
    description_ = describe(rig->names(), rig->driver().geometry());
    return rig->driver().geometry();
  }

  testing::TemporaryFolder folder_;
  CalibrateOptions options_;
  ManualClock clock_;
  v1::RigDescription description_;
};

TEST_F(CalibrateCommand, TareFindsTheOffsetThatTheDescriptionDoesNotKnow) {
  const auto line = run(tare,
                        "[bench]\nis_on = true\nis_clamped = true\n"
                        "[sensors.errors]\noffset_V = [0.31, -0.17]\n");
  ASSERT_TRUE(line) << line.error().message;
  const RigGeometry geometry = geometry_in_force();
  // 2000 samples of 0.05 N through 4.45 N/V: standard error 0.25 mV.
  EXPECT_NEAR(geometry.force_offset_V.x(), 0.31, 0.0013);
  EXPECT_NEAR(geometry.force_offset_V.y(), -0.17, 0.0013);
  EXPECT_EQ(description_.calibrated_by(), "Ada");
  EXPECT_EQ(description_.calibrated_at(), "1971-01-01T00:00:00Z");
  EXPECT_NE(description_.calibration_toml().find("[tare]"), std::string::npos);
}

TEST_F(CalibrateCommand, ZeroFindsTheEncodersZeroAtAKnownPlace) {
  options_.place = {0.30, 0.35};
  const auto line = run(find_zero,
                        "[bench]\nis_on = true\nis_clamped = true\n"
                        "[sensors.errors]\nzero_count = [137.0, -412.0]\n");
  ASSERT_TRUE(line) << line.error().message;
  const RigGeometry geometry = geometry_in_force();
  EXPECT_NEAR(geometry.encoder_zero[0], 137.0, 1.0);
  EXPECT_NEAR(geometry.encoder_zero[1], -412.0, 1.0);
}

TEST_F(CalibrateCommand, ZeroTakesTheJointsAnglesToo) {
  options_.joints = {0.0, 90.0};  // What reaches the home of the simulated rig, 0.30 m and 0.35 m.
  ASSERT_TRUE(run(find_zero,
                  "[bench]\nis_on = true\nis_clamped = true\n"
                  "[sensors.errors]\nzero_count = [25.0, 50.0]\n"));
  EXPECT_NEAR(geometry_in_force().encoder_zero[0], 25.0, 1.0);
  EXPECT_NEAR(geometry_in_force().encoder_zero[1], 50.0, 1.0);
}

TEST_F(CalibrateCommand, ForceFindsTheSensorsMatrixAndOffsetFromKnownWeights) {
  std::string line;
  for (const auto& load :
       std::vector<std::vector<double>>{{9.81, 0.0}, {0.0, 9.81}, {-9.81, 0.0}, {0.0, -9.81}}) {
    options_.load = load;
    const auto taken =
        run(calibrate_force, fmt::format("[bench]\nis_on = true\nis_clamped = true\nload_N = [{}, {}]\n"
                                         "[sensors.errors]\noffset_V = [0.05, 0.08]\n"
                                         "force_row_x = [1.07, 0.04]\nforce_row_y = [-0.03, 0.94]\n",
                                         load[0], load[1]));
    ASSERT_TRUE(taken) << taken.error().message;
    line = *taken;
  }
  EXPECT_NE(line.find("in force"), std::string::npos) << line;
  const RigGeometry geometry = geometry_in_force();
  Eigen::Matrix2d errors;
  errors << 1.07, 0.04, -0.03, 0.94;
  const Eigen::Matrix2d truth = 4.45 * errors.inverse();
  // The noise of the means is 1.1 mN for a load of 9.81 N.
  EXPECT_LT((geometry.force_calibration - truth).cwiseAbs().maxCoeff(), 0.004) << geometry.force_calibration;
  EXPECT_NEAR(geometry.force_offset_V.x(), 0.05, 0.001);
  EXPECT_NEAR(geometry.force_offset_V.y(), 0.08, 0.001);
}

TEST_F(CalibrateCommand, SpringIdentifiesABenchSpringAndComparesItWithItsNominalStiffness) {
  const std::string bench =
      "[bench]\nis_on = true\nspring_N_per_m = [420.0, 420.0]\ndamping_Ns_per_m = 10.0\n";
  options_.nominal = 420.0;
  const auto line = run(check_spring, bench);
  ASSERT_TRUE(line) << line.error().message;
  options_.nominal = 360.0;  // 17 % off.
  const auto wrong = run(check_spring, bench);
  ASSERT_FALSE(wrong);
  EXPECT_NE(wrong.error().message.find("expected at most 5 %"), std::string::npos) << wrong.error().message;
}

TEST_F(CalibrateCommand, SpringLooksAlongTheDirectionInWhichTheSpringActs) {
  const std::string bench =
      "[bench]\nis_on = true\nspring_N_per_m = [500.0, 200.0]\ndamping_Ns_per_m = 20.0\n";
  options_.nominal = 200.0;
  options_.direction = 90.0;
  const auto line = run(check_spring, bench);
  ASSERT_TRUE(line) << line.error().message;
  options_.nominal = 500.0;
  options_.direction = 0.0;
  EXPECT_TRUE(run(check_spring, bench));
}

TEST_F(CalibrateCommand, LeavesADescriptionThatFitsIntoItsTopicWhenEverythingWasDone) {
  const calibration::Signature signature{"2026-03-01T12:00:00Z",
                                         std::string(calibration::Calibration::kLongestName, 'x')};
  const Eigen::Vector2d longest(-0.123456789123, -1234.56789123);
  const calibration::RestReading reading{{-1234.56789, 1234.56789}, longest, longest, 60'000};
  calibration::Calibration calibration("simulated");
  calibration.set_tare(reading, signature);
  calibration.set_zero(reading, longest, {-1234.56789, 1234.56789}, signature);
  for (std::size_t i = 0; i < calibration::Calibration::kMostLoads; ++i)
    ASSERT_TRUE(calibration.add_load({longest, longest, -1.23456789123}, signature));
  calibration::ForceFit force;
  force.matrix.fill(-4.45678912345);
  force.offset = longest;
  force.residual = 0.00123456789123;
  calibration.set_force(force, signature);
  calibration::SpringCheck check;
  check.fit.stiffness.fill(-412.345678912);
  check.fit.standard_error.fill(1.23456789123);
  check.measured = 412.345678912;
  check.nominal = 411.123456789;
  check.direction = "123.456789 deg";
  calibration.set_spring(check, signature);

  RigNames names;
  names.name = std::string(64, 'n');
  names.driver = "simulated";
  names.calibrated_by = signature.by;
  names.calibration_toml = calibration.text();
  const auto payload = bus::encode(describe(names, RigGeometry{}));
  ASSERT_TRUE(payload);
  EXPECT_LT(payload->size(), topics::kRigDescription.spec.max_payload_bytes);
}

TEST_F(CalibrateCommand, RefusesToAverageARigThatMoves) {
  // Springs on a handle that nobody holds, and weights that pull it.
  const auto line =
      run(tare, "[bench]\nis_on = true\nspring_N_per_m = [300.0, 300.0]\nload_N = [5.0, 0.0]\n");
  ASSERT_FALSE(line);
  EXPECT_NE(line.error().message.find("the rig is not at rest"), std::string::npos) << line.error().message;
  EXPECT_TRUE(geometry_in_force().force_offset_V.isZero());
}

TEST_F(CalibrateCommand, RunsOnARigThatNoOtherProgramUses) {
  const auto agents = RigFolder::take(folder_.path(), "rig");
  ASSERT_TRUE(agents);
  const auto line = run(tare, "[bench]\nis_on = true\nis_clamped = true\n");
  ASSERT_FALSE(line);
  EXPECT_EQ(line.error().code, ErrorCode::kUnavailable);
  EXPECT_NE(line.error().message.find("rig 'rig' is in use"), std::string::npos) << line.error().message;
}

}  // namespace
}  // namespace tonus::rig
