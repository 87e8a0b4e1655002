#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <memory>

#include "analysis_service/report/report.hpp"
#include "services/cli/answer.hpp"
#include "services/cli/archive_option.hpp"
#include "services/cli/commands.hpp"
#include "services/cli/progress_bar.hpp"
#include "services/cli/standard_input.hpp"
#include "services/runtime/options.hpp"
#include "services/simulation/cohort.hpp"

namespace tonus::cli {
namespace {

struct ReportOptions {
  ArchiveOption archive;
  std::string cohort;
  std::string folder = "report";
  bool is_json = false;
};

Result<void> report(const ReportOptions& options) {
  const auto cohort = simulation::load_cohort(options.cohort);
  if (!cohort) return cohort.error();
  const auto store = open_to_read(options.archive);
  if (!store) return store.error();
  Result<study::Study> made = fail(ErrorCode::kInternal, "nothing was read");
  {
    ProgressBar progress("subjects");
    made = study::read_study(
        **store, *cohort, [&](std::size_t done, std::size_t all) { progress.show(done, all, "identified"); });
  }
  if (!made) return made.error();
  auto written = report::write_report(*made, options.folder, [](const std::string& what) {
    std::fprintf(stderr, "writing %s\n", what.c_str());
  });
  if (!written) return written;
  const std::string page = options.folder + "/index.html";
  print_answer(options.is_json, {{"report", page}}, "report: " + page + "\n");
  return {};
}

}  // namespace

void add_report_command(CLI::App& app, Command& chosen) {
  auto* command = app.add_subcommand(
      "report", "Makes the tables and figures of a study from its archive: HTML, SVG, PDF and CSV.");
  auto options = std::make_shared<ReportOptions>();
  add_archive_option(*command, options->archive);
  command
      ->add_option("--cohort", options->cohort,
                   "TOML file of the subjects: their link lengths and, of simulated ones, the truth; - is "
                   "standard input")
      ->required();
  command->add_option("--out", options->folder, "folder for the report")->capture_default_str();
  add_json_flag(*command, options->is_json);
  command->callback([options, &chosen] {
    chosen = [options] {
      runtime::start_log("tonus report", "info");
      const auto input = StandardInput::take(options->cohort, "a cohort");
      if (!input) return runtime::report("tonus report", input.error());
      const auto outcome = report(*options);
      return outcome ? 0 : runtime::report("tonus report", input->told(outcome.error()));
    };
  });
}

}  // namespace tonus::cli
