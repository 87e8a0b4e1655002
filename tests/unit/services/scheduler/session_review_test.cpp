// Trials rejected by hand, notes, and who is measured.

#include <algorithm>
#include <cmath>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "services/contract/subject.hpp"
#include "services/scheduler/session_machine.hpp"
#include "tests/support/scheduler_lab/lab.hpp"

namespace tonus::scheduler {
namespace {

using testing::counted_trials;
using testing::Fate;
using ::testing::HasSubstr;
using testing::Lab;
using testing::small_loaded_protocol;
using testing::small_protocol;
using namespace std::chrono_literals;

/// A session of 8 trials in which `counted` are counted, and the next one may run.
std::unique_ptr<Lab> with_counted(std::uint32_t counted, const std::string& protocol = small_protocol()) {
  auto lab = std::make_unique<Lab>();
  lab->command(v1::SESSION_START, "start", protocol);
  lab->connect();
  EXPECT_TRUE(lab->run_until([&] { return lab->ledger().counted == counted; }));
  return lab;
}

std::string refusal(Lab& lab, std::uint32_t attempt, const std::string& request,
                    const std::string& text = "coughed") {
  const auto records = lab.ledger().reviews.size();
  lab.reject(attempt, request, text);
  const auto* reply = lab.reply_to(request);
  if (reply == nullptr) return "no reply";
  EXPECT_EQ(lab.ledger().reviews.size(), records + (reply->is_done() ? 1 : 0));
  return reply->is_done() ? "" : reply->message();
}

void expect_every_planned_trial_counted_once(Lab& lab, std::uint32_t planned = 8) {
  ASSERT_EQ(lab.phase(), v1::SESSION_COMPLETED) << lab.machine().state().waiting_for();
  const auto counted = counted_trials(lab.records);
  EXPECT_EQ(counted.size(), planned);
  for (const auto& [index, times] : counted) EXPECT_EQ(times, 1) << "planned trial " << index;
  Ledger replayed;
  for (const Record& record : lab.records) ASSERT_TRUE(replayed.apply(record).has_value());
  EXPECT_EQ(replayed.state().counted, planned);
}

TEST(Rejection, ByHandIsPublishedCountedAndRunAgain) {
  auto lab = with_counted(3);
  const auto remaining = lab->ledger().expected_remaining;
  EXPECT_EQ(refusal(*lab, 2, "reject"), "");
  EXPECT_EQ(lab->reply_to("reject")->message(), "trial 2 is left out and runs again");
  ASSERT_EQ(lab->reviews.size(), 1U);
  const v1::TrialReview& review = lab->reviews.front();
  EXPECT_EQ(review.trial_id(), trial_id(Lab::kSession, 2));
  EXPECT_EQ(review.session_id(), Lab::kSession);
  EXPECT_EQ(review.attempt(), 2U);
  EXPECT_TRUE(review.is_rejected());
  EXPECT_EQ(review.reason(), "coughed");
  EXPECT_EQ(review.reviewed_by(), "Ada");
  EXPECT_EQ(lab->machine().state().counted(), 2U);
  EXPECT_EQ(lab->machine().state().rejected(), 1U);
  EXPECT_GT(lab->ledger().expected_remaining, remaining);
  ASSERT_TRUE(lab->run_to_end());
  expect_every_planned_trial_counted_once(*lab);
  EXPECT_EQ(lab->machine().state().attempts(), 9U);
}

TEST(Rejection, ByHandIsWrittenDownBeforeItIsPublished) {
  auto lab = with_counted(2);
  std::vector<Record> kept;
  lab->kills = [&](const Effects& effects) {
    const bool is_review = std::ranges::any_of(
        effects.records, [](const Record& entry) { return std::holds_alternative<record::Reviewed>(entry); });
    if (is_review) lab->take_records_only(effects);
    return is_review;
  };
  lab->reject(1, "reject");
  ASSERT_TRUE(lab->was_killed);
  EXPECT_TRUE(lab->reviews.empty());
  lab->kills = nullptr;
  lab->restart_machine();  // killed after the journal's write and before the message
  ASSERT_EQ(lab->reviews.size(), 1U);
  EXPECT_EQ(lab->reviews[0].attempt(), 1U);
  lab->connect();
  lab->reject(1, "reject");  // the operator's program has had no reply and asks again
  EXPECT_TRUE(lab->reply_to("reject")->is_done());
  ASSERT_TRUE(lab->run_to_end());
  EXPECT_EQ(lab->ledger().reviews.size(), 1U);
  expect_every_planned_trial_counted_once(*lab);
}

TEST(Rejection, ByHandIsForgottenWhereTheJournalDoesNotHaveIt) {
  auto lab = with_counted(2);
  lab->kills = [](const Effects& effects) { return !effects.records.empty(); };
  lab->reject(1, "reject");
  ASSERT_TRUE(lab->was_killed);
  lab->kills = nullptr;
  lab->restart_machine();
  lab->connect();
  EXPECT_TRUE(lab->reviews.empty());
  lab->reject(1, "reject");
  EXPECT_TRUE(lab->reply_to("reject")->is_done());
  ASSERT_TRUE(lab->run_to_end());
  expect_every_planned_trial_counted_once(*lab);
}

TEST(Rejection, ByHandStaysInPlaceWhenTheJournalIsReplayed) {
  auto lab = with_counted(3);
  lab->reject(3, "reject");
  const auto before = lab->ledger().remaining;
  lab->restart_machine();
  EXPECT_EQ(lab->ledger().remaining, before);
  EXPECT_EQ(lab->ledger().reviews.size(), 1U);
}

TEST(Rejection, ByHandOfAnEarlierPostureWaitsUntilTheHandIsThereAgain) {
  auto lab = with_counted(5);  // 4 at the first posture, 1 at the second
  const auto first = lab->trial_commands.front().program().posture_index();
  EXPECT_EQ(refusal(*lab, 1, "reject"), "");
  const auto sent = lab->trial_commands.size();
  ASSERT_TRUE(lab->run_to_end());
  std::vector<std::uint32_t> postures;
  for (std::size_t i = sent; i < lab->trial_commands.size(); ++i)
    postures.push_back(lab->trial_commands[i].program().posture_index());
  ASSERT_FALSE(postures.empty());
  EXPECT_EQ(postures.back(), first);  // after the others, not between them
  EXPECT_EQ(std::ranges::count(postures, first), 1);
  expect_every_planned_trial_counted_once(*lab);
}

TEST(Rejection, ByHandAsksForTheHandsPlaceBeforeTheSessionGoesBackToIt) {
  auto lab = std::make_unique<Lab>();
  lab->command(v1::SESSION_START, "start", small_protocol("confirm_posture = true\n"));
  lab->connect();
  lab->command(v1::SESSION_RESUME, "at the first");
  ASSERT_TRUE(lab->run_until([&] { return lab->ledger().counted == 4; }));
  lab->run();
  ASSERT_THAT(lab->machine().state().waiting_for(), HasSubstr("bring the subject's hand to posture 'far'"));
  lab->reject(2, "reject");  // the hand may be on its way already
  EXPECT_THAT(lab->machine().state().waiting_for(), HasSubstr("bring the subject's hand to posture 'near'"));
  lab->command(v1::SESSION_RESUME, "back at the first");
  lab->run();
  EXPECT_THAT(lab->machine().state().waiting_for(), HasSubstr("bring the subject's hand to posture 'far'"));
  lab->command(v1::SESSION_RESUME, "at the second");
  ASSERT_TRUE(lab->run_until([&] { return lab->ledger().counted == 6; }));
  lab->reject(1, "reject another");
  lab->run();
  EXPECT_THAT(lab->machine().state().waiting_for(), HasSubstr("bring the subject's hand to posture 'near'"));
  EXPECT_EQ(lab->ledger().counted, 7U);
  lab->command(v1::SESSION_RESUME, "back once more");
  ASSERT_TRUE(lab->run_to_end());
  expect_every_planned_trial_counted_once(*lab);
}

TEST(Rejection, ByHandOfTheLastTrialKeepsTheSessionGoing) {
  // The receipt of a rejected trial is owed, so that the session waits in COMPLETING when the last one is
  // counted.
  Lab lab([](const v1::TrialProgram& program) {
    return program.attempt() == 1 ? Fate{.detail = "off", .is_valid = false, .has_receipt = false} : Fate{};
  });
  lab.command(v1::SESSION_START, "start", small_protocol());
  lab.connect();
  lab.run();
  ASSERT_EQ(lab.phase(), v1::SESSION_COMPLETING);
  EXPECT_EQ(lab.ledger().counted, 8U);
  lab.reject(9, "reject");
  ASSERT_TRUE(lab.reply_to("reject")->is_done()) << lab.reply_to("reject")->message();
  EXPECT_EQ(lab.phase(), v1::SESSION_RUNNING);
  ASSERT_TRUE(lab.run_to_end());
  expect_every_planned_trial_counted_once(lab);
  EXPECT_EQ(lab.machine().state().attempts(), 10U);
}

TEST(Rejection, ByHandIsRefusedInOneLineWhereItIsImpossible) {
  auto lab = with_counted(2);
  EXPECT_EQ(refusal(*lab, 1, "once"), "");
  EXPECT_EQ(refusal(*lab, 1, "twice"), "trial 1 was rejected by hand already by Ada: coughed");
  ASSERT_TRUE(lab->ledger().in_flight.has_value());
  const auto running = lab->ledger().in_flight->attempt();
  EXPECT_EQ(refusal(*lab, running, "running"),
            "trial " + std::to_string(running) + " is not counted yet: it runs, or waits for its verdict");
  EXPECT_THAT(refusal(*lab, 99, "unknown"), HasSubstr("trial: not one of this session; expected one of the"));
  EXPECT_EQ(refusal(*lab, 2, "blank", " "),
            "text: an empty text is not allowed; expected 1 to 1000 bytes on one line");
  EXPECT_EQ(refusal(*lab, 2, "long", std::string(50'000, 'x')),
            "text: a text of 50000 bytes is not allowed; expected 1 to 1000 bytes on one line");
  EXPECT_THAT(refusal(*lab, 2, "hostile", "\x1b[2Jgone\n"), HasSubstr("is not allowed"));
  ASSERT_TRUE(lab->run_to_end());
  EXPECT_THAT(refusal(*lab, 2, "late"), HasSubstr("the session has completed"));
  expect_every_planned_trial_counted_once(*lab);
}

TEST(Rejection, ByHandOfATrialThatItsVerdictRejectedIsRefused) {
  Lab lab([](const v1::TrialProgram& program) {
    return program.attempt() == 1 ? Fate{.detail = "off", .is_valid = false} : Fate{};
  });
  lab.command(v1::SESSION_START, "start", small_protocol());
  lab.connect();
  ASSERT_TRUE(lab.run_until([&] { return lab.ledger().counted == 2; }));
  EXPECT_EQ(refusal(lab, 1, "reject"), "trial 1 does not count: it was rejected");
}

TEST(Rejection, ByHandDoesNotCountTowardsTheLimitOfASet) {
  auto lab = with_counted(2, small_protocol("rejection_limit = 1\n"));
  EXPECT_EQ(refusal(*lab, 1, "reject"), "");
  ASSERT_TRUE(lab->run_to_end());
  expect_every_planned_trial_counted_once(*lab);
}

TEST(Rejection, ByHandTwiceIsAnsweredOnce) {
  auto lab = with_counted(2);
  lab->reject(1, "reject");
  lab->reject(1, "reject");  // the same request, sent again
  EXPECT_EQ(lab->reviews.size(), 1U);
  EXPECT_EQ(lab->machine().state().rejected(), 1U);
}

TEST(Rejection, ThatDoesNotFitIsDamageOfAJournal) {
  auto lab = with_counted(2);
  Ledger ledger;
  for (const Record& record : lab->records) ASSERT_TRUE(ledger.apply(record));
  const auto counted = *ledger.state().counted_trials.begin();
  record::Reviewed reviewed{counted.first, counted.second, 99, "coughed", "Ada", 0};
  EXPECT_THAT(ledger.apply(reviewed).error().message, HasSubstr("place 99 for a repeat"));
  reviewed.place = 0;
  reviewed.planned_index = counted.second + 1;
  EXPECT_THAT(ledger.apply(reviewed).error().message, HasSubstr("is rejected by hand, but does not count"));
  reviewed.planned_index = counted.second;
  EXPECT_TRUE(ledger.apply(reviewed));
  EXPECT_FALSE(ledger.apply(reviewed));
}

TEST(Note, HasTheRigsClockAsItIsWhenTheSchedulerReceivesIt) {
  auto lab = with_counted(1);
  v1::RigState state;
  state.rig_id(testing::description_of_rig().rig_id());
  state.epoch(1);
  state.mode(v1::RIG_IN_TRIAL);
  state.is_realtime_paced(true);
  state.rig_clock_ns(5'000'000'000);
  lab->take(lab->machine().on_rig_state(state));
  lab->clock().advance(250ms);
  lab->note("the subject is tired", "note", "note", 1);
  ASSERT_EQ(lab->notes.size(), 1U);
  const v1::SessionNote& note = lab->notes.front();
  EXPECT_EQ(note.note_id(), id_of("note"));
  EXPECT_EQ(note.trial_id(), trial_id(Lab::kSession, 1));
  EXPECT_EQ(note.text(), "the subject is tired");
  EXPECT_EQ(note.written_by(), "Ada");
  EXPECT_TRUE(note.has_rig_clock());
  EXPECT_EQ(note.rig_clock_ns(), 5'250'000'000);
  EXPECT_EQ(note.epoch(), 1U);
  EXPECT_EQ(lab->reply_to("note")->message(), "noted at 5.250 s of the rig's clock");
}

TEST(Note, OfARigWhoseClockRunsAtAnotherPaceHasItAsItWasLastReported) {
  auto lab = with_counted(1);
  v1::RigState state;
  state.rig_id(testing::description_of_rig().rig_id());
  state.epoch(1);
  state.mode(v1::RIG_IN_TRIAL);
  state.rig_clock_ns(5'000'000'000);
  lab->take(lab->machine().on_rig_state(state));
  lab->clock().advance(250ms);
  lab->note("start of music", "note", "marker");
  ASSERT_EQ(lab->notes.size(), 1U);
  EXPECT_EQ(lab->notes[0].kind(), "marker");
  EXPECT_EQ(lab->notes[0].rig_clock_ns(), 5'000'000'000);
}

TEST(Note, WhileTheRigIsNotHeardHasNoRigClock) {
  auto lab = with_counted(1);
  lab->clock().advance(2001ms);
  lab->note("the rig is silent", "note");
  ASSERT_EQ(lab->notes.size(), 1U);
  EXPECT_FALSE(lab->notes[0].has_rig_clock());
  EXPECT_EQ(lab->reply_to("note")->message(), "noted, without the rig's clock: the rig is not heard");
}

TEST(Note, IsPublishedAgainByARestartedScheduler) {
  auto lab = with_counted(2);
  lab->note("first", "first note");
  lab->note("second", "second note", "marker");
  const auto published = lab->notes;
  lab->notes.clear();
  lab->restart_machine();
  EXPECT_EQ(lab->notes, published);
}

TEST(Note, IsRefusedInOneLineWhereItIsImpossible) {
  auto lab = with_counted(2);
  const auto refused = [&](const std::string& text, const std::string& kind, std::uint32_t attempt) {
    const std::string request = "note " + text.substr(0, 20) + kind + std::to_string(attempt);
    lab->note(text, request, kind, attempt);
    const auto* reply = lab->reply_to(request);
    return reply == nullptr ? "no reply" : reply->is_done() ? "" : reply->message();
  };
  EXPECT_EQ(refused("", "note", 0),
            "text: an empty text is not allowed; expected 1 to 1000 bytes on one line");
  EXPECT_EQ(refused("hm", "remark", 0), "note_kind: 'remark' is not allowed; expected note or marker");
  EXPECT_THAT(refused("hm", "note", 77), HasSubstr("trial: not one of this session"));
  EXPECT_EQ(refused(std::string(2000, 'x'), "note", 0),
            "text: a text of 2000 bytes is not allowed; expected 1 to 1000 bytes on one line");
  EXPECT_TRUE(lab->notes.empty());
  ASSERT_TRUE(lab->run_to_end());
  EXPECT_THAT(refused("late", "note", 0), HasSubstr("the session has completed"));
}

TEST(Notes, AreBounded) {
  auto lab = with_counted(1);
  for (int i = 0; i < 1000; ++i) lab->note("again", "note " + std::to_string(i));
  EXPECT_EQ(lab->notes.size(), 1000U);
  lab->note("once more", "one too many");
  EXPECT_EQ(lab->notes.size(), 1000U);
  EXPECT_EQ(lab->reply_to("one too many")->message(), "the session has 1000 notes; expected at most 1000");
}

v1::SessionCommand start_of(const std::string& subject) {
  v1::SessionCommand start;
  start.session_id(Lab::kSession);
  start.request_id(id_of("start"));
  start.request(v1::SESSION_START);
  start.protocol_toml(small_protocol());
  start.subject(subject);
  start.subject_facts(contract::unknown_subject());
  start.requested_by("Ada");
  return start;
}

TEST(Plan, SaysWhoIsMeasuredByWhomAndForWhatAlsoAfterARestart) {
  Lab lab;
  v1::SessionCommand start = start_of("s01");
  start.subject_facts().age_years(31.0);
  start.subject_facts().sex("female");
  start.subject_facts().link_lengths_m({0.31, 0.34});
  start.study("posture 2026");
  start.is_pilot(true);
  lab.take(lab.machine().on_command(start));
  const auto expect_people = [](const v1::SessionPlan& plan) {
    EXPECT_EQ(plan.subject_facts().age_years(), 31.0);
    EXPECT_EQ(plan.subject_facts().sex(), "female");
    EXPECT_EQ(plan.subject_facts().link_lengths_m(), (std::array{0.31, 0.34}));
    EXPECT_TRUE(std::isnan(plan.subject_facts().weight_kg()));
    EXPECT_EQ(plan.operator_name(), "Ada");
    EXPECT_EQ(plan.study(), "posture 2026");
    EXPECT_TRUE(plan.is_pilot());
  };
  ASSERT_FALSE(lab.plans.empty());
  expect_people(lab.plans.back());
  // As a journal keeps it.
  lab.records = *decode_records(*encode_records(lab.records));
  lab.plans.clear();
  lab.restart_machine();
  ASSERT_FALSE(lab.plans.empty());
  expect_people(lab.plans.back());
}

TEST(Start, RefusesASubjectWhoCannotBe) {
  Lab lab;
  v1::SessionCommand start = start_of("s01");
  start.subject_facts().height_m(178.0);
  lab.take(lab.machine().on_command(start));
  EXPECT_EQ(lab.reply_to("start")->message(), "height: 178 is not allowed; expected 0.3 to 2.6 m");
  EXPECT_TRUE(lab.records.empty());
}

TEST(LoadedSession, TakesNoAxesFromAnEstimateWithATrialThatWasRejectedByHand) {
  auto lab = std::make_unique<Lab>();
  lab->command(v1::SESSION_START, "start", small_loaded_protocol());
  lab->connect();
  ASSERT_TRUE(lab->run_until([&] { return lab->ledger().counted == 2; }));
  lab->run();
  EXPECT_THAT(lab->machine().state().waiting_for(), HasSubstr("set one's stiffness"));
  lab->reject(1, "reject");
  v1::Estimate stale;
  stale.estimate_id(id_of("estimate"));
  stale.session_id(Lab::kSession);
  stale.set_number(1);
  stale.method("state_variable");
  stale.model("linear");
  stale.axes(2);
  stale.status(v1::ESTIMATE_OK);
  stale.stiffness_N_per_m().value({300.0, 0.0, 0.0, 200.0});
  const auto with_trials = [&](std::vector<std::uint32_t> attempts) {
    v1::Estimate estimate = stale;
    for (const std::uint32_t attempt : attempts) {
      v1::TrialRange range;
      range.attempt(attempt);
      estimate.trials().push_back(range);
    }
    return estimate;
  };
  lab->take(lab->machine().on_estimate(with_trials({1, 2})));
  lab->run();  // the trial of set one that takes the place of the rejected one
  EXPECT_EQ(lab->ledger().counted, 2U);
  EXPECT_TRUE(lab->ledger().axes.empty());
  EXPECT_THAT(lab->machine().state().waiting_for(), HasSubstr("set one's stiffness"));
  lab->take(lab->machine().on_estimate(with_trials({2, 3})));
  EXPECT_EQ(lab->ledger().axes.size(), 1U);
}

}  // namespace
}  // namespace tonus::scheduler
