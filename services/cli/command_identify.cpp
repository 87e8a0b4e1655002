#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <spdlog/fmt/fmt.h>

#include "analysis_service/offline/offline.hpp"
#include "analysis_service/offline/prior.hpp"
#include "analysis_service/offline/request.hpp"
#include "analysis_service/offline/results_json.hpp"
#include "analysis_service/service/judge_options.hpp"
#include "services/cli/answer.hpp"
#include "services/cli/commands.hpp"
#include "services/cli/results.hpp"
#include "services/cli/standard_input.hpp"
#include "services/core/folder.hpp"
#include "services/core/json_text.hpp"
#include "services/core/places.hpp"
#include "services/core/text.hpp"
#include "services/recording/dataset.hpp"
#include "services/runtime/options.hpp"
#include "services/store/open_store.hpp"

namespace tonus::cli {
namespace {

struct IdentifyOptions {
  std::string source;   ///< Dataset or archive.
  std::string session;  ///< Of an archive; empty: the one that began last.
  identification::Request request;
  int force_sign = 0;
  identification::JudgeOptions judge;
  std::string json;
  identification::PriorChoice prior;
};

using identification::DatasetEstimates;
using Estimates = Result<DatasetEstimates>;

Estimates identify_dataset(const IdentifyOptions& options, const std::vector<impedance::Options>& analyses) {
  if (!options.session.empty()) {
    return fail(ErrorCode::kInvalidArgument, fmt::format("--session {}: is for archives, '{}' is a dataset",
                                                         options.session, options.source));
  }
  const auto dataset = recording::Dataset::open(options.source, recording::Imperfect::kLeftOut);
  if (!dataset) return dataset.error();
  const auto sign = options.force_sign == 0 ? std::nullopt : std::optional<int>(options.force_sign);
  return identification::identify_dataset(*dataset, analyses, sign, options.judge.choice());
}

Estimates identify_archive(const std::string& name, const IdentifyOptions& options,
                           const std::vector<impedance::Options>& analyses) {
  if (options.force_sign != 0) {
    return fail(ErrorCode::kInvalidArgument,
                fmt::format("--force-sign {:+d}: is for datasets, '{}' is an archive", options.force_sign,
                            options.source));
  }
  auto store = store::open_store_for_reading(name);
  if (!store) return store.error();
  TONUS_TRY_ASSIGN(auto found, identification::identify_archived(**store, options.session, analyses,
                                                                 options.judge.choice()));
  return DatasetEstimates{std::move(found), {}};
}

/// A file or a URL is an archive; a folder is a dataset, or the data folder of a system with its archive in
/// it.
Estimates identify_source(const IdentifyOptions& options, const std::vector<impedance::Options>& analyses) {
  const std::filesystem::path source = options.source;
  std::error_code none;  // what cannot be reached is refused below, by name
  if (is_url(options.source) || std::filesystem::is_regular_file(source, none))
    return identify_archive(options.source, options, analyses);
  const auto in_folder = store::default_store(source);
  TONUS_TRY_ASSIGN(const bool is_dataset, is_present(source / "dataset_description.json"));
  TONUS_TRY_ASSIGN(const bool has_archive, is_present(in_folder));
  if (!is_dataset && has_archive) return identify_archive(in_folder.string(), options, analyses);
  return identify_dataset(options, analyses);
}

void print(const identification::OfflineEstimate& result, bool with_tracking_system) {
  std::printf("%s%s%s run %d%s, %s", result.participant.c_str(), result.session.empty() ? "" : " ",
              result.session.c_str(), result.run,
              with_tracking_system ? (" tracksys " + result.tracking_system).c_str() : "",
              as_text(result.estimate, {}).c_str());
  if (result.estimate.settled_s() >= 0.0) std::printf("  settled in %.3g s\n", result.estimate.settled_s());
  for (const auto& trial : result.left_out) {
    std::printf("  trial %lld left out: %s\n", static_cast<long long>(trial.trial), trial.reason.c_str());
  }
  std::printf("\n");
}

Result<void> identify(const IdentifyOptions& options) {
  const auto analyses = identification::analyses_of(options.request);
  if (!analyses) return fail(analyses.error().code, "--" + analyses.error().message);
  TONUS_TRY_ASSIGN(const auto file, ResultsFile::create(options.json));
  auto estimates = identify_source(options, *analyses);
  if (!estimates) return estimates.error();
  if (!options.prior.results.empty()) {
    TONUS_TRY_ASSIGN(estimates->estimates,
                     identification::with_prior(std::move(estimates->estimates), options.prior));
  }
  std::set<std::string> tracking_systems;
  for (const auto& estimate : estimates->estimates) tracking_systems.insert(estimate.tracking_system);
  for (const auto& estimate : estimates->estimates) print(estimate, tracking_systems.size() > 1);
  for (const auto& item : estimates->left_out)
    std::fprintf(stderr, "tonus identify: left out: %s\n", shown(item).c_str());
  if (options.json.empty()) return {};
  return file.write(json_text(identification::json_of(*estimates)) + "\n");
}

}  // namespace

void add_identify_command(CLI::App& app, Command& chosen) {
  auto* command = app.add_subcommand(
      "identify", "Identifies a BIDS Motion dataset or an archived session, without any service.");
  auto options = std::make_shared<IdentifyOptions>();
  command
      ->add_option("dataset", options->source,
                   "folder of a dataset; or an archive, or the data folder it is in")
      ->required();
  command->add_option("--session", options->session,
                      "of an archive: the session's id or its beginning; default: the one that began last");
  command
      ->add_option("--method", options->request.method,
                   "lowpass, optimal, state_variable, refined, spectral or all; auto: state_variable for "
                   "perturbations, spectral for continuous records")
      ->capture_default_str();
  command
      ->add_option("--model", options->request.model,
                   "linear, no_damping, coriolis, squared_velocity, signed_squared_velocity or all; of "
                   "continuous records linear, friction, cubic, reflex or auto, the simplest that passes")
      ->capture_default_str();
  command->add_option("--window", options->request.settings.window, "s from the onset that are fitted")
      ->capture_default_str();
  command->add_option("--cutoff", options->request.settings.cutoff, "of the low-pass filter, Hz")
      ->capture_default_str();
  command->add_option("--natural-frequency", options->request.settings.natural_frequency,
                      "of the state-variable filter, Hz; default: from the data");
  command
      ->add_option("--damping-ratio", options->request.settings.damping_ratio, "of the state-variable filter")
      ->capture_default_str();
  command
      ->add_option("--force-sign", options->force_sign,
                   "+1 or -1: of a one-axis dataset that does not state it")
      ->check(CLI::IsMember({-1, 1}));
  options->judge.add_to(*command);
  command->add_option("--prior", options->prior.results,
                      "results of an earlier session or of a cohort (a file of --json): each estimate is "
                      "followed by one that is combined with them; - is standard input");
  command
      ->add_option("--prior-change", options->prior.change,
                   "how much the subject may have changed since, one standard deviation as a share of the "
                   "largest element; a cohort states its own scatter")
      ->check(CLI::Range(0.0, 10.0))
      ->capture_default_str();
  command->add_option("--json", options->json,
                      "file for the results; -: standard output, and nothing else there");
  command->callback([options, &chosen] {
    chosen = [options] {
      std::string prior = options->prior.results.string();
      const auto input = StandardInput::take(prior, "results of --json");
      if (!input) return runtime::report("tonus identify", input.error());
      options->prior.results = prior;
      const auto outcome = identify(*options);
      return outcome ? 0 : runtime::report("tonus identify", input->told(outcome.error()));
    };
  });
}

}  // namespace tonus::cli
