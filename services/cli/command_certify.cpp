#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <spdlog/fmt/fmt.h>

#include "analysis_service/certify/certification.hpp"
#include "analysis_service/study/session_analysis.hpp"
#include "services/cli/answer.hpp"
#include "services/cli/archive_option.hpp"
#include "services/cli/commands.hpp"
#include "services/cli/progress_bar.hpp"
#include "services/runtime/options.hpp"
#include "services/store/session_reader.hpp"

namespace tonus::cli {
namespace {

constexpr const char* kMatrices[] = {"M", "B", "K", "X0"};

struct CertifyOptions {
  std::uint64_t seed = 1;
  std::size_t conditions = 300;
  std::vector<int> trials{16};
  std::vector<std::string> settings{"white", "encoder", "living"};
  double rise = 0.2;
  double amplitude_mm = 5.0;
  bool has_errors = false;
  std::string like;
  ArchiveOption archive;
  std::string json;
};

Result<certify::Setting> setting_named(const std::string& name) {
  std::string allowed;
  for (const certify::Setting& setting : certify::settings()) {
    if (setting.name == name) return setting;
    allowed += (allowed.empty() ? "" : ", ") + setting.name;
  }
  return fail(ErrorCode::kInvalidArgument,
              fmt::format("--setting: '{}' is not allowed; expected {}", name, allowed));
}

/// Coverage of the ellipses' numbers, a line a matrix.
void print_ellipses(const certify::MethodWorth& worth) {
  for (std::size_t i = 0; i < worth.ellipses.size(); ++i) {
    std::string line = fmt::format("  {:<15}{:<4}ellipse, coverage:", "", kMatrices[i]);
    for (std::size_t number = 0; number < certify::kEllipseNumbers.size(); ++number) {
      const certify::EllipseWorth& of = worth.ellipses[i][number];
      line += fmt::format(" {} {:.1f} ± {:.1f} %", certify::kEllipseNumbers[number], 100.0 * of.coverage,
                          100.0 * of.coverage_error);
      if (of.determined < 1.0) line += fmt::format(" of {:.1f} % determined", 100.0 * of.determined);
      line += number + 1 < certify::kEllipseNumbers.size() ? "," : "\n";
    }
    std::fputs(line.c_str(), stdout);
  }
}

std::string text_of(const certify::Cell& cell) {
  return fmt::format("{} sensors, {} trials, rise {:.3g} s, {:.3g} mm, {} conditions, seed {}",
                     cell.setting.name, cell.design.trials, cell.design.rise, 1e3 * cell.design.amplitude,
                     cell.conditions, cell.seed);
}

void print(const std::string& heading, const std::vector<certify::MethodWorth>& worths) {
  std::printf("%s\n", heading.c_str());
  std::printf("  %-15s%-4s%18s%12s%18s%18s%14s\n", "method", "", "largest bias", "RMSE",
              "  RMSE/bound (worst)", "coverage", "half-width");
  for (const certify::MethodWorth& worth : worths) {
    for (std::size_t i = 0; i < 4; ++i) {
      const certify::MatrixWorth& m = worth.matrices[i];
      const bool is_centre = i == 3;
      const double unit = is_centre ? 1e3 : 100.0;
      const std::string ratio = is_centre || !(m.over_bound > 0.0)
                                    ? ""
                                    : fmt::format("{:.2f} ({:.2f})", m.over_bound, m.worst_over_bound);
      std::printf("  %-15s%-4s%+9.3g ± %-6.2g%10.3g %s%18s%9.1f ± %-4.1f %%%10.3g %s\n",
                  i == 0 ? std::string(impedance::name_of(worth.method)).c_str() : "", kMatrices[i],
                  unit * m.bias, unit * m.bias_error, unit * m.rmse, is_centre ? "mm" : "% ", ratio.c_str(),
                  100.0 * m.coverage, 100.0 * m.coverage_error, unit * m.half_width, is_centre ? "mm" : "%");
    }
    print_ellipses(worth);
    std::printf("  %-15ssuspect %zu, undetermined %zu of %zu\n", "", worth.suspect, worth.undetermined,
                worth.conditions);
  }
  std::printf("\n");
  std::fflush(stdout);
}

void print_errors_head(const certify::Cell& cell) {
  std::printf(
      "%s sensors, %d trials, rise %.3g s, %.3g mm, %zu conditions, seed %llu: right (of these by the slow "
      "impedance alone), refused, wrong and ok; elements wrong and ok, %%\n",
      cell.setting.name.c_str(), cell.design.trials, cell.design.rise, 1e3 * cell.design.amplitude,
      cell.conditions, static_cast<unsigned long long>(cell.seed));
  std::printf("  %-16s%-16s%7s%7s%9s%7s%9s%8s%8s%14s\n", "arm", "method", "right", "(slow)", "refused",
              "wrong", "M", "B", "K", "K to 5 mm");
}

void print_errors(const std::string& name, const std::vector<certify::MethodWorth>& worths) {
  for (const certify::MethodWorth& worth : worths) {
    std::printf(
        "  %-16s%-16s%7zu%7zu%9zu%7zu%9.1f%8.1f%8.1f%14.1f\n", &worth == &worths.front() ? name.c_str() : "",
        std::string(impedance::name_of(worth.method)).c_str(), worth.right, worth.right_slow, worth.refused,
        worth.wrong, 100.0 * worth.matrices[0].wrong_and_ok, 100.0 * worth.matrices[1].wrong_and_ok,
        100.0 * worth.matrices[2].wrong_and_ok, 100.0 * worth.wrong_and_ok_secant);
  }
  std::fflush(stdout);
}

nlohmann::json ellipse_json(const std::array<certify::EllipseWorth, 4>& worth) {
  nlohmann::json all = nlohmann::json::object();
  for (std::size_t number = 0; number < worth.size(); ++number)
    all[certify::kEllipseNumbers[number]] = {{"coverage", worth[number].coverage},
                                             {"coverage_error", worth[number].coverage_error},
                                             {"determined", worth[number].determined}};
  return all;
}

nlohmann::json as_json(const std::vector<certify::MethodWorth>& worths) {
  nlohmann::json methods = nlohmann::json::array();
  for (const certify::MethodWorth& worth : worths) {
    nlohmann::json one = {{"method", impedance::name_of(worth.method)},
                          {"suspect", worth.suspect},
                          {"undetermined", worth.undetermined},
                          {"right", worth.right},
                          {"right_by_slow_impedance", worth.right_slow},
                          {"refused", worth.refused},
                          {"wrong_and_ok", worth.wrong},
                          {"wrong_and_ok_secant", worth.wrong_and_ok_secant}};
    for (std::size_t i = 0; i < 4; ++i) {
      const certify::MatrixWorth& m = worth.matrices[i];
      const bool is_centre = i == 3;
      const std::string unit = is_centre ? "_m" : "_share";
      one[kMatrices[i]] = {{"bias" + unit, m.bias},         {"bias_error" + unit, m.bias_error},
                           {"rmse" + unit, m.rmse},         {"half_width" + unit, m.half_width},
                           {"coverage", m.coverage},        {"coverage_error", m.coverage_error},
                           {"wrong_and_ok", m.wrong_and_ok}};
      if (is_centre) continue;
      one[kMatrices[i]]["ellipse"] = ellipse_json(worth.ellipses[i]);
      one[kMatrices[i]]["rmse_over_bound"] = m.over_bound;
      one[kMatrices[i]]["worst_rmse_over_bound"] = m.worst_over_bound;
    }
    methods.push_back(one);
  }
  return methods;
}

nlohmann::json as_json(const certify::Cell& cell, const std::vector<certify::MethodWorth>& worths) {
  return {{"setting", cell.setting.name},  {"trials", cell.design.trials},
          {"rise_s", cell.design.rise},    {"amplitude_m", cell.design.amplitude},
          {"conditions", cell.conditions}, {"seed", cell.seed},
          {"methods", as_json(worths)}};
}

std::vector<certify::MethodWorth> certified(const certify::Cell& cell, const std::string& what) {
  ProgressBar progress(what);
  auto worths = certify::certify(
      cell, [&](std::uint64_t done, std::uint64_t all) { progress.show(done, all, "conditions"); });
  progress.clear();
  return worths;
}

void certify_errors(certify::Cell cell, nlohmann::json& cells) {
  print_errors_head(cell);
  for (const certify::NamedError& one : certify::model_errors()) {
    cell.setting.error = one.error;
    const auto worths = certified(cell, fmt::format("{}, {}", cell.setting.name, one.name));
    print_errors(one.name, worths);
    cells.push_back(as_json(cell, worths));
    cells.back()["arm"] = one.name;
  }
  std::printf("\n");
}

/// What the conditions of an archived session are worth, each around its own estimate, rig and residuals.
Result<void> certify_session(const CertifyOptions& options, const ResultsFile& file) {
  TONUS_TRY_ASSIGN(const auto store, open_to_read(options.archive));
  TONUS_TRY_ASSIGN(const auto session, store::read_found_session(*store, options.like));
  const std::string id = to_hex(session.record.session);
  TONUS_TRY_ASSIGN(const auto conditions, study::condition_trials(*store, session));
  nlohmann::json cells = nlohmann::json::array();
  for (const auto& [condition, trials] : conditions) {
    ProgressBar progress(condition.posture);
    const auto worths = certify::certify_like(
        trials, {options.conditions, options.seed, 1.0},
        [&](std::uint64_t done, std::uint64_t all) { progress.show(done, all, "conditions"); });
    progress.clear();
    if (!worths)
      return fail(worths.error().code,
                  fmt::format("session {}, {}: {}", id, condition.posture, worths.error().message));
    print(fmt::format("like {} of session {}, {} trials, {} conditions, seed {}", condition.posture, id,
                      trials.size(), options.conditions, options.seed),
          *worths);
    cells.push_back({{"session", id},
                     {"posture", condition.posture},
                     {"set", condition.set},
                     {"trials", trials.size()},
                     {"conditions", options.conditions},
                     {"seed", options.seed},
                     {"methods", as_json(*worths)}});
  }
  if (cells.empty()) return fail(ErrorCode::kNotFound, fmt::format("session {}: has no valid trials", id));
  return file.write(cells.dump(1) + "\n");
}

Result<void> certify_all(const CertifyOptions& options, const ResultsFile& file) {
  nlohmann::json cells = nlohmann::json::array();
  for (const std::string& name : options.settings) {
    TONUS_TRY_ASSIGN(const auto setting, setting_named(name));
    for (const int trials : options.trials) {
      certify::Cell cell;
      cell.setting = setting;
      cell.design.trials = trials;
      cell.design.rise = options.rise;
      cell.design.amplitude = 1e-3 * options.amplitude_mm;
      cell.conditions = options.conditions;
      cell.seed = options.seed;
      if (options.has_errors) {
        certify_errors(cell, cells);
        continue;
      }
      const auto worths = certified(cell, fmt::format("{}, {} trials", name, trials));
      print(text_of(cell), worths);
      cells.push_back(as_json(cell, worths));
    }
  }
  return file.write(cells.dump(1) + "\n");
}

}  // namespace

void add_certify_command(CLI::App& app, Command& chosen) {
  auto* command = app.add_subcommand("certify",
                                     "Simulates conditions of known subjects and prints each method's bias, "
                                     "error over the Cramer-Rao bound, and "
                                     "the share of true values in its intervals.");
  auto options = std::make_shared<CertifyOptions>();
  command->add_option("--seed", options->seed, "of subjects, rigs and noise")->capture_default_str();
  command->add_option("--conditions", options->conditions, "a cell, spread over five postures")
      ->check(CLI::Range(2, 1'000'000))
      ->capture_default_str();
  command->add_option("--trials", options->trials, "perturbations a condition; several: a cell each")
      ->delimiter(',')
      ->check(CLI::Range(8, 1024))
      ->capture_default_str();
  command->add_option("--setting", options->settings, "white, encoder, living; several: a cell each")
      ->delimiter(',')
      ->capture_default_str();
  command->add_option("--rise", options->rise, "time of the command's ramp, s")
      ->check(CLI::Range(0.005, 0.9))
      ->capture_default_str();
  command->add_option("--amplitude", options->amplitude_mm, "of the perturbation, mm")
      ->check(CLI::Range(0.1, 50.0))
      ->capture_default_str();
  command->add_flag(
      "--model-errors", options->has_errors,
      "arms with a reflex, slack in the grip, hardening: what is flagged, what is wrong and ok");
  auto* like =
      command->add_option("--like", options->like,
                          "an archived session, by its id or the beginning of it: conditions like its "
                          "own, instead of drawn subjects");
  like->excludes("--trials")->excludes("--setting")->excludes("--rise")->excludes("--amplitude");
  like->excludes("--model-errors");
  add_archive_option(*command, options->archive);
  command->add_option("--json", options->json,
                      "file for the results; -: standard output, and nothing else there");
  command->callback([options, &chosen] {
    chosen = [options] {
      const auto file = ResultsFile::create(options->json);
      if (!file) return runtime::report("tonus certify", file.error());
      const auto outcome =
          options->like.empty() ? certify_all(*options, *file) : certify_session(*options, *file);
      return outcome ? 0 : runtime::report("tonus certify", outcome.error());
    };
  });
}

}  // namespace tonus::cli
