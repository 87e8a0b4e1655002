#include "services/runtime/configuration.hpp"

#include <CLI/CLI.hpp>
#include <gtest/gtest.h>
#include <toml++/toml.h>

#include "idl/topics.hpp"
#include "services/bus/memory/memory_fabric.hpp"
#include "services/core/passwords.hpp"
#include "services/runtime/drain.hpp"
#include "services/runtime/health.hpp"
#include "services/runtime/options.hpp"

namespace tonus::runtime {
namespace {

class ConfigurationTest : public ::testing::Test {
 protected:
  ConfigurationTest() {
    add_common_options(app_, common_);
    app_.add_option("--store", store_)->capture_default_str();
    app_.add_option("--limit-MB", limit_)->capture_default_str();
    app_.add_flag("--fast", is_fast_);
  }

  toml::table parse(std::vector<const char*> words) {
    words.insert(words.begin(), "program");
    EXPECT_EQ(parse_command_line(app_, static_cast<int>(words.size()), const_cast<char**>(words.data())), -1);
    return toml::parse(common_.configuration);
  }

  CLI::App app_{"made up", "program"};
  CommonOptions common_;
  std::string store_ = "study.sqlite";
  int limit_ = 5;
  bool is_fast_ = false;
};

TEST_F(ConfigurationTest, IsTomlWithEveryOptionAndItsDefault) {
  const auto table = parse({});
  EXPECT_EQ(table["domain"].value<int>(), 47);
  EXPECT_EQ(table["dds"].value<std::string>(), "fastdds");
  EXPECT_EQ(table["rig"].value<std::string>(), "rig");
  EXPECT_EQ(table["log"].value<std::string>(), "info");
  EXPECT_EQ(table["store"].value<std::string>(), "study.sqlite");
  EXPECT_EQ(table["limit-MB"].value<int>(), 5);
  EXPECT_EQ(table["fast"].value<bool>(), false);
  EXPECT_TRUE(table.contains("data"));
  EXPECT_TRUE(table.contains("peers"));
}

TEST_F(ConfigurationTest, HasTheValuesThatWereGiven) {
  const auto table = parse({"--domain", "3", "--interface", "10.0.0.1", "--peers", "10.0.0.2,10.0.0.3",
                            "--fast", "--limit-MB", "70"});
  EXPECT_EQ(table["domain"].value<int>(), 3);
  EXPECT_EQ(table["limit-MB"].value<int>(), 70);
  EXPECT_EQ(table["fast"].value<bool>(), true);
  EXPECT_EQ(table["interface"].value<std::string>(), "10.0.0.1");
  ASSERT_NE(table["peers"].as_array(), nullptr);
  EXPECT_EQ(table["peers"].as_array()->size(), 2U);
}

TEST_F(ConfigurationTest, ShowsNoPassword) {
  const auto table = parse({"--store", "postgresql://ann:very:secret@host/study?password=secret&x=1"});
  EXPECT_EQ(table["store"].value<std::string>(), "postgresql://ann:***@host/study?password=***&x=1");
  EXPECT_EQ(common_.configuration.find("secret"), std::string::npos);
}

TEST(Passwords, AreLeftOutOfUrlsAndNothingElse) {
  EXPECT_EQ(without_passwords("postgresql://ann@host:5432/study"), "postgresql://ann@host:5432/study");
  EXPECT_EQ(without_passwords("postgresql://ann:p@host:5432/study"), "postgresql://ann:***@host:5432/study");
  EXPECT_EQ(without_passwords("at 10:30 write to ann@host"), "at 10:30 write to ann@host");
  EXPECT_EQ(without_passwords("/data/a:b@c.sqlite"), "/data/a:b@c.sqlite");
}

TEST(ServiceConfiguration, IsPublishedOnceAndReachesWhoComesLate) {
  bus::BusOptions bus_options;
  bus_options.vendor = bus::Vendor::kMemory;
  bus_options.fabric = std::make_shared<bus::MemoryFabric>();
  const auto bus = std::move(*bus::create_bus(bus_options));
  ManualClock clock;
  clock.advance(std::chrono::seconds(9));
  CommonOptions common;
  common.rig = "lab";
  common.configuration = "domain=47\n";
  auto reporter = HealthReporter::create(*bus, clock, v1::ROLE_SCHEDULER, common);
  ASSERT_TRUE(reporter) << reporter.error().message;
  for (int i = 0; i < 3; ++i) {
    clock.advance(std::chrono::seconds(1));
    reporter->publish_if_due();
  }
  auto reader =
      bus::TypedReader<v1::ServiceConfiguration>::create(*bus, topics::kServiceConfiguration, nullptr);
  const auto published = drain(*reader);
  ASSERT_EQ(published.size(), 1U);
  const v1::ServiceConfiguration& configuration = published[0].value;
  EXPECT_EQ(configuration.instance_id(), reporter->instance());
  EXPECT_EQ(configuration.role(), v1::ROLE_SCHEDULER);
  EXPECT_EQ(configuration.name(), "lab");
  EXPECT_EQ(configuration.configuration_toml(), "domain=47\n");
  EXPECT_EQ(configuration.started_ns(), 9'000'000'000U);
  EXPECT_FALSE(configuration.software_version().empty());
}

TEST(Build, NamesItsLibraries) {
  const std::string build = build_text();
  for (const char* word : {"Fast DDS 2.", "Cyclone DDS 0.10", "Eigen 3.4", "SQLite 3."})
    EXPECT_NE(build.find(word), std::string::npos) << word << " in: " << build;
}

}  // namespace
}  // namespace tonus::runtime
