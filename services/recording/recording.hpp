#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "services/core/result.hpp"
#include "services/mechanics/auxiliary_series.hpp"
#include "services/mechanics/rig_geometry.hpp"

/// Recordings as the files of a BIDS Motion dataset hold them, and as replay, import and off-line
/// identification take them. Nothing here is for a realtime thread.
namespace tonus::recording {

/// One row of a `_motion.tsv`. A row that the file gives as `n/a` is missing: its values are zero and mean
/// nothing.
struct Row {
  RawSample raw;
  bool is_missing = false;
};

/// One row of an `_events.tsv`, in the file's own units so that it is written again as it was read.
/// A continuous (stochastic) perturbation has no direction, and no amplitude unless one is stated.
struct PerturbationEvent {
  double onset_s = 0.0;  ///< From the record's first sample.
  double duration_s = 0.0;
  std::int64_t trial = 1;  ///< Unique in the session.
  std::int64_t set = 1;
  std::optional<double> direction_deg;  ///< In S, counter-clockwise from its x axis.
  std::optional<double> amplitude_m;
  std::optional<double> rise_time_s;
  std::array<double, 2> bias_N{};  ///< Force on the arm, in S.
  bool is_valid = true;
  std::string reason;         ///< Why it is not valid; empty where it is.
  std::string instruction{};  ///< What the subject was told; empty: hold still.
  std::optional<double> bias_hold_s{};
  std::optional<double> bias_threshold_N{};
  /// The whole trial that the perturbation is a part of, where the record has it.
  std::optional<double> trial_onset_s{};  ///< Of the trial's first sample, from the record's first.
  std::optional<double> trial_duration_s{};

  [[nodiscard]] bool is_continuous() const { return !direction_deg.has_value(); }
  bool operator==(const PerturbationEvent&) const = default;
};

/// A command that is not known.
inline constexpr std::array kNoCommand{std::numeric_limits<double>::quiet_NaN(),
                                       std::numeric_limits<double>::quiet_NaN()};

/// What becomes of an item of a dataset that is not as it should be: a run, an event, a participant's age.
enum class Imperfect : std::uint8_t {
  kRefused,  ///< The dataset is refused.
  kLeftOut,  ///< The item is left out, by name.
};

/// One row of `participants.tsv`.
struct Participant {
  std::string id;  ///< With its prefix: "sub-01".
  std::optional<double> upper_arm_m;
  std::optional<double> forearm_m;
  std::optional<double> upper_arm_circumference_m;
  std::optional<double> forearm_circumference_m;
  std::string handedness;      ///< Empty: not known.
  std::optional<double> age;   ///< Years.
  std::string sex;             ///< Empty: not known.
  bool is_age_or_more{};       ///< "89+": of people who could be known by their age.
  std::string measured_arm{};  ///< right, left; empty: not known.
  std::optional<double> height_m{};
  std::optional<double> weight_kg{};
  std::optional<double> shoulder_x_m{};  ///< Of the shoulder joint's centre, in the robot's frame.
  std::optional<double> shoulder_y_m{};

  bool operator==(const Participant&) const = default;
};

/// One row of a `_sessions.tsv`: what is said of a session as a whole.
struct SessionFacts {
  std::string started_at;     ///< ISO 8601, UTC; empty: not known.
  std::string operator_name;  ///< Empty: not known.
  std::string study;          ///< Empty: none.
  bool is_pilot = false;      ///< A rehearsal.

