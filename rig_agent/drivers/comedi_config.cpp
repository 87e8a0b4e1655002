#include "rig_agent/drivers/comedi_config.hpp"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <spdlog/fmt/fmt.h>
#include <toml++/toml.h>

#include "services/core/text_file.hpp"
#include "services/core/toml_depth.hpp"

namespace tonus::drivers {
namespace {

constexpr std::int64_t kMostChannels = 255;

/// One table while it is read; keeps the first problem.
class Section {
 public:
  Section(const toml::table* table, std::string path, std::string& problem)
      : table_(table), path_(std::move(path)), problem_(problem) {}

  void only(std::initializer_list<std::string_view> allowed) {
    if (table_ == nullptr) return;
    for (const auto& [key, node] : *table_) {
      if (std::find(allowed.begin(), allowed.end(), key.str()) == allowed.end())
        report(fmt::format("{}.{} is an unknown key, allowed are {}", path_, key.str(),
                           fmt::join(allowed, ", ")));
    }
  }

  /// Two whole numbers; one stands for both.
  void pair(const char* key, bool is_needed, std::array<ComediChannel, 2>& channels,
            unsigned ComediChannel::*member) {
    const toml::node* node = find(key, is_needed);
    if (node == nullptr) return;
    const toml::array* array = node->as_array();
    if (array != nullptr && array->size() != 2) return refuse(key, "one or two whole numbers from 0 to 255");
    for (std::size_t i = 0; i < 2; ++i)
      whole(key, array == nullptr ? *node : *array->get(i), channels[i].*member);
  }

  void one(const char* key, bool is_needed, unsigned& target) {
    if (const toml::node* node = find(key, is_needed)) whole(key, *node, target);
  }

  /// Bits as the card's driver has them.
  void bits(const char* key, std::optional<unsigned>& target) {
    const toml::node* node = find(key, false);
    if (node == nullptr) return;
    const auto value = node->value_exact<std::int64_t>();
    if (!value || *value < 0 || *value > 0xffffffffLL)
      return refuse(key, "a whole number from 0 to 4294967295");
    target = static_cast<unsigned>(*value);
  }

  void factors(const char* key, std::array<double, 2>& target) {
    const toml::node* node = find(key, true);
    if (node == nullptr) return;
    const toml::array* array = node->as_array();
    for (std::size_t i = 0; i < 2; ++i) {
      const auto value = array != nullptr && array->size() == 2 ? (*array)[i].value<double>() : std::nullopt;
      if (!value || !(std::abs(*value) >= 1e-3 && std::abs(*value) <= 1e3))
        return refuse(key, "two numbers from 0.001 to 1000, or their negatives");
      target[i] = *value;
    }
  }

  void text(const char* key, std::string& target) {
    const toml::node* node = find(key, false);
    if (node == nullptr) return;
    if (!node->is_string()) return refuse(key, "a text");
    target = node->value<std::string>().value_or("");
  }

  void flag(const char* key, bool& target) {
    const toml::node* node = find(key, false);
    if (node == nullptr) return;
    if (!node->is_boolean()) return refuse(key, "true or false");
    target = node->value<bool>().value_or(target);
  }

  /// Ground, common, differential or other: where an analogue input's second wire is.
  void reference(const char* key, std::array<ComediChannel, 2>& channels) {
    constexpr std::array kNames{"ground", "common", "differential", "other"};
    std::string name = kNames[0];
    text(key, name);
    const auto found = std::find(kNames.begin(), kNames.end(), name);
    if (found == kNames.end()) return refuse(key, fmt::format("{}", fmt::join(kNames, ", ")));
    for (auto& channel : channels) channel.reference = static_cast<unsigned>(found - kNames.begin());
  }

  [[nodiscard]] Section section(const char* key, bool is_needed) {
    const toml::node* node = find(key, is_needed);
    if (node != nullptr && !node->is_table()) refuse(key, "a table");
    return {node == nullptr ? nullptr : node->as_table(), path_ + "." + key, problem_};
  }
  [[nodiscard]] bool is_there() const { return table_ != nullptr; }

