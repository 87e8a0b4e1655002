#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <gmock/gmock.h>
#include <map>
#include <xdf.h>

#include "services/contract/rig.hpp"
#include "services/formats/hdf5_columns.hpp"
#include "services/formats/xdf_export.hpp"
#include "services/store/archived_trial.hpp"
#include "services/store/memory_store.hpp"
#include "tests/support/made_up_session/made_up_session.hpp"
#include "tests/support/temporary_folder.hpp"

namespace tonus::formats {
namespace {

using ::testing::HasSubstr;
using ::testing::SizeIs;

constexpr std::int64_t kOffset = 250'000'000;  // ns, the rig's clock minus the archive's

class XdfExport : public ::testing::Test {
 protected:
  XdfExport() {
    auto recipe = made_up::unloaded_session();
    recipe.rejected_attempt = 2;
    recipe.is_block_lost = [](std::uint64_t first) { return first == 1750; };
    const auto record = made_up::put_session(store_, std::move(recipe));
    session_ = *store::read_session(store_, record.session);
    add_service(v1::ROLE_RIG, 1);
    add_service(v1::ROLE_ARCHIVE, 2);
    add_service(v1::ROLE_SCHEDULER, 3);
  }

  void add_service(v1::ServiceRole role, std::uint8_t id) {
    v1::ServiceConfiguration configuration;
    configuration.role(role);
    configuration.instance_id({id});
    session_.configurations.push_back({configuration, 0});
  }

  /// A comparison `after_ns` after the first trial's outcome.
  void add_offset(std::uint8_t asker, std::uint8_t answerer, std::int64_t offset_ns, std::uint64_t after_ns) {
    v1::ClockOffset offset;
    offset.asker_id({asker});
    offset.answerer_id({answerer});
    offset.offset_ns(offset_ns);
    offset.measured_ns(session_.trials[0].outcome->received_ns + after_ns);
    session_.clock_offsets.push_back({offset, 0});
  }

  std::string write() {
    const auto file = folder_ / "session.xdf";
    const auto done = export_xdf(store_, session_, file);
    EXPECT_TRUE(done) << (done ? "" : done.error().message);
    return file.string();
  }

  /// The samples that were measured, of every trial.
  std::vector<std::pair<v1::RigSample, EndpointSample>> measured() {
    std::vector<std::pair<v1::RigSample, EndpointSample>> all;
    for (const auto& trial : session_.trials) {
      const auto rig = store::rig_in_force(session_, trial).value();
      const auto found = store::read_trial_samples(store_, trial).value();
      for (const auto& sample : found.samples) {
        if (!contract::flags_of(sample).is_missing)
          all.emplace_back(sample, convert(rig.geometry, rig.shoulder, store::raw_of(sample)));
      }
    }
    return all;
  }

