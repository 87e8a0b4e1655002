#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include "analysis_service/identification/condition_book.hpp"
#include "analysis_service/identification/conversion.hpp"
#include "analysis_service/impedance/streaming_identifier.hpp"

namespace tonus::identification {

/// What is known of a condition while a perturbation is under way: the trials of it that count so far, and
/// the running one up to its newest row.
///
/// Contract: start() when a trial's first row is there, push() its rows in order and without gaps, settle()
/// once with every verdict, whether the trial was followed or not. After settle() the estimate of a condition
/// stands on the trials that count, and on the same numbers as if each had been followed to the end. Only
/// perturbations of the state-variable method with model (3) or (13) run sample by sample; others are let
/// pass. push() allocates nothing after a condition's first trial but for the conversion of rows. Not
/// thread-safe.
class LiveEstimator {
 public:
  explicit LiveEstimator(const impedance::Options& options) : options_(options) {}

  /// A trial begins with the row of this number. Whatever was followed before is dropped.
  void start(const TrialPlan& plan, const RigGeometry& rig, double sample_rate, std::uint64_t epoch,
             std::uint64_t first_sequence);

  /// Where the rows to push next stand.
  struct Position {
    Id rig{};
    std::uint64_t epoch = 0;
    std::uint64_t sequence = 0;
  };
  /// None: no trial is followed.
  [[nodiscard]] std::optional<Position> next() const;
  [[nodiscard]] bool follows(const Id& trial) const { return followed_ && followed_->plan.trial == trial; }

  void push(std::span<const Row> rows);

  /// The verdict on a trial is there. Errors: those of StreamingIdentifier; the trial is then not in live
  /// estimates.
  [[nodiscard]] Result<void> settle(const MeasuredTrial& trial, bool is_valid, const RigGeometry& rig);

  /// A trial of the session that counted does not count any more.
  void withdraw(const Id& session, std::uint32_t attempt);

  /// Of the trial that is followed, once it has rows after its onset.
  [[nodiscard]] std::optional<ConditionEstimate> estimate() const;

  /// Frees everything of other sessions.
  void keep_only(const Id& session);

 private:
  struct Followed {
    TrialPlan plan;
    RigGeometry rig;
    std::uint64_t epoch = 0;
    std::uint64_t first = 0;
    std::uint64_t next = 0;
    std::optional<std::uint64_t> onset;
    bool has_rest = false;
    bool is_over = false;  // the way back has begun
  };
  struct Stream {
    impedance::StreamingIdentifier identifier;
    std::vector<TrialSource> sources;
  };

  [[nodiscard]] Result<Stream*> stream_of(const TrialPlan& plan, const RigGeometry& rig, double sample_rate);
  void push(Stream& stream, Followed& followed, std::span<const Row> rows) const;
  [[nodiscard]] Result<void> add_whole(const MeasuredTrial& trial, const RigGeometry& rig);

  impedance::Options options_;
  std::map<Condition, Stream> streams_;
  std::optional<Followed> followed_;
};

}  // namespace tonus::identification
