// What a person copies from examples/ works with the services as they are.

#include <filesystem>
#include <gmock/gmock.h>

#include "idl/topics.hpp"
#include "services/bus/typed.hpp"
#include "tests/support/process.hpp"
#include "tests/support/temporary_folder.hpp"

namespace tonus::testing {
namespace {

constexpr std::chrono::seconds kLimit{60};

class Examples : public ::testing::TestWithParam<bus::Vendor> {
 protected:
  void SetUp() override {
    bus::BusOptions options;
    options.vendor = GetParam();
    options.domain = domain_;
    options.partition = "rig";
    auto bus = bus::create_bus(options);
    ASSERT_TRUE(bus) << bus.error().message;
    bus_ = std::move(*bus);
  }

  template <typename T>
  bus::TypedWriter<T> publish(const bus::Topic<T>& topic, const T& value) {
    auto writer = bus::TypedWriter<T>::create(*bus_, topic);
    EXPECT_TRUE(writer);
    EXPECT_TRUE(writer->write(value));
    return std::move(*writer);
  }

  const int domain_ = own_domain();
  const TemporaryFolder folder_;
  std::unique_ptr<bus::Bus> bus_;
};

TEST_P(Examples, FastDdsSubscriberPrintsEstimates) {
  v1::Estimate estimate;
  estimate.posture("distal");
  estimate.method("optimal");
  estimate.trials_used(16);
  estimate.stiffness_N_per_m().value({301.5, -20, -30, 150});
  const auto writer = publish(topics::kEstimateCondition, estimate);
  Process example(program("tonus-example-fastdds"), {std::to_string(domain_)}, folder_ / "output");
  EXPECT_TRUE(example.wait_for_output("distal", kLimit)) << example.output();
  EXPECT_THAT(example.output(), ::testing::HasSubstr("301.5"));
}

TEST_P(Examples, CycloneDdsSubscriberPrintsTheSessionsState) {
  v1::SessionState state;
  state.phase(v1::SESSION_PAUSED);
  state.counted(12);
  state.planned(80);
  state.posture("left");
  const auto writer = publish(topics::kSessionState, state);
  Process example(program("tonus-example-cyclonedds"), {std::to_string(domain_)}, folder_ / "output");
  EXPECT_TRUE(example.wait_for_output("phase 4: 12 of 80 trials counted, 0 rejected, posture left", kLimit))
      << example.output();
}

TEST_P(Examples, TypeScriptSubscriberPrintsTheRigsMode) {
  const std::filesystem::path script = std::filesystem::path(TONUS_WEB_FOLDER) / "examples" / "watch_rig.cjs";
  if (!std::filesystem::exists(script)) GTEST_SKIP() << "needs node and the pages' npm packages";
  v1::RigState state;
  state.mode(v1::RIG_IN_TRIAL);
  state.next_sequence(4711);
  const auto writer = publish(topics::kRigState, state);
  Process gateway(
      program("tonus-dashboard"),
      {"--domain", std::to_string(domain_), "--listen", "127.0.0.1:0", "--data", (folder_ / "data").string()},
      folder_ / "gateway.log");
  ASSERT_TRUE(gateway.wait_for_output("dashboard: http", kLimit)) << gateway.output();
  const auto output = gateway.output();
  const auto begin = output.find("http") + 4;
  const auto url = "ws" + output.substr(begin, output.find('\n', begin) - begin);
  Process example(TONUS_NODE, {script, url}, folder_ / "output");
  EXPECT_TRUE(example.wait_for_output("mode RIG_IN_TRIAL, 4711 samples", kLimit)) << example.output();
}

INSTANTIATE_TEST_SUITE_P(Vendors, Examples,
                         ::testing::Values(bus::Vendor::kFastDds, bus::Vendor::kCycloneDds),
                         [](const auto& parameter) {
                           return std::string(bus::vendor_name(parameter.param));
                         });

}  // namespace
}  // namespace tonus::testing
