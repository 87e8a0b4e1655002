#include <algorithm>
#include <chrono>
#include <cmath>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "services/scheduler/session_machine.hpp"
#include "tests/support/scheduler_lab/lab.hpp"

namespace tonus::scheduler {
namespace {

using testing::Fate;
using ::testing::HasSubstr;
using testing::Lab;
using namespace std::chrono_literals;

/// Two postures, at most 16 trials at each.
std::string led_protocol(const std::string& keys = "") {
  std::string text = testing::small_protocol();
  const std::string from = "directions = 2";
  text.replace(text.find(from), from.size(), "directions = 8");
  return text + "[stop_when]\nstiffness = 0.05\ntrials_least = 8\n" + keys;
}

/// Half-widths of `width` of the largest element.
v1::MatrixEstimate matrix_of(double largest, double width) {
  v1::MatrixEstimate matrix;
  matrix.value({largest, 0.0, 0.0, 0.5 * largest});
  for (std::size_t i = 0; i < 4; ++i) {
    matrix.low95()[i] = matrix.value()[i] - width * largest;
    matrix.high95()[i] = matrix.value()[i] + width * largest;
  }
  return matrix;
}

/// A lab whose identification answers each trial with an estimate of its posture's trials: half-widths fall
/// with the root of their number, from `width` of one.
class LedLab : public Lab {
 public:
  explicit LedLab(double width, std::string keys = "") : width_(width), keys_(std::move(keys)) {
    set_script([this](const v1::TrialProgram& program) { return measure(program); });
  }

  void start() {
    command(v1::SESSION_START, "start", led_protocol(keys_));
    connect();
  }
  /// Goes on, also where estimates are waited for, until so many trials are counted.
  void run_until_counted(std::uint32_t trials) {
    run();
    while (ledger().counted < trials) {
      tick(1100ms);
      run();
    }
  }
  /// What a late reader hears.
  void give_estimates() {
    for (const auto& [posture, estimate] : estimates_)
      post([e = estimate](SessionMachine& machine) { return machine.on_estimate(e); });
  }
  [[nodiscard]] std::vector<v1::TrialProgram> commanded() const {
    std::vector<v1::TrialProgram> programs;
    for (const Record& record : records) {
      if (const auto* r = std::get_if<record::Commanded>(&record)) programs.push_back(r->program);
    }
    return programs;
  }

  /// Rejects a trial of posture `posture` by hand; identification makes its estimate without it.
  void take_back(std::uint32_t attempt, std::uint32_t posture) {
    reject(attempt, "take back");
    v1::Estimate& e = estimates_[posture];
    std::erase_if(e.trials(), [&](const v1::TrialRange& range) { return range.attempt() == attempt; });
    set_widths(e);
    post([e](SessionMachine& machine) { return machine.on_estimate(e); });
  }

  bool has_estimates = true;
  std::uint32_t forgotten = 0;  // attempts up to it are in no estimate: identification has lost them
  double hardens_above = 1.0;   // m: an estimate with such an amplitude fails the check

 private:
  Fate measure(const v1::TrialProgram& program) {
    v1::Estimate& e = estimates_[program.posture_index()];
    e.estimate_id(id_of("estimate/" + program.posture()));
    e.session_id(kSession);
    e.posture_index(program.posture_index());
    e.method("refined");
    e.model("linear");
    e.axes(2);
    if (program.attempt() <= forgotten) return {};
    v1::TrialRange range;
    range.attempt(program.attempt());
    e.trials().push_back(range);
    set_widths(e);
    const bool hardens = program.amplitude_m() > hardens_above || e.status() == v1::ESTIMATE_SUSPECT;
    e.status(hardens ? v1::ESTIMATE_SUSPECT : v1::ESTIMATE_OK);
    v1::FitCheck check;
    check.test(v1::FIT_HARDENING);
    check.passed(!hardens);
    e.checks({check});
    if (has_estimates) post([e](SessionMachine& machine) { return machine.on_estimate(e); });
    return {};
  }

  void set_widths(v1::Estimate& e) const {
    e.trials_used(static_cast<std::uint32_t>(e.trials().size()));
    const double width = width_ / std::sqrt(e.trials_used());
    e.stiffness_N_per_m(matrix_of(300.0, width));
    e.damping_Ns_per_m(matrix_of(20.0, width));
    e.mass_kg(matrix_of(2.0, width));
  }

