#include "analysis_service/service/command_line.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <iterator>

#include "services/core/name.hpp"

namespace tonus::identification {
namespace {

/// "all", or each name by itself.
template <typename Value, typename Parse>
Result<std::vector<Value>> chosen(const std::vector<std::string>& names, std::span<const Value> all,
                                  Parse parse) {
  std::vector<Value> values;
  for (const std::string& name : names) {
    if (name == "all") return std::vector<Value>(all.begin(), all.end());
    auto value = parse(name);
    if (!value) return value.error();
    if (std::find(values.begin(), values.end(), *value) == values.end()) values.push_back(*value);
  }
  return values;
}

}  // namespace

void CommandLine::add_to(CLI::App& app) {
  app.add_option("--method", methods_,
                 "methods of identification, auto (state_variable; spectral for continuous records), or all")
      ->capture_default_str();
  app.add_option("--model", models_, "models of the force, or all")->capture_default_str();
  app.add_option("--window", options_.window, "time from the onset that is fitted, s")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app.add_option("--cutoff", options_.cutoff, "cutoff of the low-pass method, Hz")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app.add_option("--natural-frequency", natural_frequency_,
                 "of the state-variable filter, Hz (default: tuned to each condition)")
      ->check(CLI::PositiveNumber);
  app.add_option("--damping-ratio", options_.damping_ratio, "of the state-variable filter")
      ->check(CLI::Range(1e-3, 1.0))
      ->capture_default_str();
  app.add_option("--force-sign", force_sign_,
                 "-1 where a one-axis rig's force channel is the reaction of the limb on the rig")
      ->check(CLI::IsMember({-1, 1}))
      ->capture_default_str();
  judge_.add_to(app);
}

Result<std::vector<impedance::Options>> CommandLine::analyses_by_method() const {
  std::vector<impedance::Options> analyses;
  for (const std::string& name : methods_) {
    if (name == "all") return impedance::by_every_method(options_);
    TONUS_TRY_ASSIGN(const auto options, impedance::with_method(options_, name));
    const bool is_new = std::none_of(analyses.begin(), analyses.end(), [&](const impedance::Options& other) {
      return other.method == options.method && other.record_method == options.record_method;
    });
    if (is_new) analyses.push_back(options);
  }
  return analyses;
}

Result<ServiceSettings> CommandLine::settings(const std::string& rig) const {
  const auto models = chosen<impedance::Model>(models_, impedance::kModels, impedance::model_named);
  if (!models) return models.error();

  ServiceSettings settings;
  settings.rig = rig_id(rig);
  settings.force_sign = force_sign_;
  settings.core.judge = judge_.choice();
  settings.core.book.analyses.clear();
  TONUS_TRY_ASSIGN(const auto by_method, analyses_by_method());
  for (impedance::Options options : by_method) {
    for (const auto model : *models) {
      if (by_method.size() > 1 && !impedance::has_model(options.method, model)) continue;
      options.model = model;
      options.natural_frequency = natural_frequency_;
      settings.core.book.analyses.push_back(options);
    }
  }
  settings.core.live = options_;
  settings.core.live.natural_frequency = natural_frequency_;
  settings.core.live.has_trace = false;
  return settings;
}

}  // namespace tonus::identification
