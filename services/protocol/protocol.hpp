#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "services/config/checked_table.hpp"
#include "services/config/span.hpp"
#include "services/core/result.hpp"
#include "services/protocol/stop_rule.hpp"

/// What an experiment does, as a protocol file states it. Quantities are SI; the file's keys bear the units.
namespace tonus::protocol {

/// The version of the file's form that this program reads (key `schema`).
inline constexpr int kProtocolSchema = 1;

enum class ProtocolKind : std::uint8_t {
  kUnloaded,     ///< Perturbations at rest, at some postures.
  kLoaded,       ///< The same with bias forces along the axes of the subject's own stiffness ellipse.
  kInstruction,  ///< The same once for each instruction to the subject.
  kRecording,    ///< A recorded dataset is played.
  kStudy,        ///< A cohort: a list of subjects, each with sessions of their own.
};

inline constexpr ProtocolKind kProtocolKinds[] = {ProtocolKind::kUnloaded, ProtocolKind::kLoaded,
                                                  ProtocolKind::kInstruction, ProtocolKind::kRecording,
                                                  ProtocolKind::kStudy};

[[nodiscard]] const char* kind_name(ProtocolKind kind);

using config::Span;

struct Posture {
  std::string name;
  Eigen::Vector2d position = Eigen::Vector2d::Zero();  ///< m, hand in S.
};

/// A condition of instruction. `name` marks trials and estimates, `text` is what the subject reads.
struct Instruction {
  std::string name;  ///< Empty: hold still, nothing special.
  std::string text;
};

struct Perturbation {
  int directions = 8;                      ///< Evenly around the circle.
  double first_direction = 0.0;            ///< deg, counter-clockwise from S's x axis.
  int sets = 2;                            ///< At each posture and instruction.
  int repeats = 1;                         ///< Times that each direction comes in a set.
  double amplitude = 0.005;                ///< m
  std::optional<double> second_amplitude;  ///< m, of every second set; none: the same.
  double rise_time = 0.2;                  ///< s
  Span hold;                               ///< s, from onset to the end of the perturbation.
  Span wait;                               ///< s, at rest before the onset.
  double end_rest = 0.2;  ///< s of rest that the analysis needs at the end of the hold; only checked.

  /// m, of a set, counted from 1.
  [[nodiscard]] double amplitude_of(int set) const {
    return set % 2 == 0 ? second_amplitude.value_or(amplitude) : amplitude;
  }
};

/// Where the bias force of a set points: along an axis of the ellipse of set one's stiffness.
enum class BiasAxis : std::uint8_t { kNone, kMajorPlus, kMajorMinus, kMinorPlus, kMinorMinus };

[[nodiscard]] const char* axis_name(BiasAxis axis);

inline constexpr double kSmallestBias = 0.05;  ///< N, allowed in a protocol.

struct Bias {
  std::vector<BiasAxis> axes;  ///< One for each set.
  Span force;                  ///< N, drawn once for a set at a posture: its trials are one condition.
  Span ramp;                   ///< s, drawn for each trial.
  Span hold;                   ///< s within the threshold before the onset, drawn for each trial.
  double threshold = 0.0;      ///< N
  std::string method;          ///< Whose stiffness of set one is taken.
};

struct RecordedEvent {
  int set = 1;
  double direction = 0.0;  ///< deg
  double amplitude = 0.0;  ///< m
  double rise_time = 0.0;  ///< s
  double hold = 0.0;       ///< s
  Eigen::Vector2d bias = Eigen::Vector2d::Zero();
};

struct Recording {
  std::string name;      ///< Becomes the posture's name.
  bool is_whole = true;  ///< One trial for the whole record, else one for each event.
  int event_count = 0;
  std::vector<RecordedEvent> events;  ///< Empty, or one for each event.
  Eigen::Vector2d position = Eigen::Vector2d::Zero();
  Eigen::Vector2d shoulder = Eigen::Vector2d::Zero();  ///< m, origin of S in R.
  double shoulder_angle = 0.0;                         ///< rad
  std::string instruction;
  double duration = 0.0;  ///< s, of the record; 0: not stated.
};

struct StudySubject {
  std::string name;
  std::string unloaded;  ///< Protocol file, relative to the study's own.
  std::string loaded;    ///< Empty: none.
  std::string instruction;
  std::uint64_t seed = 0;
};

/// Trials before all others in which the subject contracts while the handle is held still.
struct ReferenceContraction {
  int trials = 0;         ///< 0: none.
  double duration = 4.0;  ///< s, each.
};

struct Antagonists {
  std::string first;  ///< Names of EMG channels.
  std::string second;
};

/// What is asked of the subject's muscles.
struct Muscles {
  /// Largest activity before the onset, as a share of the reference contraction; infinite: none.
  double most_activity = std::numeric_limits<double>::infinity();
  std::vector<Antagonists> antagonists;
  ReferenceContraction reference;
};

/// What the subject sees.
struct CueSettings {
  double target_diameter = 0.010;  ///< m
  std::string text;
  bool shows_cursor = true;
};

struct Protocol {
  ProtocolKind kind = ProtocolKind::kUnloaded;
  std::string name;
  std::string text;    ///< The whole file, as checked.
  std::string source;  ///< File name for messages.
  std::vector<Posture> postures;
  std::vector<Instruction> instructions;  ///< At least one, except in a study.
  Perturbation perturbation;
  std::optional<Bias> bias;
  std::optional<StopWhen> stop_when;  ///< None: every planned trial is run.
  std::vector<Recording> recordings;
  std::vector<StudySubject> subjects;
  CueSettings cue;
  Muscles muscles;
  double shoulder_angle = 0.0;       ///< rad, from R's x axis to S's x axis.
  bool confirms_posture = false;     ///< The operator is asked before each new posture.
  int rejection_limit = 8;           ///< Rejected trials in one set before the operator is asked.
  std::map<std::string, int> lines;  ///< Line of each key, for messages about values found bad later.
};

/// Methods whose estimates a session of the protocol needs to go on, each once.
[[nodiscard]] std::vector<std::string> methods_needed(const Protocol& protocol);

/// "source:line: key: value is not allowed; expected limits". The line is that of the key, or left out where
/// it has none.
[[nodiscard]] Error refuse_value(const Protocol& protocol, const std::string& key, const std::string& value,
                                 const std::string& expected);

/// Reads and checks a protocol completely, as far as it can be without knowing the rig. Pure. The first
/// problem is the error: kInvalidArgument with file, line, key, value and what is allowed; keys that mean
/// nothing are refused. `source` is the file's name in messages.
[[nodiscard]] Result<Protocol> parse_protocol(std::string_view text, const std::string& source);

/// Every key of a protocol of this kind, as parse_protocol() checks it.
[[nodiscard]] std::vector<config::Key> protocol_keys(ProtocolKind kind);

}  // namespace tonus::protocol
