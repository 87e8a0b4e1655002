// Every topic of the contract, from the bus through tonus-dashboard to the npm packages that Foxglove's own
// clients are made of.

#include <fstream>
#include <gmock/gmock.h>
#include <spdlog/fmt/fmt.h>

#include "idl/topics.hpp"
#include "services/bus/bus.hpp"
#include "services/bus/payload.hpp"
#include "tests/contract/gateway/gateway.hpp"
#include "tests/contract/gateway/samples.hpp"

namespace tonus::testing {
namespace {

class GatewayContract : public ::testing::TestWithParam<bus::Vendor> {};

TEST_P(GatewayContract, FoxglovesClientDecodesEveryTopicsMessages) {
  const TemporaryFolder folder;
  const int domain = own_domain();
  bus::BusOptions options;
  options.vendor = GetParam();
  options.domain = domain;
  options.partition = "rig";
  auto bus = bus::create_bus(options);
  ASSERT_TRUE(bus) << bus.error().message;

  const auto samples = sample_messages();
  ASSERT_EQ(samples.size(), topics::kAll.size());
  std::vector<std::unique_ptr<bus::Writer>> writers;
  nlohmann::json expected = nlohmann::json::object();
  for (const auto& sample : samples) {
    auto writer = (*bus)->create_writer(sample.topic);
    ASSERT_TRUE(writer) << writer.error().message;
    writers.push_back(std::move(*writer));
    const auto bytes = bus::padded_copy(sample.payload);
    std::string hex;
    for (const std::byte octet : bytes) hex += fmt::format("{:02x}", std::to_integer<unsigned>(octet));
    expected[std::string(sample.topic.name)] = {{"values", sample.expected}, {"payload", hex}};
  }
  std::ofstream(folder / "expected.json") << expected;

  Gateway gateway(folder, domain, bus::vendor_name(GetParam()));
  const auto url = gateway.url();
  ASSERT_FALSE(url.empty()) << gateway.output();
  Process client(TONUS_NODE, {TONUS_CLIENT, TONUS_WEB_FOLDER, url, folder / "expected.json"},
                 folder / "client.log");
  const auto deadline = std::chrono::steady_clock::now() + kGatewayLimit;
  int code = Process::kStillRunning;
  while (code == Process::kStillRunning && std::chrono::steady_clock::now() < deadline) {
    for (std::size_t i = 0; i < samples.size(); ++i) (void)writers[i]->write(samples[i].payload);
    code = client.wait(std::chrono::milliseconds(100));
  }
  EXPECT_EQ(code, 0) << client.output() << gateway.output();
}

INSTANTIATE_TEST_SUITE_P(Vendors, GatewayContract,
                         ::testing::Values(bus::Vendor::kFastDds, bus::Vendor::kCycloneDds),
                         [](const auto& parameter) {
                           return std::string(bus::vendor_name(parameter.param));
                         });

}  // namespace
}  // namespace tonus::testing
