#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "services/contract/sequence.hpp"
#include "services/core/id.hpp"
#include "services/mechanics/auxiliary_series.hpp"
#include "services/mechanics/rig_geometry.hpp"

/// What was measured in a trial, in the terms of this service: free of the wire's types.
namespace tonus::identification {

/// Part of a trial that a row belongs to, in the order in which a trial runs through them.
enum class Phase : std::uint8_t {
  kIdle,
  kCentring,
  kWaiting,
  kBiasRamp,
  kBiasHold,
  kPerturbing,
  kReturning,
  kSafe,  ///< A fault is latched.
};

/// One acquired row. Rows are numbered without gaps per rig and start of its agent (epoch).
struct Row {
  RawSample raw;
  std::array<double, 2>
      commanded{};  ///< m in S, commanded displacement from the posture; not finite: not known.
  Phase phase = Phase::kIdle;
  bool is_saturated = false;  ///< The rig saw a force channel at its end stop.
  bool is_missing = false;    ///< Nothing was measured here: lost for good, or n/a in a replayed recording.
};

/// Rows first_sequence, first_sequence + 1, ... of one rig and epoch. The rows belong to whoever made the
/// block.
struct RowBlock {
  Id rig{};
  Id trial{};  ///< kNoId outside a trial.
  std::uint64_t epoch = 0;
  std::uint64_t first_sequence = 0;
  std::span<const Row> rows;
};

/// What the auxiliary channels gave during rows first_sequence .. first_sequence + rows - 1, row by row, in
/// each by channel. The values belong to whoever made the block.
struct AuxiliaryRows {
  Id rig{};
  Id trial{};  ///< kNoId outside a trial.
  std::uint64_t epoch = 0;
  std::uint64_t first_sequence = 0;
  std::uint32_t rows = 0;
  std::span<const float> values;

  [[nodiscard]] SequenceRange range() const { return {first_sequence, first_sequence + rows}; }
};

enum class TrialKind : std::uint8_t {
  kPerturbation,  ///< One perturbation from rest.
  kRecording,     ///< The whole of a replayed continuous record.
  kContraction,   ///< The subject contracts, the handle is still: the reference of muscle activity.
};

/// How the rig says that a trial ended.
enum class TrialEnd : std::uint8_t {
  kCompleted,
  kAborted,
  kFaulted,
  kNotCentred,
  kBiasNotReached,
  kRefused,
  kBrokenOff,
};

/// What a trial was to be. Vectors in S, SI.
struct TrialPlan {
  Id trial{};
  Id session{};
  Id rig{};
  std::uint32_t attempt = 0;
  std::uint32_t planned_index = 0;
  TrialKind kind = TrialKind::kPerturbation;
  std::string posture;
  std::uint32_t posture_index = 0;
  Eigen::Vector2d position = Eigen::Vector2d::Zero();  ///< The hand's place, m.
  bool is_place_known = true;                          ///< False: `position` says nothing.
  ShoulderPose shoulder;
  std::int32_t set = 0;
  std::string instruction;                         ///< Empty: hold still.
  Eigen::Vector2d bias = Eigen::Vector2d::Zero();  ///< N, on the arm.
  double bias_hold = 0.0;                          ///< s.
  double bias_threshold = 0.0;                     ///< N; 0: not stated.

  [[nodiscard]] bool is_loaded() const { return bias != Eigen::Vector2d::Zero(); }
};

/// What the rig reports at a trial's end. `range` and `onset` mean nothing where it was refused.
struct TrialReport {
  TrialPlan plan;
  std::uint64_t epoch = 0;
  TrialEnd end = TrialEnd::kCompleted;
  std::string detail;
  SequenceRange range;
  std::uint64_t onset = 0;   ///< Sequence number of the first row of the perturbation.
  double sample_rate = 0.0;  ///< Hz.
};

/// A trial with its rows in order: rows[i] is number range.first + i. Where a row is lost for good, a
/// placeholder stands that is marked as missing. No rows at all where the trial was refused or its range
/// cannot be.
struct MeasuredTrial {
  TrialReport report;
  std::vector<Row> rows;
  std::vector<AuxiliarySeries> auxiliary;  ///< During the rows; empty: the rig describes none.
  std::uint64_t missing_rows = 0;          ///< Lost ones, those missing in a replayed recording not counted.
  std::uint32_t resend_requests = 0;
};

}  // namespace tonus::identification
