#include <cstdlib>
#include <fstream>
#include <unistd.h>

#include "tests/contract/bus/contract_fixture.hpp"

namespace tonus::bus::test {
namespace {

/// What another program on this machine may have set. `file` is the contents of a file that it names.
struct Leak {
  const char* variable;
  const char* value;
  const char* file = nullptr;
};

constexpr const char* kOtherServer =
    R"({"environment_variables": {"ROS_DISCOVERY_SERVER": "127.0.0.1:11811"}})";
constexpr const char* kBrokenProfiles = "<profiles><participant profile_name='a' is_default_profile='true'>";

constexpr Leak kLeaks[] = {
    {"ROS_DISCOVERY_SERVER", "127.0.0.1:11811"},
    {"FASTDDS_ENVIRONMENT_FILE", nullptr, kOtherServer},
    {"FASTRTPS_DEFAULT_PROFILES_FILE", nullptr, kBrokenProfiles},
    {"FASTDDS_STATISTICS", "NETWORK_LATENCY_TOPIC;RTPS_SENT_TOPIC;RTPS_LOST_TOPIC"},
    {"FASTDDS_NAME_OF_A_LATER_VERSION", "1"},
    {"CYCLONEDDS_URI",
     "<CycloneDDS><Domain Id='any'><Discovery><Tag>elsewhere</Tag></Discovery></Domain></CycloneDDS>"},
    {"CYCLONEDDS_NAME_OF_A_LATER_VERSION", "1"}};

class VendorEnvironment : public testing::TestWithParam<std::tuple<Vendor, Leak>> {
 protected:
  void SetUp() override {
    const Leak& leak = std::get<1>(GetParam());
    std::string value = leak.value != nullptr ? leak.value : "";
    if (leak.file != nullptr) {
      value = file_;
      std::ofstream(file_) << leak.file;
    }
    setenv(leak.variable, value.c_str(), 1);
  }
  void TearDown() override { std::remove(file_.c_str()); }

  std::string file_ = testing::TempDir() + "tonus_environment_" + std::to_string(getpid());
};

INSTANTIATE_TEST_SUITE_P(Leaks, VendorEnvironment,
                         testing::Combine(testing::Values(Vendor::kFastDds, Vendor::kCycloneDds),
                                          testing::ValuesIn(kLeaks)),
                         [](const auto& one) {
                           return std::string(vendor_name(std::get<0>(one.param))) + "_" +
                                  std::get<1>(one.param).variable;
                         });

TEST_P(VendorEnvironment, DoesNotLeakIntoParticipants) {
  const auto& [vendor, leak] = GetParam();
  const TopicSpec spec = topic("contract/environment", state());

  auto one = open_bus(bus_options(vendor));
  auto other = open_bus(bus_options(vendor));
  auto writer = one->create_writer(spec);
  auto reader = other->create_reader(spec, nullptr);

  ASSERT_TRUE(writer && reader);
  EXPECT_TRUE(are_matched(**writer, **reader));
  EXPECT_EQ(std::getenv(leak.variable), nullptr);
  EXPECT_STREQ(std::getenv("SKIP_DEFAULT_XML_FILE"), "1");
}

TEST(VendorEnvironmentOfOthers, IsLeftAlone) {
  for (const char* name : {"TONUS_DOMAIN", "ROS_DOMAIN_ID", "MY_FASTDDS_FOLDER"}) {
    setenv(name, "5", 1);
    (void)open_bus(bus_options(Vendor::kFastDds));
    EXPECT_STREQ(std::getenv(name), "5");
    unsetenv(name);
  }
}

}  // namespace
}  // namespace tonus::bus::test
