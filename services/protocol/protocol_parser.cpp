#include <algorithm>
#include <cmath>
#include <set>
#include <spdlog/fmt/fmt.h>

#include "services/config/checked_table.hpp"
#include "services/config/toml_text.hpp"
#include "services/protocol/protocol.hpp"

namespace tonus::protocol {
namespace {

constexpr std::size_t kTextMost = 40000;   // the plan carries the text in one message
constexpr std::size_t kPosturesMost = 64;  // as the plan's list
constexpr int kTrialsMost = 20000;
constexpr config::Limits kAmplitudes{0.0005, 0.03, "m"};
constexpr config::Limits kRises{0.02, 2.0, "s"};
constexpr int kLeastTrials = 5;        // an estimate of fewer is never ok
constexpr double kHandNearest = 0.10;  // m from the shoulder
constexpr double kHandFarthest = 0.90;
constexpr BiasAxis kAxes[] = {BiasAxis::kNone, BiasAxis::kMajorPlus, BiasAxis::kMajorMinus,
                              BiasAxis::kMinorPlus, BiasAxis::kMinorMinus};

std::string read_name(config::CheckedTable& table, std::set<std::string>& taken) {
  std::string name = table.text("name", 1, 40);
  const auto is_plain = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-';
  };
  if (!std::all_of(name.begin(), name.end(), is_plain)) table.refuse("name", "letters, digits, _ and - only");
  if (!name.empty() && !taken.insert(name).second) table.refuse("name", "each name once");
  return name;
}

std::vector<Posture> read_postures(config::CheckedTable& root) {
  std::vector<Posture> postures;
  std::set<std::string> names;
  for (config::CheckedTable& table : root.tables("posture", 1, kPosturesMost)) {
    Posture posture{read_name(table, names), table.vector("position_m", {-1.0, 1.0, "m"})};
    const double distance = posture.position.norm();
    if (distance < kHandNearest || distance > kHandFarthest) {
      table.refuse("position_m", fmt::format("{:g} to {:g} m from the shoulder (this is {:.3f} m)",
                                             kHandNearest, kHandFarthest, distance));
    }
    table.finish();
    postures.push_back(std::move(posture));
  }
  return postures;
}

Perturbation read_perturbation(config::CheckedTable& root) {
  config::CheckedTable table = root.table("perturbation");
  Perturbation p;
  p.directions = table.whole("directions", 1, 64);
  p.first_direction = table.number("first_direction_deg", {-360.0, 360.0, "deg"}, 0.0);
  p.sets = table.whole("sets", 1, 20);
  p.repeats = table.whole("repeats", 1, 20, 1);
  p.amplitude = table.number("amplitude_m", kAmplitudes);
  if (table.has("second_amplitude_m")) p.second_amplitude = table.number("second_amplitude_m", kAmplitudes);
  if (p.second_amplitude && p.sets < 2)
    table.refuse("sets", "2 or more beside second_amplitude_m, which every second set has");
  p.rise_time = table.number("rise_time_s", kRises);
  p.hold = table.span("hold_s", {0.2, 30.0, "s"});
  p.wait = table.span("wait_s", {0.2, 60.0, "s"});
  p.end_rest = table.number("end_rest_s", {0.0, 10.0, "s"}, 0.2);
  if (p.hold.low < p.rise_time + p.end_rest) {
    table.refuse("hold_s",
                 fmt::format("at least rise_time_s + end_rest_s = {:g} s", p.rise_time + p.end_rest));
  }
  table.finish();
  return p;
}

Bias read_bias(config::CheckedTable& root, const Perturbation& perturbation) {
  config::CheckedTable table = root.table("bias");
  std::vector<std::string> names;
  for (const BiasAxis axis : kAxes) names.emplace_back(axis_name(axis));
  Bias bias;
  for (const std::string& name : table.texts("sets_along", names)) {
    bias.axes.push_back(kAxes[std::find(names.begin(), names.end(), name) - names.begin()]);
  }
  if (bias.axes.size() != static_cast<std::size_t>(perturbation.sets)) {
    table.refuse("sets_along", fmt::format("one entry for each of the {} sets", perturbation.sets));
  } else if (bias.axes.front() != BiasAxis::kNone) {
    table.refuse("sets_along", "none as the first: the stiffness of set one gives the axes");
  }
  bias.force = table.span("force_N", {kSmallestBias, 20.0, "N"});
  bias.ramp = table.span("ramp_s", {0.1, 20.0, "s"});
  bias.hold = table.span("hold_s", {0.1, 20.0, "s"});
  bias.threshold = table.number("threshold_N", {0.01, 5.0, "N"});
  if (bias.threshold >= bias.force.low) {
    table.refuse("threshold_N", fmt::format("less than the smallest bias force, {:g} N", bias.force.low));
  }
  bias.method =
      table.one_of("stiffness_method", {"lowpass", "optimal", "state_variable", "refined"}, "state_variable");
  table.finish();
  return bias;
}

std::optional<double> read_goal(config::CheckedTable& table, const char* key) {
  if (!table.has(key)) return std::nullopt;
  return table.number(key, {0.001, 1.0});
}

/// `planned`: trials of a condition without it.
StopWhen read_stop_when(config::CheckedTable& root, const Perturbation& perturbation, int planned) {
  config::CheckedTable table = root.table("stop_when");
  StopWhen rule;
  rule.stiffness = table.number("stiffness", {0.001, 1.0});
  rule.mass = read_goal(table, "mass");
  rule.damping = read_goal(table, "damping");
  rule.method = table.one_of("method", {"lowpass", "optimal", "state_variable", "refined"}, "refined");
  rule.trials_least = table.whole("trials_least", kLeastTrials, 1024, 8);
  rule.trials_most = planned;
  if (table.has("trials_most")) rule.trials_most = table.whole("trials_most", kLeastTrials, 1024);
  if (rule.trials_most > planned) {
    table.refuse("trials_most",
                 fmt::format("at most the {} trials that perturbation plans for a condition", planned));
  } else if (rule.trials_least >= rule.trials_most) {
    table.refuse("trials_least", fmt::format("less than the most, {}", rule.trials_most));
  }
  rule.amplitude_most = perturbation.amplitude;
  if (table.has("amplitude_most_m")) rule.amplitude_most = table.number("amplitude_most_m", kAmplitudes);
  if (rule.amplitude_most < perturbation.amplitude)
    table.refuse("amplitude_most_m", fmt::format("at least amplitude_m, {:g} m", perturbation.amplitude));
  rule.rise_least = perturbation.rise_time;
  if (table.has("rise_least_s")) rule.rise_least = table.number("rise_least_s", kRises);
  if (rule.rise_least > perturbation.rise_time)
    table.refuse("rise_least_s", fmt::format("at most rise_time_s, {:g} s", perturbation.rise_time));
  const double most = std::log2(perturbation.directions);
  rule.entropy = table.number("entropy_bits", {0.0, 6.0}, 1.0);
  if (rule.entropy > most) {
    table.refuse("entropy_bits",
                 fmt::format("0 to {:.3g}, what {} directions have", most, perturbation.directions));
  }
  table.finish();
  return rule;
}

std::vector<Instruction> read_instructions(config::CheckedTable& root) {
  std::vector<Instruction> instructions;
  std::set<std::string> names;
  for (config::CheckedTable& table : root.tables("instruction", 1, 16)) {
    Instruction instruction;
    instruction.name = read_name(table, names);
    instruction.text = table.text("text", 1, 200);
    table.finish();
    instructions.push_back(std::move(instruction));
  }
  return instructions;
}

std::vector<RecordedEvent> read_events(config::CheckedTable& recording, int count) {
  std::vector<RecordedEvent> events;
  for (config::CheckedTable& table : recording.tables("event", 0, 4096)) {
    RecordedEvent event;
    event.set = table.whole("set", 1, 1000, 1);
    event.direction = table.number("direction_deg", {-360.0, 360.0, "deg"}, 0.0);
    event.amplitude = table.number("amplitude_m", {0.0, 1.0, "m"}, 0.0);
    event.rise_time = table.number("rise_time_s", {0.0, 10.0, "s"}, 0.0);
    event.hold = table.number("hold_s", {0.0, 3600.0, "s"}, 0.0);
    event.bias = table.vector("bias_N", {-100.0, 100.0, "N"}, Eigen::Vector2d(0.0, 0.0));
    table.finish();
    events.push_back(event);
  }
  if (!events.empty() && events.size() != static_cast<std::size_t>(count)) {
    recording.refuse("events", fmt::format("as many as there are tables [[event]], {}", events.size()));
  }
  return events;
}

std::vector<Recording> read_recordings(config::CheckedTable& root) {
  std::vector<Recording> recordings;
  std::set<std::string> names;
  for (config::CheckedTable& table : root.tables("recording", 1, kPosturesMost)) {
    Recording r;
    r.name = read_name(table, names);
    r.is_whole = table.one_of("play", {"whole", "events"}, "whole") == "whole";
    r.event_count = table.whole("events", 0, 4096, 0);
    if (!r.is_whole && r.event_count == 0) {
      if (table.has("events")) {
        table.refuse("events", "1 to 4096 where play = \"events\"");
      } else {
        table.refuse("play", "\"whole\", or \"events\" together with the key events, their number");
      }
    }
    r.events = read_events(table, r.event_count);
    r.position = table.vector("position_m", {-1.0, 1.0, "m"}, Eigen::Vector2d(0.0, 0.0));
    r.shoulder = table.vector("shoulder_m", {-5.0, 5.0, "m"}, Eigen::Vector2d(0.0, 0.0));
    r.shoulder_angle = table.number("shoulder_angle_rad", {-6.2832, 6.2832, "rad"}, 0.0);
    r.instruction = table.text("instruction", 0, 200, "");
    r.duration = table.number("duration_s", {0.0, 86400.0, "s"}, 0.0);
    table.finish();
    recordings.push_back(std::move(r));
  }
  return recordings;
}

std::vector<StudySubject> read_subjects(config::CheckedTable& root) {
  std::vector<StudySubject> subjects;
  std::set<std::string> names;
  for (config::CheckedTable& table : root.tables("subject", 1, 1000)) {
    StudySubject subject;
    subject.name = read_name(table, names);
    subject.unloaded = table.text("unloaded", 1, 200);
    subject.loaded = table.text("loaded", 1, 200, "");
    subject.instruction = table.text("instruction", 1, 200, "");
    subject.seed = table.seed("seed", subjects.size() + 1);
    table.finish();
    subjects.push_back(std::move(subject));
  }
  return subjects;
}

CueSettings read_cue(config::CheckedTable& root) {
  CueSettings cue;
  if (!root.has("cue")) return cue;
  config::CheckedTable table = root.table("cue");
  cue.target_diameter = table.number("target_circle_diameter_m", {0.001, 0.1, "m"}, cue.target_diameter);
  cue.text = table.text("text", 0, 200, "");
  table.flag("shows_cursor", cue.shows_cursor);
  table.finish();
  return cue;
}

Muscles read_muscles(config::CheckedTable& root) {
  Muscles muscles;
  if (root.has("limits")) {
    config::CheckedTable table = root.table("limits");
    if (table.has("muscle_activity"))
      muscles.most_activity = table.number("muscle_activity", {0.001, 10.0, ""});
    table.finish();
  }
  for (config::CheckedTable& table : root.tables("antagonists", 0, 16)) {
    muscles.antagonists.push_back({table.text("first", 1, 40), table.text("second", 1, 40)});
    if (muscles.antagonists.back().first == muscles.antagonists.back().second)
      table.refuse("second", "another channel than first");
    table.finish();
  }
  if (root.has("reference_contraction")) {
    config::CheckedTable table = root.table("reference_contraction");
    muscles.reference.trials = table.whole("trials", 1, 20, 2);
    muscles.reference.duration = table.number("duration_s", {1.0, 30.0, "s"}, muscles.reference.duration);
    table.finish();
  } else if (std::isfinite(muscles.most_activity)) {
    root.refuse("limits", "a table [reference_contraction] too: muscle_activity is a share of it");
  }
  return muscles;
}

void check_size(const Protocol& p, config::Findings& findings) {
  const double trials = static_cast<double>(p.postures.size() * p.instructions.size()) *
                        p.perturbation.directions * p.perturbation.repeats * p.perturbation.sets;
  if (trials > kTrialsMost) {
    findings.refuse("perturbation", fmt::format("a protocol of {:g} trials", trials),
                    fmt::format("1 to {}", kTrialsMost));
  }
}

/// What all kinds begin with; gives the kind.
ProtocolKind read_head(config::CheckedTable& root, Protocol& protocol) {
  (void)root.whole("schema", kProtocolSchema, kProtocolSchema);
  std::vector<std::string> kinds;
  for (const ProtocolKind kind : kProtocolKinds) kinds.emplace_back(kind_name(kind));
  const std::string kind = root.one_of("kind", kinds);
  protocol.name = root.text("name", 1, 80);
  return kProtocolKinds[std::min<std::ptrdiff_t>(std::find(kinds.begin(), kinds.end(), kind) - kinds.begin(),
                                                 std::ssize(kinds) - 1)];
}

void read_session(config::CheckedTable& root, Protocol& p, config::Findings& findings) {
  root.flag("confirm_posture", p.confirms_posture);
  p.rejection_limit = root.whole("rejection_limit", 1, 1000, 8);
  p.cue = read_cue(root);
  if (p.kind == ProtocolKind::kRecording) {
    p.recordings = read_recordings(root);
    p.instructions = {{"", p.cue.text}};
    return;
  }
  p.shoulder_angle = root.number("shoulder_angle_rad", {-6.2832, 6.2832, "rad"}, 0.0);
  p.postures = read_postures(root);
  p.perturbation = read_perturbation(root);
  if (p.kind == ProtocolKind::kLoaded) p.bias = read_bias(root, p.perturbation);
  if (root.has("stop_when")) {
    const int in_set = p.perturbation.directions * p.perturbation.repeats;
    p.stop_when = read_stop_when(root, p.perturbation, p.bias ? in_set : in_set * p.perturbation.sets);
  }
  if (p.kind == ProtocolKind::kInstruction) {
    p.instructions = read_instructions(root);
  } else {
    p.instructions = {{"", p.cue.text}};
  }
  p.muscles = read_muscles(root);
  if (p.stop_when && p.muscles.reference.trials > 0)
    root.refuse("stop_when", "none beside reference_contraction, whose trials are of no condition");
  if (p.stop_when && p.perturbation.second_amplitude)
    root.refuse("stop_when",
                "none beside perturbation.second_amplitude_m: it raises the amplitude by itself");
  check_size(p, findings);
}

}  // namespace

