#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "services/core/result.hpp"
#include "services/protocol/plan.hpp"
#include "services/protocol/protocol.hpp"
#include "services/scheduler/records.hpp"

namespace tonus::scheduler {

/// Everything of a session that outlives the scheduler's process. Only Ledger writes it.
struct LedgerState {
  record::Started started;
  protocol::Protocol protocol;
  protocol::Plan plan;
  std::optional<record::Bound> bound;

  std::vector<std::deque<std::uint32_t>> remaining;  ///< By block: planned_index in the order of running.
  /// Where the next trial is: in the block of the last one as long as it is open, then at its posture, then
  /// the first that is open; plan.blocks.size(): none. It goes back only for a trial that was rejected by
  /// hand.
  std::size_t block = 0;
  std::optional<std::size_t> last_block;      ///< Of the trial that was commanded last.
  std::optional<v1::TrialProgram> in_flight;  ///< Commanded, not yet settled.
  std::vector<std::uint32_t> runs;            ///< By planned_index: commands so far.
  std::vector<std::uint32_t> rejections;      ///< By block, since the operator last went on.
  std::set<std::uint32_t> owed_receipts;      ///< Attempts that were rejected before their receipt came.
  std::map<std::uint32_t, std::set<std::uint32_t>> set_one;  ///< By posture: attempts of set one that count.
  std::map<std::uint32_t, protocol::BiasAxes> axes;          ///< By posture.
  std::set<std::uint32_t> confirmed_postures;                ///< Where the hand is; one at most.
  std::map<std::uint32_t, std::uint32_t> counted_trials;     ///< planned_index by attempt.
  std::vector<record::Reviewed> reviews;  ///< Valid attempts that do not count, in that order.
  std::vector<record::Noted> notes;

  std::vector<std::uint32_t> directions;           ///< By attempt from 1: 0 .. directions - 1.
  std::vector<double> amplitudes;                  ///< By attempt from 1, m.
  std::vector<std::vector<record::Looked>> looks;  ///< By condition.
  std::vector<protocol::Drive> drives;             ///< By condition: of its next trial.
  std::vector<std::uint32_t> commands;             ///< By condition.

  std::uint32_t attempts = 0;
  std::uint32_t counted = 0;
  std::uint32_t rejected = 0;
  std::uint32_t set_aside = 0;
  double experiment = 0.0;          ///< s, of settled trials.
  double expected_settled = 0.0;    ///< s, what those were expected to take.
  double expected_remaining = 0.0;  ///< s, of planned trials not yet counted or set aside.

  bool is_pause_wanted = false;
  bool is_abort_wanted = false;
  std::vector<record::Requested> pending;  ///< Requests not yet answered.
  std::deque<record::Answered> answers;    ///< The last kAnswersKept.
  std::optional<record::Ended> ended;

  static constexpr std::size_t kAnswersKept = 64;

  [[nodiscard]] std::uint32_t condition_of(std::uint32_t planned_index) const {
    return plan.blocks[plan.trials[planned_index].block].condition;
  }
  /// Attempts of a condition that count, ascending.
  [[nodiscard]] std::vector<std::uint32_t> counted_in(std::uint32_t condition) const;
  /// The looks of a condition after which no trial that they stand on was rejected by hand.
  [[nodiscard]] std::vector<record::Looked> standing_looks(std::uint32_t condition) const;
  /// The newest of these ended the condition, and no trial came after it. One that is rejected later opens it
  /// again.
  [[nodiscard]] bool is_ended_by_look(std::uint32_t condition) const;
  /// Trials of the block may be commanded.
  [[nodiscard]] bool is_open(std::size_t of_block) const {
    return !remaining[of_block].empty() && !is_ended_by_look(plan.blocks[of_block].condition);
  }
  /// How a condition begins: as the one before it ended, where that was looked at.
  [[nodiscard]] protocol::Drive first_drive(std::uint32_t condition) const;
};

/// A session as the sum of its records: apply() is the only way to change it, live and when a journal is
/// replayed.
class Ledger {
 public:
  /// kDataLoss where a record does not fit what came before it; the ledger is then unchanged.
  [[nodiscard]] Result<void> apply(const Record& record);

  [[nodiscard]] bool has_session() const { return has_session_; }
  [[nodiscard]] const LedgerState& state() const { return state_; }

 private:
  [[nodiscard]] Result<void> start(const record::Started& started);
  [[nodiscard]] Result<void> check(const Record& record) const;
  [[nodiscard]] Result<void> check(const record::Reviewed& reviewed) const;
  void take(const record::Started&) {}
  void take(const record::Bound& bound);
  void take(const record::Commanded& commanded);
  void take(const record::Counted& counted);
  void take(const record::Rejected& rejected);
  void take(const record::Refused& refused);
  void take(const record::Receipted& receipted);
  void take(const record::AxesFixed& fixed);
  void take(const record::PostureConfirmed& confirmed);
  void take(const record::LimitRaised& raised);
  void take(const record::Requested& requested);
  void take(const record::Answered& answered);
  void take(const record::Ended& ended);
  void take(const record::Looked& looked);
  void take(const record::Reviewed& reviewed);
  void take(const record::Noted& noted);
  /// The posture of the trial that comes next; none: there is none.
  [[nodiscard]] std::optional<std::uint32_t> next_posture() const;
  /// The trial in flight has come to its end.
  void settle(double duration, bool is_done);
  void find_block();

  LedgerState state_;
  bool has_session_ = false;
};

}  // namespace tonus::scheduler
