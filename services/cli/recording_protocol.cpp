#include "services/cli/recording_protocol.hpp"

#include <algorithm>
#include <cstdio>
#include <spdlog/fmt/fmt.h>
#include <sstream>
#include <toml++/toml.h>

#include "services/core/text.hpp"
#include "services/recording/dataset.hpp"

namespace tonus::cli {
namespace {

toml::table event_table(const recording::PerturbationEvent& event) {
  return toml::table{{"set", event.set},
                     {"direction_deg", event.direction_deg.value_or(0.0)},
                     {"amplitude_m", event.amplitude_m.value_or(0.0)},
                     {"rise_time_s", event.rise_time_s.value_or(0.0)},
                     {"hold_s", event.duration_s},
                     {"bias_N", toml::array{event.bias_N[0], event.bias_N[1]}}};
}

toml::table record_table(const recording::Recording& record) {
  const bool is_whole = std::any_of(record.events.begin(), record.events.end(),
                                    [](const auto& event) { return event.is_continuous(); });
  toml::table table{
      {"name", fmt::format("{}{}run-{:02}", record.posture, record.posture.empty() ? "" : "_", record.run)},
      {"play", is_whole ? "whole" : "events"},
      {"duration_s", static_cast<double>(record.rows.size()) / record.sampling_frequency},
      {"shoulder_m", toml::array{record.shoulder.origin.x(), record.shoulder.origin.y()}},
      {"shoulder_angle_rad", record.shoulder.angle}};
  if (record.posture_position) {
    table.insert("position_m", toml::array{record.posture_position->x(), record.posture_position->y()});
  }
  if (is_whole) return table;
  toml::array events;
  for (const auto& event : record.events) events.push_back(event_table(event));
  table.insert("events", static_cast<std::int64_t>(record.events.size()));
  table.insert("event", events);
  return table;
}

}  // namespace

Result<std::string> recording_protocol(const std::filesystem::path& dataset) {
  TONUS_TRY_ASSIGN(auto usable, recording::read_usable(dataset));
  TONUS_TRY(recording::keep_what_counts(usable));
  for (const auto& item : usable.left_out)
    std::fprintf(stderr, "tonus: %s: left out: %s\n", dataset.string().c_str(), shown(item).c_str());
  toml::array recordings;
  for (const auto& record : usable.recordings) recordings.push_back(record_table(record));
  const toml::table protocol{{"schema", 1},
                             {"kind", "recording"},
                             {"name", dataset.filename().empty() ? "recording" : dataset.filename().string()},
                             {"recording", recordings}};
  std::ostringstream text;
  text << protocol << "\n";
  return text.str();
}

}  // namespace tonus::cli