  double width_;
  std::string keys_;
  std::map<std::uint32_t, v1::Estimate> estimates_;
};

TEST(PrecisionLed, EndsAConditionWhenTwoLooksInARowAreNarrowEnough) {
  LedLab lab(0.15);  // 0.05 after 9 trials
  lab.start();
  ASSERT_TRUE(lab.run_to_end());
  EXPECT_EQ(lab.phase(), v1::SESSION_COMPLETED);
  EXPECT_EQ(lab.ledger().counted, 20U);
  const auto& state = lab.machine().state();
  EXPECT_EQ(state.planned(), 20U);
  ASSERT_EQ(state.conditions().size(), 2U);
  for (const auto& condition : state.conditions()) {
    EXPECT_EQ(condition.counted(), 10U);
    EXPECT_EQ(condition.planned(), 16U);
    EXPECT_TRUE(condition.is_finished());
    EXPECT_NEAR(condition.precision(), 0.15 / std::sqrt(10.0), 1e-12);
    EXPECT_EQ(condition.precision_goal(), 0.05);
    EXPECT_EQ(condition.finished_because(), "10 trials: half-width of stiffness 4.7 %, goal 5 %");
  }
}

TEST(PrecisionLed, SaysWhyAGoalCannotBeReachedAndRunsTheMostTrials) {
  LedLab lab(0.60);  // 0.05 after 144 trials
  lab.start();
  ASSERT_TRUE(lab.run_to_end());
  EXPECT_EQ(lab.ledger().counted, 32U);
  EXPECT_EQ(
      lab.machine().state().conditions().front().finished_because(),
      "16 trials, the most allowed: half-width of stiffness 15 %, goal 5 %, which takes about 144 trials");
  const bool said_before = std::ranges::any_of(lab.states, [](const v1::SessionState& state) {
    return state.counted() == 8 &&
           state.message().find("which takes about 144, more than the 16 allowed") != std::string::npos;
  });
  EXPECT_TRUE(said_before);
}

TEST(PrecisionLed, EstimatesAnewHowManyTrialsRemain) {
  LedLab lab(0.17);  // 0.05 after 11.6 trials
  lab.start();
  ASSERT_TRUE(lab.run_until([&] { return lab.ledger().looks[0].size() == 1; }));
  // 4 more here; of the second condition, without looks, all 16.
  EXPECT_EQ(lab.machine().state().planned(), 8U + 4U + 16U);
  ASSERT_TRUE(lab.run_until([&] { return lab.ledger().is_ended_by_look(0); }));
  const auto taken = lab.ledger().looks[0].back().counted;
  EXPECT_EQ(lab.machine().state().planned(), 2U * taken);
  EXPECT_LT(lab.machine().state().remaining_s(), 16.0 * 10.0);
}

TEST(PrecisionLed, AKilledSchedulerGoesOnIdentically) {
  LedLab reference(0.15);
  reference.start();
  ASSERT_TRUE(reference.run_to_end());
  const auto expected = reference.commanded();
  for (std::size_t frame = 1; frame < reference.frames.size(); ++frame) {
    for (const bool has_written : {false, true}) {
      SCOPED_TRACE(frame);
      LedLab lab(0.15);
      lab.kills = [&](const Effects& effects) {
        if (effects.records.empty() || lab.frames.size() != frame) return false;
        if (has_written) lab.take_records_only(effects);
        return true;
      };
      lab.start();
      (void)lab.run_to_end();
      lab.kills = nullptr;
      lab.restart_machine();
      lab.connect();
      lab.give_estimates();
      ASSERT_TRUE(lab.run_to_end());
      EXPECT_EQ(lab.phase(), v1::SESSION_COMPLETED);
      EXPECT_EQ(lab.commanded(), expected);
    }
  }
}

TEST(PrecisionLed, RecordsEachDecisionWithItsEstimate) {
  LedLab lab(0.15);
  lab.start();
  ASSERT_TRUE(lab.run_to_end());
  const auto& looks = lab.ledger().looks[0];
  ASSERT_EQ(looks.size(), 3U);  // after 8, 9 and 10 trials
  EXPECT_EQ(looks[0].counted, 8U);
  EXPECT_EQ(looks[0].end, protocol::LookEnd::kGoesOn);
  EXPECT_NEAR(looks[0].needed, 9.0, 1e-9);
  EXPECT_EQ(looks[2].end, protocol::LookEnd::kReached);
  EXPECT_EQ(looks[2].estimate_id, id_of("estimate/near"));
  EXPECT_EQ(looks[2].newest, 10U);
}

TEST(PrecisionLed, OpensAConditionAgainWhereATrialOfItIsTakenBack) {
  LedLab lab(0.15);
  lab.start();
  ASSERT_TRUE(lab.run_until([&] { return lab.ledger().is_ended_by_look(0); }));
  LedgerState state = lab.ledger();
  EXPECT_FALSE(state.is_open(0) || state.is_open(1));
  state.counted_trials.erase(3);
  EXPECT_FALSE(state.is_ended_by_look(0));
  EXPECT_TRUE(state.is_open(1));  // set two has trials left
}

TEST(PrecisionLed, RunsATrialRejectedAfterTheStopAgainAndLooksAnew) {
  LedLab lab(0.15);
  lab.start();
  ASSERT_TRUE(lab.run_until([&] { return lab.ledger().is_ended_by_look(0); }));
  ASSERT_EQ(lab.ledger().counted_in(0).size(), 10U);
  lab.take_back(3, 0);
  ASSERT_TRUE(lab.run_to_end());
  EXPECT_EQ(lab.phase(), v1::SESSION_COMPLETED);
  EXPECT_EQ(lab.ledger().counted, 20U);
  EXPECT_EQ(lab.ledger().attempts, 21U);
  // The looks of which trial 3 was a part count no more: two others ended the condition.
  const auto standing = lab.ledger().standing_looks(0);
  ASSERT_EQ(standing.size(), 2U);
  EXPECT_EQ(standing[0].counted, 9U);
  EXPECT_EQ(standing[1].counted, 10U);
  EXPECT_EQ(standing[1].newest, lab.ledger().counted_in(0).back());
  EXPECT_EQ(standing[1].end, protocol::LookEnd::kReached);
}

TEST(PrecisionLed, EndsNoConditionByAnEstimateOfFewerTrialsThanTheFirstLookAsksFor) {
  LedLab lab(0.03);  // narrow from the first trial on
  lab.forgotten = 5;
  lab.start();
  ASSERT_TRUE(lab.run_to_end());
  const auto& looks = lab.ledger().looks[0];
  ASSERT_EQ(looks.size(), 7U);  // after 8 to 14 trials; from 13 on the estimate has 8 of them
  for (std::size_t i = 0; i < 5; ++i) EXPECT_EQ(looks[i].estimate_id, kNoId) << i;
  EXPECT_EQ(looks.back().end, protocol::LookEnd::kReached);
}

TEST(PrecisionLed, RunsEveryPlannedTrialWithoutAnEstimate) {
  LedLab lab(0.01);
  lab.has_estimates = false;
  lab.start();
  ASSERT_TRUE(lab.run_to_end());
  EXPECT_EQ(lab.ledger().counted, 32U);
  EXPECT_EQ(lab.machine().state().conditions().front().finished_because(),
            "16 trials, the most allowed: there is no estimate with intervals");
}

TEST(PrecisionLed, SaysAtItsEndWhereGoalsWereNotReached) {
  LedLab lab(0.60);
  lab.start();
  ASSERT_TRUE(lab.run_to_end());
  EXPECT_EQ(lab.machine().state().message(),
            "32 trials counted; goals not reached at 2 of 2 conditions: 'near', 'far'");
  LedLab narrow(0.15);
  narrow.start();
  ASSERT_TRUE(narrow.run_to_end());
  EXPECT_EQ(narrow.machine().state().message(), "20 trials counted");
}

TEST(PrecisionLed, StaysPausedWhetherItsEstimateComesOrNot) {
  LedLab lab(0.15);
  lab.has_estimates = false;
  lab.start();
  lab.run_until_counted(8);
  lab.command(v1::SESSION_PAUSE, "pause");
  lab.run();
  EXPECT_EQ(lab.phase(), v1::SESSION_PAUSED);
  lab.tick(20s);
  lab.run();
  EXPECT_EQ(lab.phase(), v1::SESSION_PAUSED);
  EXPECT_EQ(lab.trial_commands.size(), 8U);
  lab.command(v1::SESSION_RESUME, "resume");
  lab.run();
  EXPECT_EQ(lab.trial_commands.size(), 9U);
}

TEST(PrecisionLed, WaitsForItsEstimateForALimitedTimeAndSaysSo) {
  LedLab lab(0.15);
  lab.has_estimates = false;
  lab.start();
  lab.run_until_counted(8);
  EXPECT_EQ(lab.phase(), v1::SESSION_RUNNING);
  EXPECT_EQ(lab.machine().state().waiting_for(), "");
  lab.tick(2000ms);
  EXPECT_EQ(lab.phase(), v1::SESSION_WAITING);
  EXPECT_EQ(lab.machine().state().waiting_for(),
            "identification: estimate of 'near' by refined from 8 trials; after 10 s the session goes on "
            "without it");
  EXPECT_EQ(lab.trial_commands.size(), 8U);
  lab.tick(8000ms);
  EXPECT_EQ(lab.machine().state().message(), "'near': no estimate by refined came in time");
  EXPECT_EQ(lab.trial_commands.size(), 9U);
}

TEST(PrecisionLed, WaitsWithoutLimitWhileIdentificationIsGone) {
  LedLab lab(0.15);
  lab.has_estimates = false;
  lab.start();
  lab.run_until_counted(8);
  lab.take(lab.machine().on_roster("identification: not there"));
  lab.tick(60s);
  EXPECT_EQ(lab.machine().state().waiting_for(), "identification: not there");
  EXPECT_EQ(lab.trial_commands.size(), 8U);
}

TEST(PrecisionLed, KeepsDirectionsBalancedAndRejectedTrialsOutOfTheCount) {
  LedLab lab(0.60);
  lab.start();
  ASSERT_TRUE(lab.run_to_end());
  std::map<double, int> times;
  for (const auto& program : lab.commanded()) {
    if (program.posture_index() == 0) ++times[program.direction_deg()];
  }
  for (const auto& [direction, count] : times) EXPECT_NEAR(count, 2, 2) << direction;
  EXPECT_GE(times.size(), 7U);
}

TEST(PrecisionLed, RaisesTheAmplitudeWhileTheResidualsStayLinear) {
  LedLab lab(0.60, "amplitude_most_m = 0.007\nrise_least_s = 0.1\n");
  lab.start();
  ASSERT_TRUE(lab.run_to_end());
  const auto programs = lab.commanded();
  EXPECT_EQ(programs[7].amplitude_m(), 0.005);
  EXPECT_DOUBLE_EQ(programs[8].amplitude_m(), 0.00625);
  EXPECT_DOUBLE_EQ(programs[16].amplitude_m(), 0.007);
  EXPECT_EQ(programs[15].rise_time_s(), 0.2);  // one shape in a condition
  EXPECT_DOUBLE_EQ(programs[16].rise_time_s(), 0.12);
}

TEST(PrecisionLed, GoesBackToItsOwnAmplitudeWhereTheResidualsAreNotLinear) {
  LedLab lab(0.60, "amplitude_most_m = 0.007\n");
  lab.hardens_above = 0.006;
  lab.start();
  ASSERT_TRUE(lab.run_to_end());
  const auto programs = lab.commanded();
  EXPECT_DOUBLE_EQ(programs[8].amplitude_m(), 0.00625);
  EXPECT_EQ(programs[9].amplitude_m(), 0.005);
  EXPECT_EQ(programs[15].amplitude_m(), 0.005);
  EXPECT_EQ(programs[16].amplitude_m(), 0.005);
}

TEST(EveryProtocol, ShowsHowFarItsConditionsAre) {
  Lab lab;
  lab.command(v1::SESSION_START, "start", testing::small_protocol());
  lab.connect();
  ASSERT_TRUE(lab.run_to_end());
  const auto& conditions = lab.machine().state().conditions();
  ASSERT_EQ(conditions.size(), 2U);
  EXPECT_EQ(conditions[1].posture(), "far");
  EXPECT_EQ(conditions[1].counted(), 4U);
  EXPECT_EQ(conditions[1].precision_goal(), 0.0);
  EXPECT_FALSE(std::isfinite(conditions[1].precision()));
  EXPECT_EQ(conditions[1].finished_because(), "every planned trial counts");
}

}  // namespace
}  // namespace tonus::scheduler
