// Writes the dataset that identification is timed on.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <spdlog/fmt/fmt.h>

#include "services/recording/dataset.hpp"
#include "tests/support/simulated_study/simulated_study.hpp"

namespace tonus::simulated {
namespace {

Result<void> make_study(const std::string& folder, std::size_t subjects) {
  // Waits as published; centring and the way back take their usual time too.
  Procedure procedure;
  procedure.shortest_wait = 3.0;
  procedure.longest_wait = 5.0;
  procedure.centring_time = 1.0;
  std::vector<recording::Recording> records;
  for (std::size_t subject = 0; subject < subjects; ++subject) {
    simulation::Profile profile;
    profile.subject = cohort_subject(subject % kCohort);
    int run = 0;
    for (const Posture& posture : published_postures()) {
      profile.seed = 100 * (subject + 1) + static_cast<std::size_t>(++run);
      auto record = measure(profile, posture, procedure, 16 * (run - 1) + 1);
      if (!record) return record.error();
      record->participant.id = fmt::format("sub-{:02}", subject + 1);
      record->run = run;
      records.push_back(std::move(*record));
    }
    std::printf("\rmaking the study: subject %zu of %zu", subject + 1, subjects);
    std::fflush(stdout);
  }
  std::printf("\n");
  recording::WriteOptions options;
  options.name = "Simulated study";
  return recording::write_dataset(folder, records, options);
}

}  // namespace
}  // namespace tonus::simulated

int main(int argc, char** argv) {
  CLI::App app{"Writes a BIDS dataset of simulated subjects: five postures, 16 perturbations each, 200 Hz."};
  std::string folder;
  std::size_t subjects = tonus::simulated::kCohort;
  app.add_option("folder", folder, "folder to be made")->required();
  app.add_option("--subjects", subjects, "how many, up to 99")
      ->check(CLI::Range(1, 99))
      ->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  if (const auto made = tonus::simulated::make_study(folder, subjects); !made) {
    std::fprintf(stderr, "make_study: %s\n", made.error().message.c_str());
    return 1;
  }
  return 0;
}