  bool operator==(const SessionFacts&) const = default;
};

/// What a person noted while the record was made: a row of `_events.tsv` of trial_type note or marker.
struct NoteEvent {
  double onset_s = 0.0;  ///< From the record's first sample.
  std::string kind;      ///< note, marker
  std::string text;
  std::string written_by;
  std::optional<std::int64_t> trial;  ///< That it is about.
};

/// One run: one posture of one session.
///
/// `rows` are raw where the file has raw channels (`is_raw`): encoder counts and volts, and `rig` with
/// `shoulder` turns them into endpoint and force by tonus::convert(). Where the file has only converted
/// channels, `rig` is kCartesian or kOneAxis with unit scales, so that convert() gives the numbers of the
/// file; one-axis rigs use the first components, and `rig.force_calibration(0, 0)` is the sign of the force
/// channel, +1 or -1.
///
/// Sign of a one-axis force channel: everywhere in this system the force is that of the rig on the limb. A
/// dataset whose channel is the reaction of the limb on the rig says so in `_channels.json`, "Rig": {"Axes":
/// 1, "ForceSign": -1}, or whoever uses it says so by state_force_sign(). Without either it is taken as +1
/// and `is_force_sign_stated` is false; it is never guessed from the data.
struct Recording {
  Participant participant;
  std::string session;  ///< With its prefix, "ses-01"; empty: none.
  SessionFacts session_facts;
  std::string task;
  std::string task_description;
  std::string tracking_system = "manipulandum";
  std::string acquisition;  ///< Label in the file's name; empty: none.
  int run = 1;
  double sampling_frequency = 0.0;  ///< Hz; row i was acquired i / sampling_frequency after row 0.

  bool is_raw = false;
  RigGeometry rig;
  ShoulderPose shoulder;
  std::string posture;  ///< As stated, else the acquisition label; empty: neither.
  std::optional<Eigen::Vector2d> posture_position;  ///< m, in S.
  std::string displacement_unit = "m";              ///< Of the converted displacement: "m" or "rad".
  std::string force_unit = "N";                     ///< Of the converted force: "N" or "N m".
  std::array<std::string, 2> channel_names;  ///< One-axis: names of the displacement and force channels.
  std::string tracked_point = "hand";
  bool is_force_sign_stated = true;

  std::vector<Row> rows;
  std::vector<std::array<double, 2>>
      commanded;  ///< m, displacement commanded in S; empty, or one for each row, not finite where not known.
  /// Part of a trial that each row belongs to, numbered as the contract's TrialPhase; empty, or one for each
  /// row.
  std::vector<std::uint8_t> phases;
  /// What other channels (EMG, triggers) gave with the rows: of each values_per_sample values for a row.
  std::vector<AuxiliarySeries> auxiliary;
  std::vector<PerturbationEvent> events;  ///< By onset; at least one.
  /// Reference contractions: the handle was held still while the subject contracted, and nobody was pushed.
  /// Events by onset without direction, amplitude and bias.
  std::vector<PerturbationEvent> contractions;
  std::vector<NoteEvent> notes;  ///< By onset. Written, not read.
};

/// The constants of a rig whose channels are already displacement and force: unit scales, no end stop.
[[nodiscard]] RigGeometry converted_rig(RigKind kind);

/// Sets the sign of a one-axis recording's converted force channel. kInvalidArgument: sign is not +1 or -1,
/// or the recording is raw or has two axes, whose sign its calibration or the format states already.
[[nodiscard]] Result<void> state_force_sign(Recording& recording, int sign);

/// The row's time after the first, ns: row / sampling_frequency, rounded.
[[nodiscard]] std::int64_t row_time_ns(const Recording& recording, std::size_t row);

/// Rows first .. last of a recording, both included, perturbed from `onset` on.
struct Stretch {
  std::size_t first = 0;
  std::size_t onset = 0;
  std::size_t last = 0;
};

/// The rows that go with a perturbation: from 1 s of rest before its onset to its end, as far as there are
/// rows; of a continuous one the rows from its onset for its duration. Replay and off-line identification
/// take the same, so that they give the same numbers.
[[nodiscard]] Stretch stretch_of(const Recording& recording, const PerturbationEvent& event);

/// "sub-01 ses-01 run 1 (reference)", for messages.
[[nodiscard]] std::string describe(const Recording& recording);

}  // namespace tonus::recording
