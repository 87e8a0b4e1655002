#include "rig_agent/drivers/comedi_config.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "services/config/checked_table.hpp"
#include "services/config/toml_text.hpp"
#include "services/core/text_file.hpp"
#include "services/mechanics/auxiliary_channel.hpp"

namespace tonus::drivers {
namespace {

using config::CheckedTable;

constexpr unsigned kMostChannels = 255;
constexpr unsigned kEveryBit = 0xffffffff;  // of a counter's mode, as the card's driver has it

void read_pair(CheckedTable& table, const char* key, bool is_needed, std::array<ComediChannel, 2>& channels,
               unsigned ComediChannel::*member) {
  std::array<unsigned, 2> numbers{channels[0].*member, channels[1].*member};
  table.one_or_two(key, numbers, 0, kMostChannels, is_needed);
  for (std::size_t i = 0; i < channels.size(); ++i) channels[i].*member = numbers[i];
}

unsigned read_number(CheckedTable& table, const char* key) {
  return static_cast<unsigned>(table.whole(key, 0, kMostChannels));
}

void read(CheckedTable encoders, std::array<ComediChannel, 2>& channels, std::optional<unsigned>& mode) {
  read_pair(encoders, "subdevice", true, channels, &ComediChannel::subdevice);
  read_pair(encoders, "channel", true, channels, &ComediChannel::channel);
  if (encoders.has("counter_mode")) encoders.count("counter_mode", mode.emplace(0), 0, kEveryBit);
  encoders.finish();
}

/// `reference`: where an analogue input's second wire is. Nothing where the value is refused.
std::optional<unsigned> read_reference(CheckedTable& input) {
  static const std::vector<std::string> kReferences{"ground", "common", "differential", "other"};
  const auto name = input.one_of("reference", kReferences, kReferences.front());
  const auto found = std::find(kReferences.begin(), kReferences.end(), name);
  if (found == kReferences.end()) return {};
  return static_cast<unsigned>(found - kReferences.begin());
}

void read_force(CheckedTable force, std::array<ComediChannel, 2>& channels) {
  read_pair(force, "subdevice", true, channels, &ComediChannel::subdevice);
  read_pair(force, "channel", true, channels, &ComediChannel::channel);
  read_pair(force, "range", false, channels, &ComediChannel::range);
  if (const auto reference = read_reference(force)) {
    for (auto& channel : channels) channel.reference = *reference;
  }
  force.finish();
}

void read_motors(CheckedTable motors, ComediConfig& config) {
  constexpr const char* kFactors = "torque_Nm_per_V";
  read_pair(motors, "subdevice", true, config.motors, &ComediChannel::subdevice);
  read_pair(motors, "channel", true, config.motors, &ComediChannel::channel);
  read_pair(motors, "range", false, config.motors, &ComediChannel::range);
  const Eigen::Vector2d factors = motors.vector(kFactors, {-1e3, 1e3});
  config.torque_per_volt = {factors[0], factors[1]};
  if (motors.has(kFactors) && !(factors.cwiseAbs().minCoeff() >= 1e-3))
    motors.refuse(kFactors, "two numbers from 0.001 to 1000, or their negatives");
  motors.finish();
}

ComediChannel read_line(CheckedTable& line) {
  ComediChannel channel;
  channel.subdevice = read_number(line, "subdevice");
  channel.channel = read_number(line, "channel");
  return channel;
}

ComediAuxiliary read_auxiliary(CheckedTable table) {
  ComediAuxiliary auxiliary;
  auxiliary.name = table.text("name", 1, 32);
  auxiliary.input = read_line(table);
  table.count("range", auxiliary.input.range, 0, kMostChannels);
  auxiliary.input.reference = read_reference(table).value_or(0);
  table.finish();
  return auxiliary;
}

void read(CheckedTable comedi, ComediConfig& config) {
  config.device = comedi.text("device", 1, 255, config.device);
  read(comedi.table("encoders"), config.encoders, config.counter_mode);
  read_force(comedi.table("force"), config.force);
  read_motors(comedi.table("motors"), config);
  if (comedi.has("emergency_stop")) {
    CheckedTable stop = comedi.table("emergency_stop");
    config.emergency_stop = read_line(stop);
    stop.flag("is_pressed_when_high", config.is_pressed_when_high);
    stop.finish();
  }
  const auto read_output = [&comedi](const char* key, std::optional<ComediChannel>& output) {
    if (!comedi.has(key)) return;
    CheckedTable line = comedi.table(key);
    output = read_line(line);
    line.finish();
  };
  read_output("enable", config.enable);
  read_output("heartbeat", config.heartbeat);
  read_output("onset", config.onset);
  for (CheckedTable& table : comedi.tables("auxiliary", 0, kMostAuxiliaryChannels))
    config.auxiliary.push_back(read_auxiliary(table));
  comedi.finish();
}

}  // namespace

std::vector<config::Key> comedi_keys() {
  return config::keys_of([](CheckedTable root, config::Findings&) {
    ComediConfig config;
    read(root.table("comedi"), config);
  });
}

Result<ComediConfig> parse_comedi_config(std::string_view text, const std::string& source) {
  TONUS_TRY_ASSIGN(const toml::table root, config::parse_toml(text, source));
  config::Findings findings{source, {}, {}};
  ComediConfig config;
  read(CheckedTable(root, "", 0, findings).table("comedi"), config);
  if (findings.problem) return fail(ErrorCode::kInvalidArgument, *findings.problem);
  return config;
}

Result<ComediConfig> load_comedi_config(const std::filesystem::path& file) {
  auto text = read_text_file(file);
  if (!text) return text.error();
  return parse_comedi_config(*text, file.string());
}

}  // namespace tonus::drivers
