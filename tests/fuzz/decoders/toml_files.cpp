#include <CLI/CLI.hpp>
#include <cmath>

#include "rig_agent/calibration/calibration.hpp"
#include "services/protocol/protocol.hpp"
#include "services/protocol/rig_facts.hpp"
#include "services/runtime/options.hpp"
#include "services/runtime/settings_files.hpp"
#include "services/simulation/cohort.hpp"
#include "services/simulation/profile.hpp"
#include "tests/fuzz/decoders/decoder.hpp"

namespace tonus::fuzz {
namespace {

std::vector<Bytes> source_files(std::initializer_list<const char*> paths) {
  std::vector<Bytes> seeds;
  for (const char* path : paths) seeds.push_back(source_bytes(path));
  return seeds;
}

}  // namespace

void read_protocol(std::span<const std::byte> input) {
  const auto protocol = protocol::parse_protocol(text_of(input), "p.toml");
  require_message(protocol);
  if (!protocol) return;
  require_message(protocol::check_against_rig(*protocol, protocol::RigFacts{}));
  const auto extremes = protocol::extremes_of(*protocol, protocol::RigFacts{});
  require(std::isfinite(extremes.force) && std::isfinite(extremes.farthest),
          "how far a protocol goes is a number");
}

std::vector<Bytes> protocol_seeds() {
  return source_files({"deploy/protocols/unloaded.toml", "deploy/protocols/loaded.toml",
                       "deploy/protocols/instruction.toml", "deploy/protocols/study.toml"});
}

void read_profile(std::span<const std::byte> input) {
  const std::string_view text = text_of(input);
  const auto profile = simulation::parse_profile(text, "profile.toml");
  require_message(profile);
  if (profile) static_cast<void>(simulation::loop_config(*profile));
  const auto cohort = simulation::parse_cohort(text, "cohort.toml");
  require_message(cohort);
  if (!cohort) return;
  for (const auto& subject : *cohort)
    require(simulation::parse_profile(subject.profile_toml, "subject").has_value(),
            "the profile of a cohort's subject is a profile");
}

std::vector<Bytes> profile_seeds() {
  return source_files(
      {"deploy/profiles/default.toml", "deploy/profiles/holding.toml", "deploy/profiles/cohort.toml"});
}

void read_rig(std::span<const std::byte> input) {
  const auto read = calibration::Calibration::parse(text_of(input), "calibration.toml", "simulated");
  require_message(read);
  if (!read) return;
  static_cast<void>(read->applied_to(RigGeometry{}));
  static_cast<void>(read->loads());
  const std::string text = read->text();
  const auto again = calibration::Calibration::parse(text, "calibration.toml", "simulated");
  require(text.empty() || (again && again->text() == text),
          "a calibration is the same after it is written and read");
}

std::vector<Bytes> rig_seeds() {
  calibration::Calibration full("simulated");
  const calibration::Signature who{"2026-03-01T10:00:00Z", "Anna"};
  calibration::RestReading rest;
  rest.samples = 100;
  full.set_tare(rest, who);
  full.set_zero(rest, {0.0, 0.45}, {100.0, -40.0}, who);
  static_cast<void>(full.add_load({{0.0, -9.81}, {0.1, 1.2}, 0.3}, who));
  return {bytes_of(full.text())};
}

void read_settings(std::span<const std::byte> input) {
  const std::string path = scratch_folder() + "/tonus.toml";
  write_bytes(path, Bytes(input.begin(), input.end()));
  const auto file = runtime::SettingsFile::open(path);
  require_message(file);
  if (!file || !*file) return;
  CLI::App app("", "tonus-archive");
  runtime::CommonOptions options;
  runtime::add_common_options(app, options);
  require_message((*file)->check_top(app, {"archive", "rig-agent", "tonus"}));
  require_message((*file)->check_section({"archive"}, app));
  static_cast<void>((*file)->find({"archive"}, "domain"));
}

std::vector<Bytes> settings_seeds() {
  return {
      bytes_of("domain = 47\npeers = [\"10.0.0.1\", \"10.0.0.2\"]\n[archive]\nlog-level = \"info\"\n"
               "[archive.nested]\nx = 1.5\n")};
}

}  // namespace tonus::fuzz
