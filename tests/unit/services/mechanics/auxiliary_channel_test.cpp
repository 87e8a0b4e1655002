#include "services/mechanics/auxiliary_channel.hpp"

#include <gtest/gtest.h>
#include <limits>

namespace tonus {
namespace {

AuxiliaryChannel emg(const std::string& name = "Biceps") { return {name, "EMG", "mV", 0.5, 2000.0}; }

std::string refusal(const std::vector<AuxiliaryChannel>& channels, double sample_rate = 1000.0) {
  const auto valid = validate(channels, sample_rate);
  return valid ? "accepted" : valid.error().message;
}

TEST(AuxiliaryChannel, ItsRateIsAWholeMultipleOfTheSampleRateUpToFourKilohertz) {
  EXPECT_EQ(values_per_sample(emg(), 1000.0), 2U);
  EXPECT_EQ(values_per_sample(emg(), 200.0), 10U);
  EXPECT_EQ(values_per_sample(emg(), 2000.0), 1U);
  EXPECT_EQ(values_per_sample(emg(), 4000.0), 0U);
  EXPECT_EQ(values_per_sample(emg(), 300.0), 0U);
  EXPECT_EQ(refusal({emg()}), "accepted");
  EXPECT_EQ(refusal({emg()}, 300.0),
            "auxiliary channel Biceps: rate_Hz: 2000 is not allowed; expected a whole multiple of the "
            "sample rate, 300 Hz, up to 4000 Hz");
  auto fast = emg();
  fast.rate = 8000.0;
  EXPECT_NE(refusal({fast}).find("rate_Hz: 8000 is not allowed"), std::string::npos);
}

TEST(AuxiliaryChannel, ItsLastValueBelongsToTheInstantOfTheSample) {
  EXPECT_EQ(auxiliary_lead(9, 10, 2000.0), 0.0);
  EXPECT_EQ(auxiliary_lead(0, 10, 2000.0), 0.0045);
  EXPECT_EQ(auxiliary_lead(0, 1, 200.0), 0.0);
}

TEST(AuxiliaryChannels, HaveNamesOfLettersAndDigitsEachOnce) {
  EXPECT_EQ(refusal({emg("a b")}),
            "auxiliary channel: name: 'a b' is not allowed; expected 1 to 32 letters and digits");
  EXPECT_NE(refusal({emg("")}), "accepted");
  EXPECT_NE(refusal({emg("../x")}), "accepted");
  EXPECT_EQ(refusal({emg("A"), emg("A")}),
            "auxiliary channel A: name: A is not allowed; expected every name once");
}

TEST(AuxiliaryChannels, HaveATypeAUnitAndAScale) {
  auto channel = emg();
  channel.type = "EGG";
  EXPECT_NE(refusal({channel}).find("type: EGG is not allowed; expected EMG, ECG"), std::string::npos);
  channel = emg();
  channel.unit = "";
  EXPECT_NE(refusal({channel}).find("unit: '' is not allowed"), std::string::npos);
  channel = emg();
  for (const double scale : {0.0, std::numeric_limits<double>::infinity()}) {
    channel.unit_per_value = scale;
    EXPECT_NE(refusal({channel}).find("unit_per_value"), std::string::npos) << scale;
  }
}

TEST(AuxiliaryChannels, AreAtMostThirtyTwoAndFitIntoAMessage) {
  std::vector<AuxiliaryChannel> channels;
  for (int i = 0; i < 32; ++i) channels.push_back(emg("C" + std::to_string(i)));
  EXPECT_EQ(refusal(channels), "accepted");
  EXPECT_EQ(refusal(channels, 10.0),
            "auxiliary channels: 6400 values with a sample are not allowed; expected at most 4096");
  channels.push_back(emg("C32"));
  EXPECT_EQ(refusal(channels), "auxiliary channels: 33 are not allowed; expected at most 32");
}

}  // namespace
}  // namespace tonus
