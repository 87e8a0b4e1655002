// Whatever becomes of the gateway, the rig's stream goes on.

#include <csignal>
#include <gmock/gmock.h>
#include <thread>

#include "idl/topics.hpp"
#include "services/bus/typed.hpp"
#include "tests/contract/gateway/gateway.hpp"

namespace tonus::testing {
namespace {

class StoppedGateway : public ::testing::TestWithParam<bus::Vendor> {};

/// A client that subscribes to everything, so that the gateway reads the samples.
constexpr char kWatch[] = "--watch";

TEST_P(StoppedGateway, HoldsBackNoWriterOfSamples) {
  const TemporaryFolder folder;
  const int domain = own_domain();
  bus::BusOptions options;
  options.vendor = GetParam();
  options.domain = domain;
  options.partition = "rig";
  auto bus = bus::create_bus(options);
  ASSERT_TRUE(bus) << bus.error().message;
  auto writer = bus::TypedWriter<v1::SampleBlock>::create(**bus, topics::kRigSamples);
  ASSERT_TRUE(writer) << writer.error().message;

  Gateway gateway(folder, domain);
  const auto url = gateway.url();
  ASSERT_FALSE(url.empty()) << gateway.output();
  Process client(TONUS_NODE, {TONUS_CLIENT, TONUS_WEB_FOLDER, url, kWatch}, folder / "client.log");
  ASSERT_TRUE(client.wait_for_output("subscribed", kGatewayLimit)) << client.output();
  const auto deadline = std::chrono::steady_clock::now() + kGatewayLimit;
  while (writer->status().matched_readers == 0) {
    ASSERT_LT(std::chrono::steady_clock::now(), deadline) << "the gateway does not read the samples";
    std::this_thread::yield();
  }

  gateway.signal(SIGSTOP);
  v1::SampleBlock block;
  block.rig_id()[0] = 1;
  block.samples(std::vector<v1::RigSample>(20));
  // More than the writer's whole history: with a reader that it waits for, it would refuse from there on.
  for (int i = 0; i < 3 * topics::kRigSamples.spec.qos.depth; ++i) {
    const auto written = writer->write(block);
    ASSERT_TRUE(written) << "block " << i << ": " << written.error().message;
  }
  gateway.signal(SIGCONT);
  EXPECT_EQ(writer->status().refused, 0U);
}

INSTANTIATE_TEST_SUITE_P(Vendors, StoppedGateway,
                         ::testing::Values(bus::Vendor::kFastDds, bus::Vendor::kCycloneDds),
                         [](const auto& parameter) {
                           return std::string(bus::vendor_name(parameter.param));
                         });

}  // namespace
}  // namespace tonus::testing
