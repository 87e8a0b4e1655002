#include <array>
#include <gtest/gtest.h>

#include "tests/support/allocations.hpp"
#include "tests/support/simulated_rig.hpp"

namespace tonus::control {
namespace {

// All effects of the subject too: the plant belongs to the simulated driver's realtime calls.
simulation::Profile profile_with_every_effect() {
  simulation::Profile profile;
  profile.subject.reflex.is_on = true;
  profile.subject.tremor.is_on = true;
  profile.subject.drift.is_on = true;
  profile.subject.reaction.is_on = true;
  profile.subject.fatigue.is_on = true;
  profile.subject.recentring.is_on = true;
  for (const char* muscle : simulation::kMuscleNames)
    profile.auxiliary.push_back({muscle, "EMG", "mV", 1.0, 2000.0});
  return profile;
}

TEST(RigLoop, AllocatesNothingInTrialsFaultsAndTheirClearing) {
  if (!testing::counts_allocations()) GTEST_SKIP() << "a sanitizer's malloc cannot be counted";
  SimulatedRig rig(profile_with_every_effect());
  RigLoop& loop = rig.loop();
  Command command;
  command.kind = CommandKind::kStartTrial;
  command.program = rig.program();
  command.program.bias = {0.8, 0.0};
  command.program.bias_threshold = 1.0;
  (void)loop.post(command);

  const std::size_t before = testing::allocations();
  std::int64_t now = 0;
  bool has_perturbed = false;
  TrialResult result;
  SampleRecord sample;
  int cycles = 0;
  std::array<float, 60> values{};
  for (; cycles < 30'000 && !loop.next_result(result); ++cycles) {
    loop.keep_alive();
    loop.step(now += 1'000'000);
    while (loop.next_sample(sample, values))
      has_perturbed = has_perturbed || sample.phase == Phase::kPerturbing;
  }
  loop.emergency_stop();
  for (int i = 0; i < 3000; ++i) loop.step(now += 1'000'000);
  command.kind = CommandKind::kClearFaults;
  (void)loop.post(command);
  for (int i = 0; i < 10; ++i) loop.step(now += 1'000'000);
  const std::size_t after = testing::allocations();

  EXPECT_EQ(result.outcome, TrialOutcome::kCompleted);
  EXPECT_TRUE(has_perturbed);
  EXPECT_EQ(loop.state().phase, Phase::kIdle);
  EXPECT_EQ(after, before) << "in " << cycles << " cycles";
}

TEST(Allocations, OfOperatorNewAreCounted) {
  if (!testing::counts_allocations()) GTEST_SKIP() << "a sanitizer's malloc cannot be counted";
  const std::size_t before = testing::allocations();
  void* memory = ::operator new(8);
  const std::size_t after = testing::allocations();
  ::operator delete(memory);
  EXPECT_EQ(after, before + 1);
}

}  // namespace
}  // namespace tonus::control
