#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <string>
#include <vector>

#include "analysis_service/spectral/identification.hpp"
#include "analysis_service/spectral/statistics.hpp"
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
  double width = 0.0;  // relative half-width
  double explained = 0.0;
  double coherence = 0.0;
  std::string why;
};

const char* name_of(spectral::Test test) {
  constexpr const char* kNames[] = {"explained", "coherence",  "halves",    "bands",    "lag",
                                    "units",     "friction",   "hardening", "position", "clipping",
                                    "held",      "steadiness", "width"};
  return kNames[static_cast<std::size_t>(test)];
}

Outcome judged(const DrawnRecords& drawn) {
  const spectral::Estimate found = spectral::identify(drawn.records);
  Outcome outcome;
  if (found.outcome == spectral::Outcome::kNone) {
    outcome.why = "shortage " + std::to_string(static_cast<int>(found.shortage));
    return outcome;
  }
  outcome.explained = found.explained;
  outcome.coherence = found.coherence;
  const double freedom = found.blocks - 1.0;
  const double allowed =
      spectral::student_t_quantile(0.9995, freedom) / spectral::student_t_quantile(0.975, freedom);
  const auto compare = [&](const Eigen::MatrixXd& value, const Eigen::MatrixXd& error,
                           const Eigen::MatrixXd& truth) {
    outcome.worst = std::max(
        outcome.worst, ((value - truth).array().abs() / (found.t95 * error).array().max(1e-300)).maxCoeff());
    outcome.width =
        std::max(outcome.width, found.t95 * error.maxCoeff() / std::max(value.cwiseAbs().maxCoeff(), 1e-300));
  };
  compare(found.M, found.M_error, drawn.M);
  compare(found.B, found.B_error, drawn.B);
  compare(found.K, found.K_error, drawn.K);
  for (const auto& check : found.checks) {
    if (!check.is_passed) outcome.why += std::string(outcome.why.empty() ? "" : " ") + name_of(check.test);
  }
  if (found.is_ok()) outcome.judged = outcome.worst <= allowed ? Judged::kRight : Judged::kWrongAndOk;
  return outcome;
}

int run(int seeds, std::uint64_t first_seed, const std::vector<std::string>& names, bool is_verbose) {
  std::printf("%-22s %6s %8s %13s  %s\n", "kind", "right", "refused", "wrong and ok", "refused for");
  int right_described = 0;
  int described = 0;
  int wrong = 0;
  int all = 0;
  for (const RecordKind& kind : record_kinds()) {
    if (!names.empty() && std::ranges::find(names, kind.name) == names.end()) continue;
    std::vector<Outcome> outcomes(static_cast<std::size_t>(seeds));
    for_each_in_parallel(outcomes.size(),
                         [&](std::size_t i) { outcomes[i] = judged(draw(kind, first_seed + i)); });
    std::map<Judged, int> counts;
    std::map<std::string, int> reasons;
    for (std::size_t i = 0; i < outcomes.size(); ++i) {
      const Outcome& outcome = outcomes[i];
      ++counts[outcome.judged];
      if (outcome.judged == Judged::kRefused) ++reasons[outcome.why];
      if (is_verbose)
        std::printf(
            "  seed %llu: %s, error %.2f half-widths, width %.3f, explained %.3f, coherence %.3f %s\n",
            static_cast<unsigned long long>(first_seed + i),
            outcome.judged == Judged::kRight     ? "right"
            : outcome.judged == Judged::kRefused ? "refused"
                                                 : "WRONG AND OK",
            outcome.worst, outcome.width, outcome.explained, outcome.coherence, outcome.why.c_str());
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
  app.add_flag("--each", is_verbose, "a line for each record");
  CLI11_PARSE(app, argc, argv);
  return tonus::campaigns::run(seeds, seed, kinds, is_verbose);
}
