// Whole systems in real time with an operator at the rig: nothing moves unasked.
#include <csignal>
#include <gtest/gtest.h>

#include "services/contract/names.hpp"
#include "tests/fault/rig/live_system.hpp"

namespace tonus::testing {
namespace {

constexpr std::chrono::seconds kLimit{120};

class Held : public ::testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    system_ = std::make_unique<LiveSystem>(LiveSystem::Unattended::kNo, GetParam());
    system_->start_session(4);
    ASSERT_TRUE(system_->wait_for_mid_trial(50, kLimit)) << system_->everything_printed();
  }

  bool is(v1::RigMode mode) { return system_->state() && system_->state()->mode() == mode; }
  bool waits_for(const std::string& text) {
    return system_->session() && system_->session()->waiting_for().find(text) != std::string::npos;
  }
  void expect_held(const std::string& because) {
    ASSERT_TRUE(system_->listen_until(
        [&] {
          return is(v1::RIG_HELD) && system_->state()->held_because().find(because) != std::string::npos;
        },
        kLimit))
        << system_->state()->held_because() << '\n'
        << system_->everything_printed();
  }
  /// Clear, then resume; between the two the rig is free and no trial is commanded.
  void clear_and_resume() {
    ASSERT_TRUE(system_->listen_until([&] { return waits_for("the rig is held"); }, kLimit));
    EXPECT_NE(system_->operate("resume"), 0) << "a held rig is not resumed";
    // It is refused while the handle still moves: an operator asks again.
    const auto deadline = std::chrono::steady_clock::now() + kLimit;
    while (system_->operate("clear-fault") != 0) ASSERT_LT(std::chrono::steady_clock::now(), deadline);
    const std::uint32_t attempts = system_->session()->attempts();
    ASSERT_TRUE(
        system_->listen_until([&] { return is(v1::RIG_FREE) && waits_for("operator: resume"); }, kLimit))
        << system_->everything_printed();
    EXPECT_EQ(system_->session()->attempts(), attempts);
    ASSERT_EQ(system_->operate("resume"), 0);
  }
  void expect_completed() { EXPECT_EQ(system_->finish_session(kLimit), 0) << system_->everything_printed(); }

  std::unique_ptr<LiveSystem> system_;
};

TEST_P(Held, AnAgentThatIsKilledInATrialComesBackHeldAndWaitsForClearAndResume) {
  ASSERT_EQ(kill(system_->service("tonus-rig-agent"), SIGKILL), 0);
  expect_held("the rig agent ended while the rig was under power");
  clear_and_resume();
  expect_completed();
}

TEST_P(Held, AStopByCommandOutlivesARestartOfEverything) {
  ASSERT_EQ(system_->operate("stop"), 0);
  expect_held("stop by command line");
  system_->restart();
  ASSERT_TRUE(system_->listen_until([&] { return is(v1::RIG_HELD); }, kLimit));
  expect_held("stop by command line");
  clear_and_resume();
  expect_completed();
}

TEST_P(Held, ASchedulerThatIsKilledEndsTheTrialAndItsSuccessorWaitsForTheOperator) {
  ASSERT_EQ(kill(system_->service("tonus-scheduler"), SIGKILL), 0);
  expect_held("command_timeout");
  clear_and_resume();
  expect_completed();
}

TEST_P(Held, ASchedulerThatStandsStillEndsTheTrial) {
  const pid_t scheduler = system_->service("tonus-scheduler");
  ASSERT_EQ(kill(scheduler, SIGSTOP), 0);
  expect_held("command_timeout");
  ASSERT_EQ(kill(scheduler, SIGCONT), 0);
  clear_and_resume();
  expect_completed();
}

TEST_P(Held, ReadersThatStandStillDoNotHoldUpAStop) {
  system_->signal_others(SIGSTOP);
  EXPECT_EQ(system_->operate("stop"), 0) << system_->everything_printed();
  system_->signal_others(SIGCONT);
  expect_held("stop by command line");
}

INSTANTIATE_TEST_SUITE_P(, Held, ::testing::Values("fastdds", "cyclonedds"),
                         [](const auto& instance) { return std::string(instance.param); });

}  // namespace
}  // namespace tonus::testing
