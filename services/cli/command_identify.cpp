#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <spdlog/fmt/fmt.h>

#include "analysis_service/identification/offline.hpp"
#include "services/cli/commands.hpp"
#include "services/cli/results.hpp"
#include "services/core/text_file.hpp"
#include "services/recording/dataset.hpp"
#include "services/runtime/options.hpp"

namespace tonus::cli {
namespace {

struct IdentifyOptions {
  std::string dataset;
  std::string method = "state_variable";
  std::string model = "linear";
  impedance::Options settings;
  int force_sign = 0;
  std::string json;
};

/// Every combination of the methods and models asked for.
Result<std::vector<impedance::Options>> analyses_of(const IdentifyOptions& options) {
  std::vector<impedance::Method> methods(std::begin(impedance::kMethods), std::end(impedance::kMethods));
  if (options.method != "all") {
    auto method = impedance::method_named(options.method);
    if (!method) return fail(method.error().code, "--method: " + method.error().message);
    methods = {*method};
  }
  std::vector<impedance::Model> models(std::begin(impedance::kModels), std::end(impedance::kModels));
  if (options.model != "all") {
    auto model = impedance::model_named(options.model);
    if (!model) return fail(model.error().code, "--model: " + model.error().message);
    models = {*model};
  }
  std::vector<impedance::Options> analyses;
  for (const auto method : methods) {
    for (const auto model : models) {
      analyses.push_back(options.settings);
      analyses.back().method = method;
      analyses.back().model = model;
    }
  }
  return analyses;
}

Result<void> identify(const IdentifyOptions& options) {
  auto analyses = analyses_of(options);
  if (!analyses) return analyses.error();
  auto recordings = recording::read_dataset(options.dataset);
  if (!recordings) return recordings.error();
  for (auto& record : *recordings) {
    if (auto valid = impedance::validate(options.settings, 1.0 / record.sampling_frequency); !valid)
      return valid;
    if (options.force_sign == 0) continue;
    if (auto stated = recording::state_force_sign(record, options.force_sign); !stated) return stated;
  }
  auto estimates = identification::identify_recordings(*recordings, *analyses);
  if (!estimates) return estimates.error();

  std::vector<ConditionResult> results;
  for (auto& estimate : *estimates) {
    ConditionResult result{
        estimate.participant, estimate.session, estimate.run, {}, std::move(estimate.estimate)};
    for (auto& trial : estimate.left_out) result.rejected.push_back({trial.trial, std::move(trial.reason)});
    results.push_back(std::move(result));
  }
  for (const auto& result : results) {
    std::printf("%s%s%s run %d, %s", result.participant.c_str(), result.session.empty() ? "" : " ",
                result.session.c_str(), result.run, as_text(result.estimate, {}).c_str());
    for (const auto& trial : result.rejected) {
      std::printf("  trial %lld left out: %s\n", static_cast<long long>(trial.trial), trial.reason.c_str());
    }
    std::printf("\n");
  }
  if (options.json.empty()) return {};
  return write_text_file(options.json, as_json(results).dump(1) + "\n");
}

}  // namespace

void add_identify_command(CLI::App& app, Command& chosen) {
  auto* command = app.add_subcommand("identify", "Identifies a BIDS Motion dataset, without any service.");
  auto options = std::make_shared<IdentifyOptions>();
  command->add_option("dataset", options->dataset, "folder of the dataset")
      ->required()
      ->check(CLI::ExistingDirectory);
  command->add_option("--method", options->method, "lowpass, optimal, state_variable or all")
      ->capture_default_str();
  command
      ->add_option("--model", options->model,
                   "linear, no_damping, coriolis, squared_velocity, signed_squared_velocity or all")
      ->capture_default_str();
  command->add_option("--window", options->settings.window, "s from the onset that are fitted")
      ->capture_default_str();
  command->add_option("--cutoff", options->settings.cutoff, "of the low-pass filter, Hz")
      ->capture_default_str();
  command->add_option("--natural-frequency", options->settings.natural_frequency,
                      "of the state-variable filter, Hz; default: from the data");
  command->add_option("--damping-ratio", options->settings.damping_ratio, "of the state-variable filter")
      ->capture_default_str();
  command
      ->add_option("--force-sign", options->force_sign,
                   "+1 or -1: of a one-axis dataset that does not state it")
      ->check(CLI::IsMember({-1, 1}));
  command->add_option("--json", options->json, "file for the results");
  command->callback([options, &chosen] {
    chosen = [options] {
      const auto outcome = identify(*options);
      return outcome ? 0 : runtime::report("tonus identify", outcome.error());
    };
  });
}

}  // namespace tonus::cli
