#include "services/runtime/service_manager.hpp"

#include <array>
#include <cstdlib>
#include <cstring>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include "services/bus/memory/memory_fabric.hpp"
#include "services/core/file_descriptor.hpp"
#include "services/runtime/health.hpp"
#include "tests/support/temporary_folder.hpp"

namespace tonus::runtime {
namespace {

/// The socket that systemd listens on.
class ServiceManagerTest : public ::testing::Test {
 protected:
  ServiceManagerTest() {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    const std::string path = (folder_.path() / "notify").string();
    std::strncpy(address.sun_path, path.c_str(), sizeof(address.sun_path) - 1);
    EXPECT_EQ(bind(socket_.get(), reinterpret_cast<const sockaddr*>(&address), sizeof(address)), 0);
    setenv("NOTIFY_SOCKET", path.c_str(), 1);
  }
  ~ServiceManagerTest() override { unsetenv("NOTIFY_SOCKET"); }

  /// The oldest message; empty: none.
  std::string heard() {
    std::array<char, 1024> text{};
    const auto size = recv(socket_.get(), text.data(), text.size(), MSG_DONTWAIT);
    return size < 0 ? "" : std::string(text.data(), static_cast<std::size_t>(size));
  }

  testing::TemporaryFolder folder_;
  FileDescriptor socket_{socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0)};
};

TEST_F(ServiceManagerTest, HearsThatAServiceIsReadyAliveAndWhatItDoes) {
  tell_service_manager("stores to study.sqlite");
  EXPECT_EQ(heard(), "READY=1\nWATCHDOG=1\nSTATUS=stores to study.sqlite");
}

TEST_F(ServiceManagerTest, AStateCannotBringInAssignmentsOfItsOwn) {
  tell_service_manager("held\nMAINPID=1\nWATCHDOG_USEC=1");
  const std::string text = heard();
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 2) << text;
}

TEST_F(ServiceManagerTest, HearsOfAServiceWithEveryReportOfItsHealthAndOfItsEnd) {
  bus::BusOptions bus_options;
  bus_options.vendor = bus::Vendor::kMemory;
  bus_options.fabric = std::make_shared<bus::MemoryFabric>();
  const auto bus = std::move(*bus::create_bus(bus_options));
  ManualClock clock;
  {
    auto reporter = HealthReporter::create(*bus, clock, v1::ROLE_SCHEDULER, {});
    ASSERT_TRUE(reporter) << reporter.error().message;
    EXPECT_EQ(heard(), "");
    reporter->set_state(false, "waits for the rig");
    reporter->publish_if_due();
    EXPECT_EQ(heard(), "READY=1\nWATCHDOG=1\nSTATUS=not ready: waits for the rig");
    reporter->publish_if_due();
    EXPECT_EQ(heard(), "");
    clock.advance(std::chrono::seconds(1));
    reporter->publish_if_due();
    EXPECT_NE(heard(), "");
  }
  std::string last;
  for (std::string text = heard(); !text.empty(); text = heard()) last = text;
  EXPECT_EQ(last, "STOPPING=1");
}

TEST(WithoutAServiceManager, NothingIsSaid) {
  unsetenv("NOTIFY_SOCKET");
  tell_service_manager("on its own");
}

}  // namespace
}  // namespace tonus::runtime
