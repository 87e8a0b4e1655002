#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "analysis_service/identification/auxiliary_store.hpp"
#include "analysis_service/identification/condition_book.hpp"
#include "analysis_service/identification/live_estimator.hpp"
#include "analysis_service/identification/muscle_judge.hpp"
#include "analysis_service/identification/trial_assembler.hpp"
#include "analysis_service/identification/trial_judge.hpp"

namespace tonus::identification {

struct CoreSettings {
  AssemblerLimits assembler;
  JudgeChoice judge;
  BookSettings book;
  impedance::Options live;                         ///< Of the estimates while a perturbation is under way.
  double live_share = 0.1;                         ///< Of the time, the most that they may take; in (0, 1].
  std::chrono::milliseconds rig_wait{5000};        ///< How long a trial waits for its rig's description.
  std::size_t trials_without_rig = 64;             ///< How many do.
  std::chrono::milliseconds auxiliary_wait{3000};  ///< How long one waits for its auxiliary values.
  std::chrono::milliseconds auxiliary_retry{200};  ///< Between two requests for them.
};

/// Everything that the service decides, without bus and clock: rows and reports in, verdicts, estimates and
/// requests out. Not for use by several threads.
///
/// A trial's verdict comes out as soon as its rows are whole; what is made of the trial follows in later
/// calls, one condition a call, so that no verdict waits for it. A condition is not identified while reports
/// of its trials wait for rows: after a restart, its first estimate is made from all of them.
class IdentificationCore {
 public:
  explicit IdentificationCore(const CoreSettings& settings);

  /// `is_rotary`: its displacement is an angle, its force a torque. A trial of a rig with auxiliary channels
  /// waits for their values, and is judged without what does not come.
  void set_rig(const Id& rig, const RigGeometry& geometry, double sample_rate, bool is_rotary = false,
               std::vector<AuxiliaryChannel> channels = {});
  /// The session that is run now; everything of others is freed.
  void set_session(const Id& session, const muscles::MuscleSettings& muscles = {});
  /// Methods that the session needs, whatever else is identified; with the settings of the live estimates.
  /// `is_precision_led`: see ConditionBook::set_precision_led().
  void set_needed(const std::vector<impedance::Method>& methods, bool is_precision_led);
  /// A trial is about to be run: its rows will be followed as they come.
  void expect(const TrialPlan& plan) { expected_ = plan; }
  /// A trial of the session that is run now was rejected by hand: whatever its verdict is or will be, it is
  /// left out of every estimate, and those of its condition come anew.
  void reject(const Id& trial, std::uint32_t attempt);
  void add(const RowBlock& block);
  void add(const AuxiliaryRows& block) { auxiliary_.add(block); }
  void add(const TrialReport& report, Clock::TimePoint now) { assembler_.add(report, now); }

  struct Judged {
    TrialReport report;
    Verdict verdict;
  };
  struct Output {
    std::vector<Judged> verdicts;
    std::vector<ConditionEstimate> estimates;
    std::vector<ResendRequest> requests;
    std::vector<std::string> remarks;  ///< For the log: what went wrong on the way, one line each.
  };
  [[nodiscard]] Output advance(Clock::TimePoint now, bool is_rig_listening);

  /// The live estimate, where rows have come since the last one: one for each block, as it comes. Where they
  /// took more than their share of the time, blocks that come meanwhile are answered by one estimate.
  [[nodiscard]] std::optional<ConditionEstimate> live(Clock::TimePoint now);
  /// What the last one took, until it was sent.
  void charge_live(Clock::Duration cost) { live_budget_ -= std::chrono::duration<double>(cost); }

  /// When advance() has something to do even if nothing comes.
  [[nodiscard]] Clock::TimePoint next_due(Clock::TimePoint now) const;

  /// Trials that wait for rows or for their rig's description, and conditions that wait to be identified.
  [[nodiscard]] std::size_t queue_depth() const;
  [[nodiscard]] const TrialAssembler& assembler() const { return assembler_; }

 private:
  struct Rig {
    RigGeometry geometry;
    double sample_rate = 0.0;
    bool is_rotary = false;
    std::vector<AuxiliaryChannel> channels;
  };
  struct Held {
    MeasuredTrial trial;
    Clock::TimePoint due;
    Clock::TimePoint ask_at;  // for auxiliary values
  };
  struct Settled {
    MeasuredTrial trial;
    bool is_kept = false;  // it counts, and there was room for it
  };

  void follow();
  void settle(MeasuredTrial trial, Output& output);
  void settle_held(Clock::TimePoint now, bool is_rig_listening, Output& output);
  [[nodiscard]] bool must_wait(const MeasuredTrial& trial) const;
  [[nodiscard]] Clock::Duration wait_of(const MeasuredTrial& trial) const;
  [[nodiscard]] std::vector<SequenceRange> missing_auxiliary(const MeasuredTrial& trial) const;
  void settle_live();
  [[nodiscard]] const Rig* rig_of(const TrialPlan& plan) const;
  [[nodiscard]] std::optional<Condition> next_condition() const;
  [[nodiscard]] Clock::TimePoint live_due() const;

  CoreSettings settings_;
  TrialAssembler assembler_;
  ConditionBook book_;
  Id session_{};
  std::set<std::uint32_t> rejected_;  // attempts of the session, by hand
  LiveEstimator live_;
  AuxiliaryStore auxiliary_;
  MuscleJudge muscle_judge_;
  std::map<Id, Rig> rigs_;
  std::deque<Held> held_;
  std::vector<Settled> settled_;  // whose verdicts are out; not yet told to the live estimates
  std::vector<std::string> remarks_;
  std::optional<TrialPlan> expected_;
  bool has_live_news_ = false;
  std::chrono::duration<double> live_budget_;  // that live estimates may take; at most kLiveBudget
  Clock::TimePoint live_budget_at_;            // when it was that
};

}  // namespace tonus::identification
