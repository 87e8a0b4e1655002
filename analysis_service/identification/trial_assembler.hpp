#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <map>
#include <set>
#include <span>
#include <tuple>
#include <vector>

#include "analysis_service/identification/measured_trial.hpp"
#include "analysis_service/identification/row_store.hpp"
#include "services/core/clock.hpp"

namespace tonus::identification {

/// How long the assembler waits, how often it asks, and how much it holds.
struct AssemblerLimits {
  std::chrono::milliseconds first_wait{
      50};  ///< From the outcome to the first request: rows may be under way.
  std::chrono::milliseconds first_retry{
      100};  ///< From the first request to the second; doubles each time ...
  std::chrono::milliseconds longest_retry{2000};  ///< ... up to this.
  int resends = 8;  ///< Requests in a row that bring nothing; after them the rows are lost for good.
  std::size_t trials_asked_for = 4;   ///< Trials whose rows are asked for at the same time.
  std::size_t ranges_a_request = 16;  ///< Ranges of one trial asked for at once.
  std::size_t trials_waiting = 4096;  ///< Reports kept while their rows are incomplete.
  std::size_t rows = 1'000'000;       ///< Rows held in all, 64 MB; the longest trial that can be assembled.
  std::size_t trials_remembered =
      65'536;  ///< Trials that are done, so that a repeat of their report is known.
};

/// Asks the rig for rows once more.
struct ResendRequest {
  Id rig{};
  Id trial{};
  std::uint64_t epoch = 0;
  SequenceRange range;

  friend bool operator==(const ResendRequest&, const ResendRequest&) = default;
};

/// What came in and what became of it.
struct AssemblerCounts {
  std::uint64_t rows = 0;      ///< Taken.
  std::uint64_t repeated = 0;  ///< Rows that were here already, or whose trial is done.
  std::uint64_t outside = 0;   ///< Rows outside any trial.
  std::uint64_t evicted = 0;  ///< Rows given up for want of room; asked for again if their trial is reported.
  std::uint64_t refused = 0;  ///< Rows not taken for want of room.
  std::uint64_t reports_dropped = 0;  ///< Reports given up: too many waited, or of a session that is over.
};

/// Puts a rig's rows together, trial by trial, from blocks that come late, twice, out of order or not at all.
///
/// Contract: every report of the current session comes out of advance() exactly once: as soon as its rows are
/// complete; else after `resends` requests in a row that brought nothing, with the missing rows marked. A
/// request that no rig can hear is not made and does not count. A trial that the rig did not complete waits
/// for first_wait and is not asked for. After a restart of this program the reports come once more, no rows
/// with them: they are asked for, the newest attempt first (somebody waits for that one), trials_asked_for at
/// a time. Reports of other sessions come out where their rows are there anyway, and are never asked for.
/// Rows outside a trial are not kept, and those of a trial only until it is taken out.
/// Knows no clock: the time of each call is given and must not go back. Not for use by several threads.
class TrialAssembler {
 public:
  explicit TrialAssembler(const AssemblerLimits& limits = {}) : limits_(limits) {}

  /// Whose rows are asked for. Before the first call nobody's are.
  void set_session(const Id& session) { session_ = session; }

  void add(const RowBlock& block);

  /// A repeat of a report that is waiting or was taken out changes nothing.
  void add(const TrialReport& report, Clock::TimePoint now);

  struct Progress {
    std::vector<MeasuredTrial> finished;  ///< By attempt.
    std::vector<ResendRequest> requests;
  };
  [[nodiscard]] Progress advance(Clock::TimePoint now, bool is_rig_listening);

  /// When advance() has something to do even if nothing comes; TimePoint::max() for never.
  [[nodiscard]] Clock::TimePoint next_due() const;

  /// Rows of a running trial from this number up to the first gap. Valid until the next change.
  [[nodiscard]] std::span<const Row> rows_from(const Id& rig, std::uint64_t epoch,
                                               std::uint64_t sequence) const;

  /// Reports of the current session that wait for rows. Valid until the next change.
  [[nodiscard]] std::vector<const TrialReport*> waiting() const;

  [[nodiscard]] std::size_t rows_held() const { return rows_held_; }
  [[nodiscard]] const AssemblerCounts& counts() const { return counts_; }

 private:
  struct Waiting {
    TrialReport report;
    Clock::TimePoint due;
    std::uint64_t missing = 0;  // rows, when last looked at
    int fruitless = 0;          // requests since rows came
    std::uint32_t requests = 0;
    bool is_asked_for = false;
  };
  using WaitingTrials = std::map<Id, Waiting>;

  [[nodiscard]] bool is_current(const Waiting& waiting) const {
    return waiting.report.plan.session == session_;
  }
  [[nodiscard]] bool may_be_asked_for(const Waiting& waiting) const;
  [[nodiscard]] bool is_settled(const Waiting& waiting, Clock::TimePoint now) const;
  [[nodiscard]] bool is_wanted(const RowBlock& block) const;
  [[nodiscard]] bool is_claimed(const StreamKey& stream, const SequenceRange& run) const;
  [[nodiscard]] std::size_t free_slots() const;
  [[nodiscard]] std::vector<SequenceRange> gaps(const TrialReport& report) const;
  [[nodiscard]] bool make_room(std::size_t rows, const StreamKey& stream, std::uint64_t first_sequence);
  /// False: given up.
  [[nodiscard]] bool ask(Waiting& waiting, Clock::TimePoint now, std::vector<ResendRequest>& requests);
  [[nodiscard]] MeasuredTrial finish(WaitingTrials::iterator trial);
  void forget_oldest_foreign();

  AssemblerLimits limits_;
  Id session_{};
  /// By the start of the agent: room is made among the oldest rows.
  struct OldestFirst {
    bool operator()(const StreamKey& a, const StreamKey& b) const {
      return std::tie(a.epoch, a.rig) < std::tie(b.epoch, b.rig);
    }
  };
  std::map<StreamKey, RowStore, OldestFirst> streams_;
  WaitingTrials waiting_;
  std::set<Id> done_;
  std::deque<Id> done_order_;
  std::size_t rows_held_ = 0;
  AssemblerCounts counts_;
};

}  // namespace tonus::identification
