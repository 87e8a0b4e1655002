#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <memory>

#include "analysis_service/report/report.hpp"
#include "services/cli/archive_option.hpp"
#include "services/cli/commands.hpp"
#include "services/cli/progress_bar.hpp"
#include "services/runtime/options.hpp"
#include "services/simulation/cohort.hpp"

namespace tonus::cli {
namespace {

struct ReportOptions {
  ArchiveOption archive;
  std::string cohort;
  std::string folder = "report";
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
  std::printf("report: %s/index.html\n", options.folder.c_str());
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
                   "TOML file of the subjects: their link lengths and, of simulated ones, the truth")
      ->required();
  command->add_option("--out", options->folder, "folder for the report")->capture_default_str();
  command->callback([options, &chosen] {
    chosen = [options] {
      runtime::start_log("tonus report", "info");
      const auto outcome = report(*options);
      return outcome ? 0 : runtime::report("tonus report", outcome.error());
    };
  });
}

}  // namespace tonus::cli