 private:
  const toml::node* find(const char* key, bool is_needed) {
    if (table_ == nullptr) return nullptr;
    const toml::node* node = table_->get(key);
    if (node == nullptr && is_needed) report(fmt::format("{}.{} is missing", path_, key));
    return node;
  }
  void whole(const char* key, const toml::node& node, unsigned& target) {
    const auto value = node.value_exact<std::int64_t>();
    if (!value || *value < 0 || *value > kMostChannels) return refuse(key, "a whole number from 0 to 255");
    target = static_cast<unsigned>(*value);
  }
  void refuse(const char* key, const std::string& allowed) {
    report(fmt::format("{}.{} is not good, allowed is {}", path_, key, allowed));
  }
  void report(const std::string& what) {
    if (problem_.empty()) problem_ = what;
  }

  const toml::table* table_;
  const std::string path_;
  std::string& problem_;
};

/// One digital output.
void read_line(Section& comedi, const char* name, std::optional<ComediChannel>& line) {
  Section section = comedi.section(name, false);
  if (!section.is_there()) return;
  section.only({"subdevice", "channel"});
  line = ComediChannel{};
  section.one("subdevice", true, line->subdevice);
  section.one("channel", true, line->channel);
}

void read(Section comedi, ComediConfig& config) {
  comedi.only({"device", "encoders", "force", "motors", "emergency_stop", "enable", "heartbeat", "onset"});
  comedi.text("device", config.device);

  Section encoders = comedi.section("encoders", true);
  encoders.only({"subdevice", "channel", "counter_mode"});
  encoders.pair("subdevice", true, config.encoders, &ComediChannel::subdevice);
  encoders.pair("channel", true, config.encoders, &ComediChannel::channel);
  encoders.bits("counter_mode", config.counter_mode);

  Section force = comedi.section("force", true);
  force.only({"subdevice", "channel", "range", "reference"});
  force.pair("subdevice", true, config.force, &ComediChannel::subdevice);
  force.pair("channel", true, config.force, &ComediChannel::channel);
  force.pair("range", false, config.force, &ComediChannel::range);
  force.reference("reference", config.force);

  Section motors = comedi.section("motors", true);
  motors.only({"subdevice", "channel", "range", "torque_Nm_per_V"});
  motors.pair("subdevice", true, config.motors, &ComediChannel::subdevice);
  motors.pair("channel", true, config.motors, &ComediChannel::channel);
  motors.pair("range", false, config.motors, &ComediChannel::range);
  motors.factors("torque_Nm_per_V", config.torque_per_volt);

  read_line(comedi, "enable", config.enable);
  read_line(comedi, "heartbeat", config.heartbeat);
  read_line(comedi, "onset", config.onset);

  Section stop = comedi.section("emergency_stop", false);
  if (!stop.is_there()) return;
  stop.only({"subdevice", "channel", "is_pressed_when_high"});
  config.emergency_stop = ComediChannel{};
  stop.one("subdevice", true, config.emergency_stop->subdevice);
  stop.one("channel", true, config.emergency_stop->channel);
  stop.flag("is_pressed_when_high", config.is_pressed_when_high);
}

}  // namespace

Result<ComediConfig> parse_comedi_config(std::string_view text, const std::string& source) {
  TONUS_TRY(check_toml_depth(text, source));
  ComediConfig config;
  std::string problem;
  try {
    const toml::table root = toml::parse(text, source);
    const toml::table* table = root["comedi"].as_table();
    if (table == nullptr)
      return fail(ErrorCode::kInvalidArgument, source + ": the table [comedi] is missing");
    read(Section(table, "comedi", problem), config);
  } catch (const toml::parse_error& error) {
    problem = fmt::format("line {}, column {}: {}", error.source().begin.line, error.source().begin.column,
                          error.description());
  }
  if (!problem.empty()) return fail(ErrorCode::kInvalidArgument, source + ": " + problem);
  return config;
}

Result<ComediConfig> load_comedi_config(const std::filesystem::path& file) {
  auto text = read_text_file(file);
  if (!text) return text.error();
  return parse_comedi_config(*text, file.string());
}

}  // namespace tonus::drivers
