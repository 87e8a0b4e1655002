// The rule of services/contract/README.md: rooms that compute know nothing of the generated wire types.

#include <filesystem>
#include <fstream>
#include <gmock/gmock.h>
#include <string>
#include <vector>

namespace tonus {
namespace {

namespace fs = std::filesystem;

const std::vector<std::string> kRoomsWithoutWireTypes = {"services/core",
                                                         "services/mechanics",
                                                         "services/config",
                                                         "services/simulation",
                                                         "services/recording",
                                                         "rig_agent/control",
                                                         "rig_agent/drivers",
                                                         "rig_agent/calibration",
                                                         "analysis_service/impedance",
                                                         "analysis_service/identification"};

bool names_wire_types(const fs::path& file) {
  std::ifstream in(file);
  for (std::string line; std::getline(in, line);) {
    if (line.find("#include <idl/") != std::string::npos || line.find("#include \"idl/") != std::string::npos)
      return true;
    if (line.substr(0, line.find("//")).find("v1::") != std::string::npos) return true;
  }
  return false;
}

TEST(WireTypes, DoNotAppearInRoomsThatCompute) {
  std::vector<std::string> offenders;
  for (const auto& room : kRoomsWithoutWireTypes) {
    const fs::path folder = fs::path(TONUS_SOURCE_DIR) / room;
    ASSERT_TRUE(fs::is_directory(folder)) << folder;
    for (const auto& entry : fs::recursive_directory_iterator(folder)) {
      const auto extension = entry.path().extension();
      if ((extension == ".hpp" || extension == ".cpp") && names_wire_types(entry.path()))
        offenders.push_back(fs::relative(entry.path(), TONUS_SOURCE_DIR).string());
    }
  }
  EXPECT_THAT(offenders, ::testing::IsEmpty());
}

}  // namespace
}  // namespace tonus