  store::MemoryStore store_;
  store::Session session_;
  ::tonus::testing::TemporaryFolder folder_;
};

TEST_F(XdfExport, IsReadByLibxdfWithItsChannelsUnitsAndStamps) {
  Xdf file;
  ASSERT_EQ(file.load_xdf(write()), 0);
  ASSERT_THAT(file.streams, SizeIs(2));
  const auto& motion = file.streams[0];
  EXPECT_EQ(motion.info.name, "tonus motion");
  EXPECT_EQ(motion.info.channel_format, "double64");
  EXPECT_EQ(motion.info.channel_count, 10);
  EXPECT_EQ(motion.info.nominal_srate, session_.trials[0].outcome->value.sample_rate_Hz());
  ASSERT_THAT(motion.info.channels, SizeIs(10));
  std::map<std::string, std::string> units;
  for (auto channel : motion.info.channels) units[channel["label"]] = channel["unit"];
  EXPECT_EQ(units["encoder_1"], "count");
  EXPECT_EQ(units["endpoint_2"], "m");
  EXPECT_EQ(units["force_1"], "N");
  const auto expected = measured();
  ASSERT_EQ(motion.time_stamps.size(), expected.size());
  EXPECT_EQ(motion.info.sample_count, static_cast<int>(expected.size()));
  for (const std::size_t i : {std::size_t{0}, std::size_t{700}, expected.size() - 1}) {
    EXPECT_EQ(motion.time_stamps[i], static_cast<double>(expected[i].first.acquisition_ns()) * 1e-9);
    EXPECT_EQ(motion.time_series[4][i], static_cast<float>(expected[i].second.p_SE.x())) << i;
    EXPECT_EQ(motion.time_series[7][i], static_cast<float>(expected[i].second.f_S.y())) << i;
  }
}

TEST_F(XdfExport, MarksBeginOnsetAndEndOfEveryTrialWithItsVerdict) {
  Xdf file;
  ASSERT_EQ(file.load_xdf(write()), 0);
  std::map<std::string, double> events;
  for (const auto& [event, stream] : file.eventMap) events[event.first] = event.second;
  EXPECT_THAT(events, SizeIs(3 * session_.trials.size()));
  const auto& outcome = session_.trials[0].outcome->value;
  const auto samples = store::read_trial_samples(store_, session_.trials[0]).value().samples;
  const auto& onset = samples[outcome.onset_sequence() - outcome.first_sequence()];
  const auto found = std::find_if(events.begin(), events.end(), [](const auto& event) {
    return event.first.starts_with("trial 1 onset, ");
  });
  ASSERT_NE(found, events.end());
  EXPECT_EQ(found->second, static_cast<double>(onset.acquisition_ns()) * 1e-9);
  EXPECT_TRUE(events.contains("trial 1 ends, completed, valid"));
  EXPECT_TRUE(std::any_of(events.begin(), events.end(), [](const auto& event) {
    return event.first.starts_with("trial 2 ends, ") && event.first.find("not valid: ") != std::string::npos;
  }));
}

TEST_F(XdfExport, HasNotesAndMarkersAtTheirTimeByTheRigsClockOnceEach) {
  const auto samples = store::read_trial_samples(store_, session_.trials[0]).value().samples;
  v1::SessionNote note;
  note.kind("note");
  note.text("tired <b>");
  note.written_by("Ada");
  note.trial_id(session_.trials[0].trial);
  note.has_rig_clock(true);
  note.epoch(session_.trials[0].outcome->value.epoch());
  note.rig_clock_ns(samples[100].acquisition_ns());
  v1::SessionNote marker = note;
  marker.kind("marker");
  marker.text("music");
  marker.written_by("");
  marker.trial_id({});
  marker.rig_clock_ns(samples[100].acquisition_ns() + 3'600'000'000'000);  // after the last trial
  v1::SessionNote without_rig = note;
  without_rig.has_rig_clock(false);
  session_.notes = {{note, 0}, {marker, 0}, {without_rig, 0}};
  Xdf file;
  ASSERT_EQ(file.load_xdf(write()), 0);
  std::multimap<std::string, double> events;
  for (const auto& [event, stream] : file.eventMap) events.emplace(event.first, event.second);
  ASSERT_EQ(events.count("note by Ada on trial 1: tired <b>"), 1U);
  EXPECT_EQ(events.find("note by Ada on trial 1: tired <b>")->second,
            static_cast<double>(note.rig_clock_ns()) * 1e-9);
  EXPECT_EQ(events.count("marker: music"), 1U);
  EXPECT_EQ(events.size(), 3 * session_.trials.size() + 2);
}

TEST_F(XdfExport, ItsClockOffsetsLeadToTheArchivesClock) {
  add_offset(2, 1, kOffset, 0);  // the archive asked the rig
  add_offset(1, 2, -kOffset, 10'000'000'000);
  add_offset(2, 3, 999, 0);  // the scheduler's clock has nothing to do with it
  Xdf file;
  ASSERT_EQ(file.load_xdf(write()), 0);
  const auto samples = store::read_trial_samples(store_, session_.trials[0]).value().samples;
  const double last = static_cast<double>(samples.back().acquisition_ns()) * 1e-9;
  for (auto& stream : file.streams) {
    ASSERT_THAT(stream.clock_values, SizeIs(2));
    EXPECT_DOUBLE_EQ(stream.clock_values[0], -0.25);
    EXPECT_DOUBLE_EQ(stream.clock_values[1], -0.25);
    EXPECT_NEAR(stream.clock_times[0], last, 1e-6);  // UTC in ns does not fit into a double
    EXPECT_NEAR(stream.clock_times[1], last + 10.0, 1e-6);
  }
  const double before = file.streams[0].time_stamps[100];
  file.syncTimeStamps();
  EXPECT_NEAR(file.streams[0].time_stamps[100], before - 0.25, 1e-9);
}

TEST_F(XdfExport, AClockOfItsOwnComparesWithNoOther) {
  for (auto& description : session_.descriptions) description.value.moves_nothing_real(true);
  add_offset(2, 1, kOffset, 0);
  Xdf file;
  ASSERT_EQ(file.load_xdf(write()), 0);
  EXPECT_THAT(file.streams[0].clock_values, SizeIs(0));
  EXPECT_THAT(file.streams[0].streamHeader, HasSubstr("<clock>of the simulation or replay"));
}

TEST_F(XdfExport, NamesOfPeopleCannotBreakTheHeader) {
  session_.record.subject = "</subject><name>\"&\x01\xff";
  Xdf file;
  ASSERT_EQ(file.load_xdf(write()), 0);
  EXPECT_EQ(file.streams[0].info.name, "tonus motion");
  EXPECT_THAT(
      file.streams[0].streamHeader,
      HasSubstr("<subject>&lt;/subject&gt;&lt;name&gt;&quot;&amp;\xEF\xBF\xBD\xEF\xBF\xBD</subject>"));
}

/// The motion stream's values, double by double, by the specification: libxdf keeps floats.
std::vector<double> motion_values(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(in), {}};
  std::vector<double> values;
  std::size_t at = 4;  // "XDF:"
  const auto take = [&]<typename T>(T& value) {
    std::memcpy(&value, bytes.data() + at, sizeof value);
    at += sizeof value;
  };
  while (at < bytes.size()) {
    EXPECT_EQ(bytes[at++], 4);
    std::uint32_t length = 0;
    std::uint16_t tag = 0;
    std::uint32_t stream = 0;
    take(length);
    const std::size_t end = at + length;
    take(tag);
    if (tag == 3) take(stream);
    if (tag == 3 && stream == 1) {
      std::uint32_t count = 0;
      ++at;
      take(count);
      for (std::uint32_t i = 0; i < count; ++i) {
        at += 9;
        for (int channel = 0; channel < 10; ++channel) take(values.emplace_back());
      }
      EXPECT_EQ(at, end);
    }
    at = end;
  }
  return values;
}

TEST_F(XdfExport, HasTheNumbersToTheLastBit) {
  const auto values = motion_values(write());
  const auto expected = measured();
  ASSERT_EQ(values.size(), 10 * expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) {
    std::size_t at = 10 * i;
    for (const auto& dataset : pair_datasets()) {
      for (const double number : dataset.values(expected[i].first, expected[i].second))
        ASSERT_EQ(values[at++], number) << dataset.name << " of sample " << i;
    }
  }
}

TEST_F(XdfExport, WithoutSamplesLeavesNothingAndSaysSo) {
  session_.trials.clear();
  const auto done = export_xdf(store_, session_, folder_ / "empty.xdf");
  ASSERT_FALSE(done);
  EXPECT_EQ(done.error().code, ErrorCode::kNotFound);
  EXPECT_TRUE(std::filesystem::is_empty(folder_.path()));
}

}  // namespace
}  // namespace tonus::formats
