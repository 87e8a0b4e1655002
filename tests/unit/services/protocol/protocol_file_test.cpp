#include "services/protocol/protocol_file.hpp"

#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <map>

#include "services/protocol/plan.hpp"

namespace tonus::protocol {
namespace {

const std::filesystem::path kProtocols = TONUS_PROTOCOLS;

TEST(ProtocolFile, ShippedUnloadedProtocolIsThePublishedOne) {
  const auto p = load_protocol(kProtocols / "unloaded.toml");
  ASSERT_TRUE(p.has_value()) << p.error().message;
  // Dolan, Friedman & Nagurka (1993), "Experimental Procedures": five positions, 8 directions, two sets.
  EXPECT_EQ(build_plan(*p, 1).trials.size(), 80u);
  EXPECT_EQ(p->perturbation.amplitude, 0.005);
  EXPECT_EQ(p->perturbation.wait.low, 3.0);
  EXPECT_EQ(p->perturbation.wait.high, 5.0);
  EXPECT_EQ(p->postures[3].position, Eigen::Vector2d(0.295, 0.380));
}

TEST(ProtocolFile, ShippedLoadedProtocolHasSixSetsOfSixteenAtThreePostures) {
  const auto p = load_protocol(kProtocols / "loaded.toml");
  ASSERT_TRUE(p.has_value()) << p.error().message;
  const Plan plan = build_plan(*p, 1);
  EXPECT_EQ(plan.trials.size(), 288u);
  ASSERT_EQ(plan.blocks.size(), 18u);
  for (const Block& block : plan.blocks) EXPECT_EQ(block.order.size(), 16u);
}

TEST(ProtocolFile, ShippedInstructionProtocolRunsEachInstruction) {
  const auto p = load_protocol(kProtocols / "instruction.toml");
  ASSERT_TRUE(p.has_value()) << p.error().message;
  std::map<std::string, int> trials;
  for (const auto& trial : build_plan(*p, 1).trials) ++trials[trial.program.instruction()];
  EXPECT_EQ(trials, (std::map<std::string, int>{{"relax", 16}, {"stiffen_x", 16}, {"stiffen_y", 16}}));
}

TEST(ProtocolFile, ShippedStudyHasThePublishedCohort) {
  const auto p = load_protocol(kProtocols / "study.toml");
  ASSERT_TRUE(p.has_value()) << p.error().message;
  EXPECT_EQ(p->subjects.size(), 11u);
  EXPECT_EQ(
      std::count_if(p->subjects.begin(), p->subjects.end(), [](const auto& s) { return !s.loaded.empty(); }),
      3);
}

TEST(ProtocolFile, NamesAFileThatIsNotThere) {
  const auto p = load_protocol(kProtocols / "none.toml");
  ASSERT_FALSE(p.has_value());
  EXPECT_EQ(p.error().code, ErrorCode::kNotFound);
  EXPECT_EQ(p.error().message, (kProtocols / "none.toml").string() + ": no such protocol file");
}

TEST(ProtocolFile, RefusesAStudyWhosePartIsOfAnotherKind) {
  const auto folder = std::filesystem::path(::testing::TempDir()) / "tonus_study_test";
  std::filesystem::create_directories(folder);
  std::filesystem::copy_file(kProtocols / "loaded.toml", folder / "loaded.toml",
                             std::filesystem::copy_options::overwrite_existing);
  std::ofstream(folder / "study.toml")
      << "schema = 1\nkind = \"study\"\nname = \"s\"\n[[subject]]\nname = \"a\"\n"
         "unloaded = \"loaded.toml\"\n";
  const auto p = load_protocol(folder / "study.toml");
  std::filesystem::remove_all(folder);
  ASSERT_FALSE(p.has_value());
  EXPECT_EQ(p.error().message,
            (folder / "study.toml").string() +
                ":6: subject[1].unloaded: \"loaded.toml\" is not allowed; expected a protocol of kind "
                "unloaded (this is of kind loaded)");
}

}  // namespace
}  // namespace tonus::protocol
