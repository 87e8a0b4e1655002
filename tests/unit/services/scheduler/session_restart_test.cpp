#include <algorithm>
#include <gtest/gtest.h>
#include <random>

#include "services/scheduler/journal.hpp"
#include "services/scheduler/session_machine.hpp"
#include "tests/support/memory_storage.hpp"
#include "tests/support/scheduler_lab/lab.hpp"

namespace tonus::scheduler {
namespace {

using testing::counted_trials;
using testing::Fate;
using testing::Lab;
using testing::small_loaded_protocol;
using testing::small_protocol;
using tonus::testing::MemoryStorage;

/// Every kind of loss once, by attempt.
Fate troubled(const v1::TrialProgram& program) {
  switch (program.attempt()) {
    case 2:
      return {.detail = "off", .is_valid = false};
    case 4:
      return {.missing_samples = 5};
    case 5:
      return {.end = v1::TRIAL_REFUSED, .detail = "busy"};
    case 7:
      return {.end = v1::TRIAL_BROKEN_OFF, .detail = "restarted"};
    default:
      return {};
  }
}

/// Ends with each planned trial counted once, nothing run twice under one id, and the journal good for a
/// replay.
void expect_sound(Lab& lab, std::uint32_t planned) {
  ASSERT_EQ(lab.phase(), v1::SESSION_COMPLETED) << lab.machine().state().waiting_for();
  const auto counted = counted_trials(lab.records);
  EXPECT_EQ(counted.size(), planned);
  for (const auto& [index, times] : counted) EXPECT_EQ(times, 1) << "planned trial " << index;
  for (const auto& [id, times] : lab.runs) EXPECT_EQ(times, 1);
  Ledger replayed;
  for (const Record& record : lab.records) ASSERT_TRUE(replayed.apply(record).has_value());
  EXPECT_EQ(replayed.state().counted, planned);
}

/// Kills the scheduler when it is about to write frame `frame`; what it wrote and sent of it is up to
/// `survives`.
enum class Survives { kNothing, kRecords, kAll };

void run_with_kill(Lab& lab, std::size_t frame, Survives survives) {
  lab.kills = [&lab, frame, survives](const Effects& effects) {
    if (effects.records.empty() || lab.frames.size() != frame || survives == Survives::kAll) return false;
    if (survives == Survives::kRecords) lab.take_records_only(effects);
    return true;
  };
  lab.command(v1::SESSION_START, "start", small_protocol());
  if (!lab.was_killed) lab.connect();
  if (survives == Survives::kAll) {
    (void)lab.run_until([&] { return lab.frames.size() > frame; });
  } else {
    (void)lab.run_to_end();
  }
  lab.kills = nullptr;
  lab.restart_machine();
  if (!lab.machine().ledger().has_session()) lab.command(v1::SESSION_START, "start", small_protocol());
  lab.connect();
  (void)lab.run_to_end();
}

TEST(Restart, AtEveryRecordEndsWithExactlyThePlannedTrials) {
  Lab reference(troubled);
  run_with_kill(reference, 100000, Survives::kNothing);
  expect_sound(reference, 8);
  const std::size_t frames = reference.frames.size();
  ASSERT_GT(frames, 12u);  // one for each of the twelve attempts, and more
  for (std::size_t frame = 0; frame < frames; ++frame) {
    for (const auto survives : {Survives::kNothing, Survives::kRecords, Survives::kAll}) {
      SCOPED_TRACE(frame);
      SCOPED_TRACE(static_cast<int>(survives));
      Lab lab(troubled);
      run_with_kill(lab, frame, survives);
      expect_sound(lab, 8);
    }
  }
}

TEST(Restart, OverAndOverEndsWithExactlyThePlannedTrials) {
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937_64 chance(seed);
    Lab lab([seed](const v1::TrialProgram& p) {
      std::mt19937_64 luck(seed * 1000 + p.attempt());
      return Fate{.is_valid = luck() % 5 != 0, .missing_samples = luck() % 7 == 0 ? 3ULL : 0ULL};
    });
    lab.command(v1::SESSION_START, "start", small_protocol("rejection_limit = 1000\n"));
    lab.connect();
    while (lab.machine().is_active()) {
      if (chance() % 25 == 0) {
        if (chance() % 2 == 0) lab.kills = [&](const Effects& e) { return lab.take_records_only(e), true; };
        lab.step();
        lab.kills = nullptr;
        lab.restart_machine();
        lab.connect();
      } else if (!lab.step()) {
        const auto due = lab.machine().next_deadline();
        ASSERT_TRUE(due.has_value()) << lab.machine().state().waiting_for();
        lab.tick(std::chrono::ceil<std::chrono::milliseconds>(*due - lab.clock().now()));
      }
    }
    expect_sound(lab, 8);
  }
}

TEST(Restart, FromAFileTornAtEveryByteOfItsLastFrameEndsWithExactlyThePlannedTrials) {
  // A session stopped in the middle, with its journal's octets.
  const auto octets = std::make_shared<MemoryStorage::Bytes>();
  auto journal = Journal::create(std::make_unique<MemoryStorage>(octets), "c");
  ASSERT_TRUE(journal.has_value());
  Lab first(troubled);
  std::size_t before_last = 0;
  const auto keep = [&] {
    for (; before_last < first.frames.size(); ++before_last) {
      ASSERT_TRUE(journal->append(first.frames[before_last]).has_value());
    }
  };
  first.command(v1::SESSION_START, "start", small_protocol());
  first.connect();
  std::size_t size_before = 0;
  while (first.ledger().counted < 5) {
    const auto size = octets->size();
    ASSERT_TRUE(first.step() || (first.tick(std::chrono::milliseconds(500)), true));
    keep();
    if (octets->size() > size) size_before = size;
  }
  for (std::size_t length = size_before; length <= octets->size(); ++length) {
    SCOPED_TRACE(length);
    const auto torn = std::make_shared<MemoryStorage::Bytes>(
        octets->begin(), octets->begin() + static_cast<std::ptrdiff_t>(length));
    auto opened = Journal::open(std::make_unique<MemoryStorage>(torn), "c");
    ASSERT_TRUE(opened.has_value()) << opened.error().message;
    Lab lab(first, opened->records);
    lab.restart_machine();
    lab.connect();
    (void)lab.run_to_end();
    expect_sound(lab, 8);
  }
}

TEST(Restart, KeepsAPauseAndAnswersItLater) {
  Lab lab;
  lab.is_mute = true;
  lab.command(v1::SESSION_START, "start", small_protocol());
  lab.connect();
  lab.command(v1::SESSION_PAUSE, "pause");
  lab.restart_machine();
  EXPECT_EQ(lab.phase(), v1::SESSION_PAUSING);
  EXPECT_EQ(lab.reply_to("pause"), nullptr);
  lab.is_mute = false;
  lab.connect();
  lab.run();
  EXPECT_EQ(lab.phase(), v1::SESSION_PAUSED);
  EXPECT_TRUE(lab.reply_to("pause")->is_done());
  lab.restart_machine();
  lab.connect();
  EXPECT_EQ(lab.phase(), v1::SESSION_PAUSED);
}

TEST(Restart, FinishesAnAbort) {
  Lab lab;
  lab.is_mute = true;
  lab.rig_answers_aborts = false;
  lab.command(v1::SESSION_START, "start", small_protocol());
  lab.connect();
  lab.command(v1::SESSION_ABORT, "abort");
  const auto commands = lab.trial_commands.size();
  lab.rig_answers_aborts = true;
  lab.restart_machine();
  lab.connect();
  EXPECT_EQ(lab.trial_commands.size(), commands);  // a trial that is to be ended is not asked for again
  lab.run();
  EXPECT_EQ(lab.phase(), v1::SESSION_ABORTED);
  EXPECT_TRUE(lab.reply_to("abort")->is_done());
}

TEST(Restart, AnswersARequestFromBeforeItAgain) {
  Lab lab;
  lab.command(v1::SESSION_START, "start", small_protocol());
  lab.restart_machine();
  lab.command(v1::SESSION_START, "start", small_protocol());
  ASSERT_EQ(lab.replies.size(), 2u);
  EXPECT_EQ(lab.replies[0], lab.replies[1]);
}

TEST(Restart, SendsTheSameCommandAgain) {
  Lab lab;
  lab.is_mute = true;
  lab.command(v1::SESSION_START, "start", small_protocol());
  lab.connect();
  lab.restart_machine();
  EXPECT_EQ(lab.trial_commands.size(), 1u) << "not before the rig is armed anew";
  lab.connect();
  ASSERT_EQ(lab.trial_commands.size(), 2u);
  EXPECT_EQ(lab.trial_commands[1], lab.trial_commands[0]);
}

TEST(Restart, KeepsTheAxesOfTheBias) {
  Lab lab;
  lab.command(v1::SESSION_START, "start", small_loaded_protocol());
  lab.connect();
  lab.run();
  v1::Estimate e;
  e.session_id(Lab::kSession);
  e.method("state_variable");
  e.model("linear");
  e.stiffness_N_per_m().value({100.0, 0.0, 0.0, 300.0});
  e.trials().resize(2);
  e.trials()[0].attempt(1);
  e.trials()[1].attempt(2);
  lab.take(lab.machine().on_estimate(e));
  lab.restart_machine();
  lab.connect();
  EXPECT_TRUE(lab.run_to_end());
  for (const auto& command : lab.trial_commands) {
    if (command.program().set_number() != 2) continue;
    EXPECT_EQ(command.program().bias_N()[0], 0.0);  // +major of diag(100, 300): along y
    EXPECT_GE(command.program().bias_N()[1], 0.7);
  }
  expect_sound(lab, 6);
}

TEST(Restart, RefusesRecordsThatDoNotFitTogether) {
  Lab lab;
  lab.command(v1::SESSION_START, "start", small_protocol());
  lab.connect();
  ManualClock clock;
  SessionMachine machine(clock, "test");
  auto records = lab.records;
  records.push_back(record::Counted{5, 1.0});
  const auto restored = machine.restore(records);
  ASSERT_FALSE(restored.has_value());
  EXPECT_EQ(restored.error().message, "journal: attempt 5 ends, but does not run");
}

}  // namespace
}  // namespace tonus::scheduler
