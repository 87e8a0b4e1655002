#include <gtest/gtest.h>

#include "services/verification/reidentification.hpp"

namespace tonus::verification {
namespace {

store::Session session_with(const std::string& configuration_toml) {
  store::Session session;
  v1::ServiceConfiguration configuration;
  configuration.role(v1::ROLE_IDENTIFICATION);
  configuration.configuration_toml(configuration_toml);
  session.configurations.push_back({configuration, 1});
  return session;
}

/// As a service archives its options where none was given.
constexpr const char* kDefaults =
    "domain=47\nrig=\"rig\"\nnetwork=\"\"\nmethod=\"[state_variable]\"\nmodel=\"[linear]\"\nwindow=1\n"
    "cutoff=10\nnatural-frequency=\"\"\ndamping-ratio=0.1\nforce-sign=1\nexcursion-limit=0.015\n";

TEST(CoreChoice, IsThatOfTheArchivedConfigurationWithItsDefaults) {
  const CoreChoice choice = choose_core(session_with(kDefaults));
  EXPECT_TRUE(choice.is_archived);
  EXPECT_EQ(choice.force_sign, 1.0);
  ASSERT_EQ(choice.core.book.analyses.size(), 1U);
  EXPECT_EQ(choice.core.book.analyses[0].method, impedance::Method::kStateVariable);
  EXPECT_FALSE(choice.core.book.analyses[0].natural_frequency);
}

TEST(CoreChoice, TakesWhatWasSet) {
  const CoreChoice choice = choose_core(
      session_with("method=[\"lowpass\", \"optimal\"]\nmodel=\"[linear,coriolis]\"\nwindow=0.7\nnatural-"
                   "frequency=30\nforce-sign=-1\nexcursion-limit=0.02\n"));
  EXPECT_TRUE(choice.is_archived);
  EXPECT_EQ(choice.force_sign, -1.0);
  ASSERT_EQ(choice.core.book.analyses.size(), 4U);
  EXPECT_EQ(choice.core.book.analyses[3].method, impedance::Method::kOptimal);
  EXPECT_EQ(choice.core.book.analyses[3].model, impedance::Model::kCoriolis);
  EXPECT_EQ(choice.core.book.analyses[0].window, 0.7);
  EXPECT_EQ(choice.core.book.analyses[0].natural_frequency, 30.0);
  EXPECT_EQ(choice.core.judge.excursion, 0.02);
}

TEST(CoreChoice, GoesByTheEstimatesWhereNoConfigurationCanBeRead) {
  store::Session session = session_with("method=\"no such\"\n");
  v1::Estimate estimate;
  estimate.method("lowpass");
  estimate.model("no_damping");
  estimate.window_s(0.8);
  estimate.cutoff_Hz(12.0);
  session.estimates.push_back({estimate, 1});
  const CoreChoice choice = choose_core(session);
  EXPECT_FALSE(choice.is_archived);
  ASSERT_EQ(choice.core.book.analyses.size(), 1U);
  EXPECT_EQ(choice.core.book.analyses[0].method, impedance::Method::kLowpass);
  EXPECT_EQ(choice.core.book.analyses[0].window, 0.8);
  EXPECT_EQ(choice.core.book.analyses[0].cutoff, 12.0);
}

}  // namespace
}  // namespace tonus::verification
