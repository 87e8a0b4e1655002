// The layout that examples/ has for Lichtblick and Foxglove.

#include <gtest/gtest.h>

#include "tests/contract/gateway/gateway.hpp"

namespace tonus::testing {
namespace {

TEST(ExampleLayout, ShowsOnlyTopicsAndFieldsThatTheGatewayOffers) {
  const TemporaryFolder folder;
  Gateway gateway(folder, own_domain());
  const auto url = gateway.url();
  ASSERT_FALSE(url.empty()) << gateway.output();
  Process reader(
      TONUS_NODE,
      {TONUS_LAYOUT_READER, TONUS_WEB_FOLDER, url, source_file("examples/lichtblick/session.json").string()},
      folder / "reader.log");
  EXPECT_EQ(reader.wait(kGatewayLimit), 0) << reader.output() << gateway.output();
}

}  // namespace
}  // namespace tonus::testing
