#include <array>
#include <spdlog/fmt/fmt.h>

#include "analysis_service/certify/certification.hpp"
#include "analysis_service/report/tables.hpp"

namespace tonus::report {
namespace {

constexpr std::size_t kConditions = 10;  // simulated for each measured one

/// Means over the postures of a subject.
struct Worth {
  std::array<double, 4> coverage{};
  std::array<double, 3> rmse{};
  std::array<double, 3> bias{};
  double suspect = 0.0;
  double postures = 0.0;

  void add(const certify::MethodWorth& one) {
    for (std::size_t i = 0; i < 4; ++i) coverage[i] += one.matrices[i].coverage;
    for (std::size_t i = 0; i < 3; ++i) {
      rmse[i] += one.matrices[i].rmse;
      bias[i] += one.matrices[i].bias;
    }
    suspect += static_cast<double>(one.suspect) / static_cast<double>(one.conditions);
    postures += 1.0;
  }
};

std::vector<std::string> row_of(const std::string& subject, impedance::Method method, const Worth& worth) {
  std::vector<std::string> row{subject, std::string(name_of(method))};
  for (std::size_t i = 0; i < 4; ++i)
    row.push_back(fmt::format("{:.0f} %", 100.0 * worth.coverage[i] / worth.postures));
  for (std::size_t i = 0; i < 3; ++i)
    row.push_back(fmt::format("{:.1f} % ({:+.1f} %)", 100.0 * worth.rmse[i] / worth.postures,
                              100.0 * worth.bias[i] / worth.postures));
  row.push_back(fmt::format("{:.0f} %", 100.0 * worth.suspect / worth.postures));
  return row;
}

}  // namespace

Table worth_table(const study::Study& study) {
  Table table{
      "worth",
      "What the numbers of each subject are worth",
      fmt::format(
          "By simulation around the subject's own estimate, rig and residuals (tonus certify --like), "
          "{} conditions a posture, seed 1: share of true elements inside the 95 % intervals of mass, "
          "damping, stiffness and spring centre; root mean square error as a share of the largest "
          "element, the largest bias in brackets; conditions that are flagged although nothing is "
          "wrong with them. One standard error of a share of 95 % over 50 conditions is about 2 %.",
          kConditions),
      {"subject", "method", "M inside", "B inside", "K inside", "X0 inside", "error of M (bias)",
       "error of B (bias)", "error of K (bias)", "flagged"},
      {}};
  for (const study::Subject& subject : study.subjects) {
    if (!subject.unloaded) continue;
    std::array<Worth, std::size(impedance::kPerturbationMethods)> all;
    for (const auto& condition : subject.unloaded->conditions) {
      const auto worths = certify::certify_like(condition.trials, {kConditions, 1, 1.0});
      if (!worths) continue;  // no command, or no estimate to simulate around
      for (std::size_t m = 0; m < all.size(); ++m) all[m].add((*worths)[m]);
    }
    for (std::size_t m = 0; m < all.size(); ++m) {
      if (all[m].postures > 0.0)
        table.rows.push_back(row_of(subject.name, impedance::kPerturbationMethods[m], all[m]));
    }
  }
  return table;
}

}  // namespace tonus::report
