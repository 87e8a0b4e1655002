// An emergency stop by signal in a running session: what becomes of it in the archive.
#include <csignal>
#include <gtest/gtest.h>
#include <map>

#include "idl/bounds.hpp"
#include "idl/topics.hpp"
#include "services/store/open_store.hpp"
#include "tests/fault/rig/live_system.hpp"

namespace tonus::testing {
namespace {

constexpr std::chrono::seconds kLimit{60};

template <typename T>
std::vector<T> archived(const std::filesystem::path& store_file, const bus::Topic<T>& topic) {
  std::vector<T> messages;
  auto store = store::open_store_for_reading(store_file.string());
  if (!store) return messages;
  store::MessageQuery query;
  query.topic = topic.spec.name;
  const auto visited = (*store)->visit_messages(query, [&](const store::Message& message) -> Result<void> {
    auto decoded = bus::decode<T>(*message.payload);
    if (!decoded) return decoded.error();
    messages.push_back(std::move(*decoded));
    return {};
  });
  EXPECT_TRUE(visited) << visited.error().message;
  return messages;
}

TEST(EmergencyStopBySignal, EndsTheTrialAndItsFlightRecordAndTheLoopsTimingAreArchived) {
  LiveSystem system;
  system.start_session(4);
  ASSERT_TRUE(system.wait_for_mid_trial(400, kLimit)) << system.everything_printed();  // 2 s of cycles
  ASSERT_EQ(kill(system.service("tonus-rig-agent"), SIGUSR1), 0);
  ASSERT_TRUE(system.listen_until([&] { return system.state()->mode() == v1::RIG_HELD; }, kLimit));
  EXPECT_EQ(system.state()->fault(), "emergency_stop");

  std::map<std::uint32_t, v1::FlightRecord> parts;
  ASSERT_TRUE(system.listen_until(
      [&] {
        for (auto& part : archived(system.store_file(), topics::kRigFlightRecord)) parts[part.part()] = part;
        return !parts.empty() && parts.size() == parts.begin()->second.parts();
      },
      kLimit))
      << parts.size() << " parts";
  std::size_t cycles = 0;
  for (const auto& [number, part] : parts) {
    EXPECT_EQ(part.fault_number(), 1U);
    EXPECT_EQ(part.fault(), "emergency_stop");
    cycles += part.cycles().size();
  }
  EXPECT_EQ(cycles, 2000U);
  const v1::FlightCycle& last = parts.rbegin()->second.cycles().back();
  EXPECT_NE(last.fault_bits(), 0U);
  EXPECT_EQ(last.phase(), v1::PHASE_SAFE);

  ASSERT_TRUE(system.listen_until([&] { return !archived(system.store_file(), topics::kRigTiming).empty(); },
                                  kLimit));
  const auto timing = archived(system.store_file(), topics::kRigTiming).back();
  EXPECT_EQ(timing.period_s(), 0.001);
  EXPECT_GT(timing.cycles(), 0U);
  EXPECT_NE(timing.scheduling().find("realtime: "), std::string::npos);

  const auto session = system.archived();
  ASSERT_FALSE(session.trials.empty());
  ASSERT_TRUE(session.trials.back().outcome);
  EXPECT_EQ(session.trials.back().outcome->value.end(), v1::TRIAL_FAULTED);
  EXPECT_EQ(session.trials.back().outcome->value.detail(), "fault: emergency_stop");
}

}  // namespace
}  // namespace tonus::testing
