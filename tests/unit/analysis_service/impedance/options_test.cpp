#include "analysis_service/impedance/options.hpp"

#include <functional>
#include <gtest/gtest.h>

namespace tonus::impedance {
namespace {

TEST(Options, AreThePublishedSettingsByDefault) {
  const Options options;
  EXPECT_EQ(options.method, Method::kStateVariable);
  EXPECT_EQ(options.window, 1.0);
  EXPECT_EQ(options.cutoff, 10.0);
  EXPECT_EQ(options.damping_ratio, 0.1);
  EXPECT_FALSE(options.natural_frequency.has_value());
  EXPECT_TRUE(validate(options, 0.005));
}

TEST(Options, AreRefusedOutsideTheirLimitsWithNameValueAndLimit) {
  const std::pair<std::function<void(Options&)>, const char*> cases[] = {
      {[](Options& o) { o.window = 0.0; }, "window: 0 is not allowed; expected 0.05 to 3600 s"},
      {[](Options& o) { o.cutoff = 100.0; },
       "cutoff: 100 is not allowed; expected more than 0 and less than 100 Hz"},
      {[](Options& o) { o.natural_frequency = -1.0; },
       "natural frequency: -1 is not allowed; expected more than 0 and less than 100 Hz"},
      {[](Options& o) { o.damping_ratio = 0.0; },
       "damping ratio: 0 is not allowed; expected more than 0, at most 1"},
      {[](Options& o) { o.rank_margin = 1.0; }, "rank margin: 1 is not allowed; expected between 0 and 1"},
      {[](Options& o) { o.block = 0.0; }, "block: 0 is not allowed; expected 0.05 to 3600 s"},
  };
  for (const auto& [spoil, message] : cases) {
    Options options;
    spoil(options);
    const auto result = validate(options, 0.005);
    ASSERT_FALSE(result) << message;
    EXPECT_EQ(result.error().message, message);
  }
}

TEST(Options, KnowMethodsAndModelsByName) {
  for (const Method method : kEveryMethod) EXPECT_EQ(method_named(name_of(method)).value(), method);
  for (const Model model : kModels) EXPECT_EQ(model_named(name_of(model)).value(), model);
  EXPECT_EQ(
      method_named("kalman").error().message,
      "method: 'kalman' is not allowed; expected one of lowpass, optimal, state_variable, refined, spectral");
}

TEST(Options, OfferEachMethodForTheDataThatItSuits) {
  EXPECT_TRUE(suits(Method::kRefined, false));
  EXPECT_FALSE(suits(Method::kRefined, true));
  EXPECT_FALSE(suits(Method::kSpectral, false));
  EXPECT_TRUE(suits(Method::kSpectral, true));
  for (const Method method : kMethods) EXPECT_TRUE(suits(method, true) && suits(method, false));
}

TEST(Options, LeaveRecordsToSpectralWherePerturbationsAreRefined) {
  const Options options = with_method(Options{}, "refined").value();
  EXPECT_EQ(options.method, Method::kRefined);
  EXPECT_EQ(options.record_method, Method::kSpectral);
}

}  // namespace
}  // namespace tonus::impedance
