#include <atomic>
#include <cstdlib>
#include <gtest/gtest.h>
#include <new>

#include "tests/unit/rig_agent/simulated_rig.hpp"

namespace {

// Counts every allocation of the program while it is on.
std::atomic<bool> is_counting{false};
std::atomic<int> allocations{0};

void* counted(std::size_t size, std::size_t alignment) {
  if (is_counting.load()) ++allocations;
  void* memory = alignment > alignof(std::max_align_t)
                     ? std::aligned_alloc(alignment, (size + alignment - 1) / alignment * alignment)
                     : std::malloc(size == 0 ? 1 : size);
  if (memory == nullptr) throw std::bad_alloc();
  return memory;
}

}  // namespace

void* operator new(std::size_t size) { return counted(size, 0); }
void* operator new[](std::size_t size) { return counted(size, 0); }
void* operator new(std::size_t size, std::align_val_t alignment) {
  return counted(size, static_cast<std::size_t>(alignment));
}
void* operator new[](std::size_t size, std::align_val_t alignment) {
  return counted(size, static_cast<std::size_t>(alignment));
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete[](void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
void operator delete[](void* memory, std::size_t) noexcept { std::free(memory); }
void operator delete(void* memory, std::align_val_t) noexcept { std::free(memory); }
void operator delete[](void* memory, std::align_val_t) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept { std::free(memory); }
void operator delete[](void* memory, std::size_t, std::align_val_t) noexcept { std::free(memory); }

namespace tonus::control {
namespace {

// All effects of the subject too: the plant belongs to the simulated driver's realtime calls.
plant::Profile profile_with_every_effect() {
  plant::Profile profile;
  profile.subject.reflex.is_on = true;
  profile.subject.tremor.is_on = true;
  profile.subject.drift.is_on = true;
  profile.subject.reaction.is_on = true;
  profile.subject.fatigue.is_on = true;
  profile.subject.recentring.is_on = true;
  return profile;
}

TEST(RigLoop, AllocatesNothingInTrialsFaultsAndTheirClearing) {
  SimulatedRig rig(profile_with_every_effect());
  RigLoop& loop = rig.loop();
  Command command;
  command.kind = CommandKind::kStartTrial;
  command.program = rig.program();
  command.program.bias = {0.8, 0.0};
  command.program.bias_threshold = 1.0;
  loop.post(command);

  is_counting = true;
  std::int64_t now = 0;
  bool has_perturbed = false;
  TrialResult result;
  SampleRecord sample;
  int cycles = 0;
  for (; cycles < 30'000 && !loop.next_result(result); ++cycles) {
    loop.keep_alive();
    loop.step(now += 1'000'000);
    while (loop.next_sample(sample)) has_perturbed = has_perturbed || sample.phase == Phase::kPerturbing;
  }
  loop.emergency_stop();
  for (int i = 0; i < 3000; ++i) loop.step(now += 1'000'000);
  command.kind = CommandKind::kClearFaults;
  loop.post(command);
  for (int i = 0; i < 10; ++i) loop.step(now += 1'000'000);
  is_counting = false;

  EXPECT_EQ(result.outcome, TrialOutcome::kCompleted);
  EXPECT_TRUE(has_perturbed);
  EXPECT_EQ(loop.state().phase, Phase::kIdle);
  EXPECT_EQ(allocations.load(), 0) << "in " << cycles << " cycles";
}

TEST(CountedNew, CountsAnAllocation) {
  allocations = 0;
  is_counting = true;
  void* memory = ::operator new(8);
  is_counting = false;
  ::operator delete(memory);
  EXPECT_EQ(allocations.load(), 1);
}

}  // namespace
}  // namespace tonus::control
