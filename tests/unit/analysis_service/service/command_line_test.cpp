#include "analysis_service/service/command_line.hpp"

#include <CLI/CLI.hpp>
#include <gmock/gmock.h>

namespace tonus::identification {
namespace {

using ::testing::HasSubstr;
using ::testing::SizeIs;

Result<ServiceSettings> settings_of(const std::string& line) {
  CLI::App app;
  CommandLine command_line;
  command_line.add_to(app);
  app.parse(line);
  return command_line.settings("rig");
}

TEST(CommandLine, IdentifiesByTheStateVariableMethodAndTheLinearModelUnlessToldOtherwise) {
  const auto settings = settings_of("");
  ASSERT_TRUE(settings);
  ASSERT_THAT(settings->core.book.analyses, SizeIs(1));
  EXPECT_EQ(settings->core.book.analyses[0].method, impedance::Method::kStateVariable);
  EXPECT_EQ(settings->core.book.analyses[0].model, impedance::Model::kLinear);
  EXPECT_FALSE(settings->core.book.analyses[0].natural_frequency);
  EXPECT_EQ(settings->rig, id_of("rig/rig"));
}

TEST(CommandLine, TakesTheFilterOfAContinuousRecord) {
  const auto settings = settings_of(
      "--natural-frequency 30 --damping-ratio 0.2 --window 0.8 --force-sign -1 --method state_variable");
  ASSERT_TRUE(settings);
  EXPECT_EQ(settings->core.book.analyses[0].natural_frequency, 30.0);
  EXPECT_EQ(settings->core.book.analyses[0].damping_ratio, 0.2);
  EXPECT_EQ(settings->core.book.analyses[0].window, 0.8);
  EXPECT_EQ(settings->core.live.natural_frequency, 30.0);
  EXPECT_EQ(settings->force_sign, -1.0);
}

TEST(CommandLine, CombinesMethodsAndModels) {
  EXPECT_THAT(settings_of("--method all --model all")->core.book.analyses, SizeIs(21));
  EXPECT_THAT(settings_of("--method lowpass --method optimal --method lowpass")->core.book.analyses,
              SizeIs(2));
}

TEST(CommandLine, RefusesAnUnknownMethodByName) {
  const auto settings = settings_of("--method wavelet");
  ASSERT_FALSE(settings);
  EXPECT_THAT(settings.error().message, HasSubstr("wavelet"));
}

TEST(CommandLine, RefusesASignThatIsNone) {
  EXPECT_THROW((void)settings_of("--force-sign 2"), CLI::ValidationError);
}

}  // namespace
}  // namespace tonus::identification