std::vector<config::Key> protocol_keys(ProtocolKind kind) {
  return config::keys_of([kind](config::CheckedTable root, config::Findings& findings) {
    Protocol protocol;
    protocol.kind = kind;
    read_head(root, protocol);
    if (kind == ProtocolKind::kStudy) {
      (void)read_subjects(root);
    } else {
      read_session(root, protocol, findings);
    }
  });
}

Result<Protocol> parse_protocol(std::string_view text, const std::string& source) {
  if (text.size() > kTextMost) {
    return fail(ErrorCode::kInvalidArgument,
                fmt::format("{}: a protocol of {} bytes is not allowed; expected at most {}", source,
                            text.size(), kTextMost));
  }
  TONUS_TRY_ASSIGN(const toml::table table, config::parse_toml(text, source));

  Protocol protocol;
  protocol.text = text;
  protocol.source = source;
  config::Findings findings{source, {}, {}};
  config::CheckedTable root(table, "", 1, findings);
  const auto kind = read_head(root, protocol);
  if (!findings.problem) {
    protocol.kind = kind;
    if (protocol.kind == ProtocolKind::kStudy) {
      protocol.subjects = read_subjects(root);
    } else {
      read_session(root, protocol, findings);
    }
    root.finish();
  }
  if (findings.problem) return fail(ErrorCode::kInvalidArgument, *findings.problem);
  protocol.lines = std::move(findings.lines);
  return protocol;
}

}  // namespace tonus::protocol
