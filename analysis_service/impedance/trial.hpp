#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "analysis_service/impedance/axes.hpp"
#include "services/core/result.hpp"
#include "services/mechanics/rig_geometry.hpp"

namespace tonus::impedance {

/// One perturbation, converted and prepared: what every identification starts from. Shapes: all signals have
/// the same number of rows (samples, equally spaced by sample_period) and axes() columns (1 or 2).
/// Frame: the shoulder frame S (one-axis rigs: the rig's own axis and units). Sign: force is that of the
/// handle on the arm.
struct Trial {
  std::uint32_t number = 0;    ///< Unique within the condition; results do not depend on the order given.
  double sample_period = 0.0;  ///< s.
  Eigen::Index onset = 0;      ///< Row at which the perturbation starts; the rows before it are rest.
  Signals displacement;        ///< m, X of (3), from the mean position of the rest.
  Signals force;               ///< N, F of (3).
  Signals commanded;           ///< m, commanded displacement; no rows where it is not known.
  /// What preparation took away as the rest's means (axes), m and N; empty: nothing.
  AxisVector displacement_taken{};
  AxisVector force_taken{};
  double handle_mass = 0.0;    ///< kg, m_h; its inertia m_h X" is taken from the force in the fit.
  bool is_clipped = false;     ///< The force sensor or its converter was at its limit (see is_clipped()).
  bool is_continuous = false;  ///< A stochastic record without onset: all of it is fitted, cut into blocks.
  /// Of a continuous record, by row: it has no sample, its signals are zero. Empty: every row has one.
  std::vector<bool> is_missing{};

  [[nodiscard]] int axes() const { return static_cast<int>(displacement.cols()); }
  [[nodiscard]] Eigen::Index samples() const { return displacement.rows(); }
};

/// How converted samples become a Trial.
struct Preparation {
  int axes = 2;                ///< 1 or 2.
  double sample_period = 0.0;  ///< s, more than 0.
  double rest = 0.5;           ///< s of rest before the onset that are used; older samples are left out.
  bool is_force_tared =
      true;  ///< Takes the mean force of the rest away. False for loaded trials: the bias counts.
  double handle_mass = 0.0;  ///< kg, 0 or more.
};

/// Refuses a Preparation outside the limits stated at its fields.
[[nodiscard]] Result<void> validate(const Preparation& preparation);

/// Cuts the rest to its length, takes away the mean position of the rest and, where asked, its mean force.
/// `onset` counts rows of `samples`; `commanded` is empty or as long as `samples`.
/// Errors: kInvalidArgument for an onset without rest before it or beyond the end; kDataLoss for a value that
/// is not finite, or for acquisition stamps that are not one sample_period apart (a gap). Stamps that are all
/// equal are taken as absent.
[[nodiscard]] Result<Trial> prepare_trial(std::uint32_t number, std::span<const EndpointSample> samples,
                                          Eigen::Index onset, const Preparation& preparation,
                                          std::span<const Eigen::Vector2d> commanded = {});

/// Takes the mean position of the rest and, where asked, its mean force away, and keeps what was taken. The
/// trial has rest.
void tare(Trial& trial, bool is_force_tared);

/// A continuous (stochastic) record: the mean position and, where tared, the mean force of the whole record
/// are taken away. Rows marked in `is_missing` (empty, or one a sample) have no sample: what they hold is not
/// looked at. Errors as prepare_trial.
[[nodiscard]] Result<Trial> prepare_record(std::uint32_t number, std::span<const EndpointSample> samples,
                                           const Preparation& preparation,
                                           std::span<const Eigen::Vector2d> commanded = {},
                                           std::vector<bool> is_missing = {});

/// True where a force channel stood at its limit: |V| >= force_saturation_V.
[[nodiscard]] bool is_clipped(std::span<const RawSample> raw, double saturation_V);

/// Mean of each column over rows [first, first + rows), summed from the first row on: the same bits wherever
/// it is called. No allocation.
[[nodiscard]] AxisVector mean_of_rows(const Signals& signals, Eigen::Index first, Eigen::Index rows);

}  // namespace tonus::impedance
