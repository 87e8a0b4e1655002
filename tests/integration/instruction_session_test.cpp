#include <Eigen/Core>
#include <fstream>
#include <gtest/gtest.h>
#include <map>

#include "services/simulation/instruction.hpp"
#include "services/simulation/true_impedance.hpp"
#include "tests/integration/demo_run.hpp"

namespace tonus::testing {
namespace {

constexpr const char* kProtocol = R"(schema = 1
kind = "instruction"
name = "short"
[[posture]]
name = "reference"
position_m = [0.0, 0.38]
[[instruction]]
name = "relax"
text = "Relax."
[[instruction]]
name = "stiffen_x"
text = "Stiffen to the sides."
[perturbation]
directions = 8
sets = 1
amplitude_m = 0.005
rise_time_s = 0.2
hold_s = [1.5, 2.0]
wait_s = [0.5, 1.0]
)";

TEST(InstructionSession, ShowsThatTheSimulatedSubjectFollowsItsInstructions) {
  const TemporaryFolder folder;
  std::ofstream(folder / "short.toml") << kProtocol;
  DemoRun demo({(folder / "short.toml").string(), "--seed", "3"});
  ASSERT_EQ(demo.finish(), 0) << demo.everything_printed();
  std::map<std::string, Eigen::Matrix2d> stiffness;
  for (const auto& estimate : demo.archived().estimates) {
    const auto& k = estimate.value.stiffness_N_per_m().value();
    stiffness[estimate.value.instruction()] << k[0], k[1], k[2], k[3];
  }
  ASSERT_EQ(stiffness.size(), 2U);
  for (const char* name : {"relax", "stiffen_x"}) {
    const auto truth =
        simulation::true_impedance({}, {0.0, 0.38}, simulation::instruction_named(name)).stiffness;
    const double largest = truth.cwiseAbs().maxCoeff();
    EXPECT_LT((stiffness.at(name) - truth).cwiseAbs().maxCoeff(), 0.04 * largest)
        << name << "\n"
        << stiffness.at(name) << "\n"
        << truth;
  }
}

}  // namespace
}  // namespace tonus::testing
