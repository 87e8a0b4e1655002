// The loop asks nothing of the operating system: in a process that may not, it runs all the same.
#include <gtest/gtest.h>
#include <linux/seccomp.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include "tests/support/simulated_rig.hpp"

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define TONUS_IS_SANITIZED 1
#endif

namespace tonus::control {
namespace {

enum Ending : int { kWell = 0, kNoTrial = 3, kNoFault = 4 };

/// From here on the kernel kills the process at any system call but read, write and exit.
void forbid_system_calls() { prctl(PR_SET_SECCOMP, SECCOMP_MODE_STRICT); }

// A trial to its end and an emergency stop. Never returns; exit(2) would run handlers and call exit_group.
[[noreturn]] void run_without_system_calls(RigLoop& loop, const Command& command) {
  forbid_system_calls();
  (void)loop.post(command);
  TrialResult result;
  SampleRecord sample;
  std::int64_t now = 0;
  bool has_ended = false;
  for (int cycles = 0; cycles < 30'000 && !has_ended; ++cycles) {
    loop.keep_alive();
    loop.step(now += 1'000'000);
    while (loop.next_sample(sample)) continue;
    has_ended = loop.next_result(result);
  }
  loop.emergency_stop();
  for (int i = 0; i < 100; ++i) loop.step(now += 1'000'000);
  const int ending = !has_ended || result.outcome != TrialOutcome::kCompleted ? kNoTrial
                     : loop.state().phase != Phase::kSafe                     ? kNoFault
                                                                              : kWell;
  syscall(SYS_exit, ending);
  __builtin_unreachable();
}

TEST(RigLoop, MakesNoSystemCallInATrialAndInAFault) {
#ifdef TONUS_IS_SANITIZED
  GTEST_SKIP() << "sanitizers make system calls of their own";
#endif
  SimulatedRig rig;
  Command command;
  command.kind = CommandKind::kStartTrial;
  command.program = rig.program();
  const pid_t child = fork();
  ASSERT_GE(child, 0);
  if (child == 0) run_without_system_calls(rig.loop(), command);
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFEXITED(status)) << "killed by signal " << WTERMSIG(status) << ": a system call was made";
  EXPECT_EQ(WEXITSTATUS(status), kWell);
}

TEST(SystemCalls, AreSeenWhereTheyAreForbidden) {
  const pid_t child = fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    forbid_system_calls();
    syscall(SYS_getppid);
    syscall(SYS_exit, 0);
  }
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFSIGNALED(status));
}

}  // namespace
}  // namespace tonus::control
