#include "rig_agent/agent/recorded_trials.hpp"

#include <cmath>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace tonus::rig {
namespace {

using ::testing::HasSubstr;

/// Four rows at 200 Hz with a perturbation in the last two, and what two channels gave with them.
recording::Recording record(float first_value) {
  recording::Recording made;
  made.participant.id = "sub-01";
  made.task = "unloaded";
  made.sampling_frequency = 200.0;
  made.rig = recording::converted_rig(RigKind::kCartesian);
  made.rows.resize(4);
  made.auxiliary = {{{"Biceps", "EMG", "mV", 1.0, 400.0}, 2, {}},
                    {{"Onset", "TRIG", "V", 1.0, 200.0}, 1, {}}};
  for (std::size_t i = 0; i < 8; ++i) made.auxiliary[0].values.push_back(first_value + static_cast<float>(i));
  made.auxiliary[1].values = {0.0F, 0.0F, 1.0F, std::nanf("")};
  recording::PerturbationEvent event;
  event.onset_s = 0.01;
  event.duration_s = 0.005;
  event.direction_deg = 90.0;
  made.events = {event};
  return made;
}

TEST(RecordedTrials, ArePlayedWithWhatTheAuxiliaryChannelsGaveWithEachRow) {
  auto trials = RecordedTrials::create({record(10.0F), record(20.0F)});
  ASSERT_TRUE(trials) << trials.error().message;
  drivers::Replay replay(trials->take_recording());
  ASSERT_EQ(replay.auxiliary_channels().size(), 2U);
  ASSERT_TRUE(replay.configure(1.0 / 200.0));
  ASSERT_TRUE(replay.activate());
  v1::TrialProgram program;
  program.recording_index(1);
  program.recording_event(-1);  // the whole record
  const auto segment = trials->prepare(program);
  ASSERT_TRUE(segment) << segment.error().message;
  drivers::TrialNotice notice;
  notice.segment = *segment;
  replay.begin_trial(notice);
  const std::vector<std::uint32_t> counts{2, 1};
  std::vector<float> values(3);
  drivers::Reading reading;
  for (std::size_t row = 0; row < 4; ++row) {
    ASSERT_EQ(replay.read(reading), drivers::DriverStatus::kOk);
    replay.read_auxiliary(counts, values);
    EXPECT_EQ(values[0], 20.0F + 2.0F * static_cast<float>(row));
    EXPECT_EQ(values[1], 21.0F + 2.0F * static_cast<float>(row));
    if (row < 3) {
      EXPECT_EQ(values[2], row == 2 ? 1.0F : 0.0F);
    } else {
      EXPECT_TRUE(std::isnan(values[2]));
    }
  }
}

TEST(RecordedTrials, OfOtherAuxiliaryChannelsAreNotPlayedTogether) {
  auto other = record(20.0F);
  other.auxiliary.pop_back();
  const auto trials = RecordedTrials::create({record(10.0F), other});
  ASSERT_FALSE(trials);
  EXPECT_THAT(trials.error().message, HasSubstr("auxiliary channels; one replay takes one rig"));
}

}  // namespace
}  // namespace tonus::rig
