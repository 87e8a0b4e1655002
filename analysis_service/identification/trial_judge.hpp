#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "analysis_service/identification/measured_trial.hpp"
#include "services/mechanics/rig_geometry.hpp"

namespace tonus::identification {

/// Why a trial does not count.
enum class Defect : std::uint8_t {
  kNotCompleted,    ///< The rig did not run it to its end, or there is no rest before its onset.
  kOffTarget,       ///< The hand was outside the target circle before the onset.
  kBiasNotReached,  ///< The bias force never came within its threshold.
  kBiasNotHeld,     ///< It did, and left it before the onset.
  kEarlyReaction,   ///< The hand moved or pushed before the onset.
  kSaturated,       ///< The force sensor was at its end stop.
  kGap,             ///< Rows are missing for good.
  kExcursion,       ///< The hand moved further than allowed.
  kNotAtRest,       ///< It still moved at the end of the perturbation.
  kUnknownRig,      ///< No description to convert with.
  kLetGo,           ///< The handle was moved, and nothing resisted it.
};

/// What a valid trial keeps within. Defaults are those of the published protocol where it states one.
struct JudgeLimits {
  double start_offset = 0.005;  ///< m, half of the published target circle's diameter of 0.010 m.
  double recording_gaps = 0.5;  ///< Share of a continuous recording's rows that may be missing.
  /// m, between the ends of a continuous recording's motion: more than any limb moves is another unit.
  double recording_range = 5.0;
  double excursion = 0.015;  ///< m from the rest. Published: perturbations stayed within 0.010 m.

  /// m/s before the onset: half of the peak of the published perturbation (0.005 m in 0.2 s peaks at 0.039
  /// m/s).
  double rest_speed = 0.020;
  /// N before the onset, unloaded: mean force at rest. More than the published bias force (0.7 to 1.0 N) is a
  /// push.
  double rest_force = 1.0;
  /// N before the onset, unloaded: largest change of force within the rest, from its mean.
  double rest_force_change = 0.5;
  /// m/s at the end of the perturbation. The published perturbation is underdamped (damping ratio about 0.1)
  /// and may end after 1.5 s: what is left of its ringing then stays below 0.020 m/s. A hand that lets go or
  /// acts is faster.
  double end_speed = 0.025;

  /// N, of a hand that holds the handle where it has to push (Measured::resistance). Less is no hand: the
  /// weakest published stiffness at 2 mm of displacement gives 0.1 N, a bare handle at rest gives none.
  double resistance = 0.05;
  double resisted_displacement = 0.002;  ///< m at the end, unloaded; with less nothing is said of resistance.

  double rest = 0.5;        ///< s before the onset that are looked at, as many as identification uses.
  double least_rest = 0.1;  ///< s; with less there is nothing to judge the start by.
  double end = 0.2;         ///< s before the end of the perturbation; published length of the static stretch.
  double speed_window = 0.1;  ///< s, over which a speed is a slope and a force is a mean.

  double bias_threshold = 0.2;  ///< N, where the trial's own plan states none.
  /// Times the threshold. The rig looks at a low-passed force, this judge at a mean: equal forces read
  /// differently.
  double bias_tolerance = 1.25;
};

/// What a person chooses of the limits: a preset, and single ones in its place. Live and offline judging have
/// the same choice.
struct JudgeChoice {
  /// Perturbations of a hand that moves of itself: nothing is asked of its place, rest, way and end. What
  /// remains is completeness, saturation and the bias force. False: the published protocol's limits.
  bool is_reaching = false;
  std::optional<double> start_offset;  ///< m, or rad of a rotary rig; so are the others, alike.
  std::optional<double> excursion;
  std::optional<double> rest_speed;
  std::optional<double> rest_force;
  std::optional<double> end_speed;

  /// The preset's limits in metres and newtons say nothing of angles and torques: a rotary rig has only those
  /// that were chosen singly.
  [[nodiscard]] JudgeLimits limits(bool is_rotary) const;
};

/// What was measured. Those that could not be measured are zero.
struct Measured {
  double start_offset = 0.0;  ///< m, of the hand from its place, mean of the rest; not finite: place unknown.
  double rest_speed = 0.0;    ///< m/s, largest in the rest.
  double rest_force = 0.0;    ///< N, of the mean of the rest from the bias.
  double rest_force_change = 0.0;  ///< N, largest in the rest, from its mean.
  double bias_error = 0.0;         ///< N, largest in the hold before the onset, from the bias.
  double bias_nearest = 0.0;       ///< N, smallest in the hold.
  double bias_held = 0.0;          ///< s of hold before the onset.
  double excursion = 0.0;  ///< m, largest from the mean of the rest, onset to the end of the perturbation.
  double end_speed = 0.0;  ///< m/s, largest before that end.
  /// N, mean force where a hand that holds the handle has to push: unloaded at the end of the perturbation,
  /// displaced; loaded at the end of the way back, where the hand is again in its place and the motors have
  /// given up the bias. Infinite where the trial says nothing of it.
  double resistance = std::numeric_limits<double>::infinity();
  std::uint64_t saturated_rows = 0;  ///< From the rest to the end of the perturbation.
  std::uint64_t missing_rows = 0;
};

struct Verdict {
  bool is_valid = false;
  std::vector<Defect> defects;  ///< In the order of the enumeration, each once; empty where valid.
  std::string detail;           ///< One line for a person, with values, units and limits.
  Measured measured;
};

/// Decides from what was measured, never from what was commanded, whether a trial counts (method, section 9).
///
/// A trial that the rig did not complete has that one defect. One with rows missing is not judged further but
/// for saturation, as what is missing could say anything. A replayed continuous record is judged by its
/// completeness and saturation only. `rig` null: no description is known. Phases in the rows tell the rest
/// (waiting or holding the bias) from the perturbation and the way back. Pure and thread-safe; allocates.
class TrialJudge {
 public:
  explicit TrialJudge(const JudgeLimits& limits = {}) : limits_(limits) {}

  [[nodiscard]] Verdict judge(const MeasuredTrial& trial, const RigGeometry* rig) const;
  [[nodiscard]] const JudgeLimits& limits() const { return limits_; }

 private:
  JudgeLimits limits_;
};

/// "off target", "bias not reached", ... as the detail line has them.
[[nodiscard]] std::string_view name_of(Defect defect);

}  // namespace tonus::identification
