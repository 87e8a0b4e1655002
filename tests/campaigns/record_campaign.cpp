#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <string>
#include <vector>

#include "analysis_service/impedance/identification.hpp"
#include "analysis_service/spectral/record.hpp"
#include "analysis_service/statistics/distributions.hpp"
#include "services/core/parallel.hpp"
#include "tests/campaigns/record_kinds.hpp"

// Draws continuous records of many kinds with known truth, identifies each, and counts what came out: right,
// refused, or wrong and called ok. Wrong: an element of M, B or K outside the 99.9 % interval that follows
// from the stated one.

namespace tonus::campaigns {
namespace {

enum class Judged { kRight, kRefused, kWrongAndOk };

struct Outcome {
  Judged judged = Judged::kRefused;
  double worst = 0.0;  // error over the 95 % half-width
  double error = 0.0;  // relative to the largest element, of that matrix
  char matrix = '-';   // the one with the worst error
  double width = 0.0;  // relative half-width
  double explained = 0.0;
  std::string why;
};

/// As a service prepares them.
std::vector<impedance::Trial> trials_of(const std::vector<spectral::Record>& records) {
  std::vector<impedance::Trial> trials;
  for (const spectral::Record& record : records) {
    const spectral::Record whole = spectral::filled(record);
    impedance::Trial trial;
    trial.number = static_cast<std::uint32_t>(trials.size() + 1);
    trial.sample_period = record.sample_period;
    trial.displacement = whole.displacement;
    trial.force = whole.force;
    trial.is_missing = record.is_missing;
    trial.is_continuous = true;
    trials.push_back(std::move(trial));
  }
  return trials;
}

Outcome judged(const DrawnRecords& drawn, impedance::Model model) {
  impedance::Options options;
  options.model = model;
  options.has_trace = false;
  const auto identified = impedance::identify(trials_of(drawn.records), options);
  Outcome outcome;
  if (!identified) {
    outcome.why = identified.error().message;
    return outcome;
  }
  const impedance::Estimate& found = *identified;
  for (const impedance::Reason reason : found.reasons)
    outcome.why += (outcome.why.empty() ? "" : " ") + std::string(name_of(reason));
  if (found.status == impedance::Status::kUndetermined) return outcome;
  outcome.explained = found.explained.minCoeff();
  const double freedom = static_cast<double>(found.units) - 1.0;
  const double allowed =
      statistics::student_t_quantile(0.9995, freedom) / statistics::student_t_quantile(0.975, freedom);
  const auto compare = [&](char name, impedance::AxisMatrix impedance::Parameters::*matrix,
                           const Eigen::MatrixXd& truth) {
    const Eigen::MatrixXd value = found.value.*matrix;
    const Eigen::MatrixXd half = 0.5 * (found.high.*matrix - found.low.*matrix);
    const double worst = ((value - truth).array().abs() / half.array().max(1e-300)).maxCoeff();
    if (worst > outcome.worst) {
      outcome.worst = worst;
      outcome.matrix = name;
      outcome.error = (value - truth).cwiseAbs().maxCoeff() / truth.cwiseAbs().maxCoeff();
    }
    outcome.width = std::max(outcome.width, half.maxCoeff() / std::max(value.cwiseAbs().maxCoeff(), 1e-300));
  };
  compare('M', &impedance::Parameters::M, drawn.M);
  compare('B', &impedance::Parameters::B, drawn.B);
  compare('K', &impedance::Parameters::K, drawn.K);
  if (found.status == impedance::Status::kOk)
    outcome.judged = outcome.worst <= allowed ? Judged::kRight : Judged::kWrongAndOk;
  return outcome;
}

int run(int seeds, std::uint64_t first_seed, const std::vector<std::string>& names, impedance::Model model,
        bool is_verbose) {
  std::printf("%-22s %6s %8s %13s  %s\n", "kind", "right", "refused", "wrong and ok", "refused for");
  int right_described = 0;
  int described = 0;
  int wrong = 0;
  int all = 0;
  for (const RecordKind& kind : record_kinds()) {
    if (!names.empty() && std::ranges::find(names, kind.name) == names.end()) continue;
    std::vector<Outcome> outcomes(static_cast<std::size_t>(seeds));
    for_each_in_parallel(outcomes.size(),
                         [&](std::size_t i) { outcomes[i] = judged(draw(kind, first_seed + i), model); });
    std::map<Judged, int> counts;
    std::map<std::string, int> reasons;
    for (std::size_t i = 0; i < outcomes.size(); ++i) {
      const Outcome& outcome = outcomes[i];
      ++counts[outcome.judged];
      if (outcome.judged == Judged::kRefused) ++reasons[outcome.why];
      if (is_verbose)
        std::printf(
            "  seed %llu: %s, %c off by %.3f %%, %.2f half-widths, width %.3f, explained %.3f "
            "%s\n",
            static_cast<unsigned long long>(first_seed + i),
            outcome.judged == Judged::kRight     ? "right"
            : outcome.judged == Judged::kRefused ? "refused"
                                                 : "WRONG AND OK",
            outcome.matrix, 100.0 * outcome.error, outcome.worst, outcome.width, outcome.explained,
            outcome.why.c_str());
    }
    std::string why;
    for (const auto& [reason, count] : reasons)
      why += (why.empty() ? "" : "; ") + reason + " " + std::to_string(count);
    std::printf("%-22s %6d %8d %13d  %s\n", kind.name.c_str(), counts[Judged::kRight],
                counts[Judged::kRefused], counts[Judged::kWrongAndOk], why.c_str());
    std::fflush(stdout);
    all += seeds;
    wrong += counts[Judged::kWrongAndOk];
    if (kind.is_described) {
      described += seeds;
      right_described += counts[Judged::kRight];
    }
  }
  const double wrong_share = 100.0 * wrong / std::max(all, 1);
  const double right_share = 100.0 * right_described / std::max(described, 1);
  std::printf("%d records: wrong and ok %.2f %% (at most 1 %%)", all, wrong_share);
  if (described > 0)
    std::printf("; of %d that the model describes, right %.1f %% (at least 95 %%)", described, right_share);
  std::printf("\n");
  return wrong_share <= 1.0 && (described == 0 || right_share >= 95.0) ? 0 : 1;
}

}  // namespace
}  // namespace tonus::campaigns

int main(int argc, char** argv) {
  CLI::App app{
      "Draws continuous records of known truth and counts estimates that are right, refused, or wrong and "
      "ok."};
  int seeds = 50;
  std::uint64_t seed = 1;
  std::vector<std::string> kinds;
  bool is_verbose = false;
  app.add_option("--seeds", seeds, "records of each kind")->check(CLI::PositiveNumber)->capture_default_str();
  app.add_option("--seed", seed, "of the first")->capture_default_str();
  app.add_option("--kind", kinds, "only these kinds");
  std::string model = "linear";
  std::vector<std::string> names;
  for (const auto each : tonus::impedance::kRecordModels) names.emplace_back(name_of(each));
  app.add_option("--model", model, "that the records are identified by")
      ->check(CLI::IsMember(names))
      ->capture_default_str();
  app.add_flag("--each", is_verbose, "a line for each record");
  CLI11_PARSE(app, argc, argv);
  return tonus::campaigns::run(seeds, seed, kinds, *tonus::impedance::model_named(model), is_verbose);
}
