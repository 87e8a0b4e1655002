#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "idl/topics.hpp"
#include "services/bus/memory/memory_fabric.hpp"
#include "services/runtime/health.hpp"
#include "services/runtime/version.hpp"

namespace tonus::runtime {
namespace {

using ::testing::HasSubstr;
using namespace std::chrono_literals;

class RosterTest : public ::testing::Test {
 protected:
  RosterTest() {
    clock_.advance(1h);
    bus_options_.vendor = bus::Vendor::kMemory;
    bus_options_.fabric = std::make_shared<bus::MemoryFabric>();
    bus_ = std::move(*bus::create_bus(bus_options_));
    roster_.emplace(*Roster::create(*bus_, clock_, nullptr));
    writer_.emplace(*bus::TypedWriter<v1::ServiceHealth>::create(*bus_, topics::kServiceHealth));
  }

  /// Health of an archive on another host.
  static v1::ServiceHealth archive() {
    v1::ServiceHealth health;
    health.role(v1::ROLE_ARCHIVE);
    health.name("rig");
    health.instance_id(id_of("service/archive/rig"));
    health.host("server");
    health.process_id(812);
    health.idl_hash(idl_hash());
    health.software_version(kVersion);
    health.is_ready(true);
    return health;
  }
  std::string missing_after(const v1::ServiceHealth& health) {
    EXPECT_TRUE(writer_->write(health));
    roster_->update();
    return roster_->missing({v1::ROLE_ARCHIVE});
  }
  /// An archive of this process that has been up for as long as is said.
  HealthReporter reporter() {
    auto made = HealthReporter::create(*bus_, clock_, v1::ROLE_ARCHIVE, {});
    made->set_state(true, "stores");
    return std::move(*made);
  }
  /// The other archive reports so often, and the reporter hears it.
  void hear(HealthReporter& reporter, v1::ServiceHealth other, int times) {
    for (int i = 0; i < times; ++i) {
      EXPECT_TRUE(writer_->write(other));
      clock_.advance(500ms);
      reporter.publish_if_due();
    }
  }

  bus::BusOptions bus_options_;
  ManualClock clock_;
  std::unique_ptr<bus::Bus> bus_;
  std::optional<Roster> roster_;
  std::optional<bus::TypedWriter<v1::ServiceHealth>> writer_;
};

TEST_F(RosterTest, TakesAServiceOfThisVersionAndContract) { EXPECT_EQ(missing_after(archive()), ""); }

TEST_F(RosterTest, NamesAServiceOfAnotherVersionWithItsHost) {
  auto health = archive();
  health.software_version("9.9.9");
  const auto missing = missing_after(health);
  EXPECT_THAT(missing, HasSubstr("archive on server has version 9.9.9, this program "));
  EXPECT_THAT(missing, HasSubstr("install one version everywhere"));
}

TEST_F(RosterTest, NamesAServiceOfAnotherContractWithItsHostAndVersion) {
  auto health = archive();
  health.idl_hash(id_of("another contract"));
  health.software_version("0.0.1");
  EXPECT_THAT(missing_after(health), HasSubstr("archive on server speaks contract "));
  EXPECT_THAT(missing_after(health), HasSubstr("(version 0.0.1)"));
}

TEST_F(RosterTest, SaysThatAServiceIsThereWhichCannotBeRead) {
  auto raw = bus_->create_writer(topics::kServiceHealth.spec);
  bus::Payload health(40, std::byte{7});  // header and key of a type that has changed
  health[0] = health[2] = health[3] = std::byte{0};
  health[1] = std::byte{1};
  ASSERT_TRUE((*raw)->write(health));
  roster_->update();
  EXPECT_THAT(roster_->missing({v1::ROLE_ARCHIVE}),
              HasSubstr("archive is not there (a service reports here that cannot be read"));
  EXPECT_EQ(roster_->unreadable(), 1U);
}

TEST_F(RosterTest, TheSecondOfTwoIsToldToEndWithNameAndHostOfTheFirst) {
  auto second = reporter();
  auto first = archive();
  first.started_ns(static_cast<std::uint64_t>(clock_.utc_ns()) - 60'000'000'000U);
  hear(second, first, 2);
  EXPECT_TRUE(second.check_alone()) << "a service that was just replaced may be heard once more";
  hear(second, first, 2);
  const auto alone = second.check_alone();
  ASSERT_FALSE(alone);
  EXPECT_EQ(alone.error().code, ErrorCode::kAlreadyExists);
  EXPECT_EQ(alone.error().message,
            "another archive 'rig' is on the bus: process 812 on server; end one of them");
}

TEST_F(RosterTest, TheFirstOfTwoGoesOnReadyWhileTheSecondEnds) {
  auto first = reporter();
  clock_.advance(60s);
  auto second = archive();
  second.started_ns(static_cast<std::uint64_t>(clock_.utc_ns()));
  hear(first, second, 4);
  EXPECT_TRUE(first.check_alone());
  EXPECT_EQ(first.other(), "");
  second.is_leaving(true);
  hear(first, second, 1);
  EXPECT_EQ(first.other(), "");
}

TEST_F(RosterTest, ASecondThatStaysMakesTheFirstNotReadyAndNeverEndsIt) {
  auto first = reporter();
  clock_.advance(60s);
  auto second = archive();
  second.started_ns(0);  // by a clock that is behind
  hear(first, second, 20);
  EXPECT_TRUE(first.check_alone());
  EXPECT_THAT(first.other(), HasSubstr("process 812 on server"));
}

}  // namespace
}  // namespace tonus::runtime
