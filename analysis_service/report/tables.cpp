#include "analysis_service/report/tables.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <spdlog/fmt/fmt.h>

#include "analysis_service/report/published.hpp"

namespace tonus::report {
namespace {

using impedance::Hypothesis;
using impedance::Model;

constexpr const char* kNone = "–";

std::string with_sd(double value, double sd, int digits) {
  return fmt::format("{:.{}f} ± {:.{}f}", value, digits, sd, digits);
}

std::string constants_text(const std::optional<impedance::HypothesisFit>& fit) {
  if (!fit) return kNone;
  std::string text;
  for (Eigen::Index i = 0; i < fit->constants.size(); ++i) {
    text += (i == 0 ? "" : ", ") + with_sd(fit->constants[i], fit->std[i], 3);
  }
  return text;
}

std::string true_text(const std::optional<impedance::HypothesisFit>& fit) {
  if (!fit) return kNone;
  std::string text;
  for (Eigen::Index i = 0; i < fit->constants.size(); ++i)
    text += fmt::format("{}{:.3f}", i == 0 ? "" : ", ", fit->constants[i]);
  return text;
}

std::string error_text(const std::optional<impedance::HypothesisFit>& fit) {
  return fit ? fmt::format("{:.0f}", 100.0 * fit->error) : kNone;
}

const study::ConditionAnalysis* posture_of(const study::Subject& subject, const std::string& posture) {
  if (!subject.unloaded) return nullptr;
  const auto& all = subject.unloaded->conditions;
  const auto found =
      std::find_if(all.begin(), all.end(), [&](const auto& c) { return c.condition.posture == posture; });
  return found == all.end() ? nullptr : &*found;
}

std::string fitting_error_text(const study::ConditionAnalysis& condition, Model model) {
  const auto error = condition.fitting_error(model);
  return error ? fmt::format("{:.2f}, {:.2f}", (*error)[0], (*error)[1]) : kNone;
}

/// The paper's subjects are simulated by the first of a cohort. A real person has no published values, by
/// whatever name.
bool stands_for_published(const study::Study& study, std::size_t subject, std::size_t published) {
  return subject < published && study.subjects[subject].truth.has_value();
}

}  // namespace

Table table_one(const study::Study& study) {
  Table table{
      "table1",
      "Table I. Link masses implied by the identified mass matrices",
      "m1 upper arm, m2 forearm with hand, kg ± one standard deviation; the proximal posture is left "
      "out of the fit, as published. The published values are those of the paper's subjects 1 to 3.",
      {"subject", "method", "m1 (kg)", "m1 published", "m1 true", "m2 (kg)", "m2 published", "m2 true"},
      {}};
  for (std::size_t s = 0; s < study.subjects.size(); ++s) {
    const study::Subject& subject = study.subjects[s];
    if (!subject.unloaded) continue;
    for (std::size_t m = 0; m < std::size(impedance::kMethods); ++m) {
      const auto masses = subject.link_masses(impedance::kMethods[m]);
      std::vector<std::string> row{subject.name, std::string(name_of(impedance::kMethods[m]))};
      for (const Eigen::Index link : {0, 1}) {
        row.push_back(masses ? with_sd(masses->mass[link], masses->std[link], 2) : kNone);
        const bool is_published = stands_for_published(study, s, published::kTableOne.size());
        if (is_published) {
          const auto& printed = published::kTableOne[s];
          const auto& value = (link == 0 ? printed.upper_arm : printed.forearm)[m];
          row.push_back(with_sd(value.value, value.sd, 2));
        } else {
          row.push_back(kNone);
        }
        row.push_back(subject.truth ? fmt::format("{:.2f}", subject.truth->link_masses[link]) : kNone);
      }
      table.rows.push_back(std::move(row));
    }
  }
  return table;
}

Table table_two(const study::Study& study) {
  Table table{
      "table2",
      "Table II. Fitting errors of four models",
      "Along x and y, N, root mean square over all trials up to 1.0 s: measured force minus the "
      "force that the "
      "model, identified by state-variable filtering, makes of the measured displacement (its "
      "derivatives behind "
      "a low-pass of 10 Hz). The square in (15) is taken as printed, which loses the direction of the "
      "velocity, and with its sign kept, x' |x'|, which alone can oppose motion both ways. "
      "Published: average fitting errors of the paper's subjects 1 and 2.",
      {"subject", "posture", "linear (3)", "published", "no damping (13)", "published", "Coriolis (14)",
       "published", "squared velocity (15)", "signed squares (15)", "published"},
      {}};
  constexpr std::array kModels{Model::kLinear, Model::kNoDamping, Model::kCoriolis, Model::kSquaredVelocity};
  for (std::size_t s = 0; s < study.subjects.size(); ++s) {
    for (std::size_t p = 0; p < published::kTableTwoPostures.size(); ++p) {
      const auto* condition = posture_of(study.subjects[s], published::kTableTwoPostures[p]);
      if (condition == nullptr) continue;
      std::vector<std::string> row{study.subjects[s].name, published::kTableTwoPostures[p]};
      for (std::size_t m = 0; m < kModels.size(); ++m) {
        row.push_back(fitting_error_text(*condition, kModels[m]));
        if (kModels[m] == Model::kSquaredVelocity)
          row.push_back(fitting_error_text(*condition, Model::kSignedSquaredVelocity));
        if (stands_for_published(study, s, published::kTableTwo.size())) {
          const auto& printed = published::kTableTwo[s][p][m];
          row.push_back(fmt::format("{:.2f}, {:.2f}", printed[0], printed[1]));
        } else {
          row.push_back(kNone);
        }
      }
      table.rows.push_back(std::move(row));
    }
  }
  return table;
}

Table table_three(const study::Study& study) {
  Table table{
      "table3",
      "Table III. One constant between joint damping and joint stiffness",
      "SS: B_ij = tau K_ij; SD: B_ij = 2 zeta sqrt(I_ij K_ij); ± one standard deviation; % error: root mean "
      "square fitting error over the largest joint damping. True: the same fit to the true matrices. A "
      "cohort that "
      "is built with Table IV's time constants has the damping ratios that its own inertia and stiffness "
      "give, not "
      "the published ones.",
      {"subject", "tau (s)", "published", "true", "SS % error", "published", "zeta", "published", "true",
       "SD % error", "published"},
      {}};
  for (std::size_t s = 0; s < study.subjects.size(); ++s) {
    const study::Subject& subject = study.subjects[s];
    if (!subject.unloaded) continue;
    const auto ss = subject.fit(Hypothesis::kSS);
    const auto sd = subject.fit(Hypothesis::kSD);
    std::vector<std::string> row{
        subject.name, constants_text(ss), kNone, true_text(subject.true_fit(Hypothesis::kSS)), error_text(ss),
        kNone,        constants_text(sd), kNone, true_text(subject.true_fit(Hypothesis::kSD)), error_text(sd),
        kNone};
    if (stands_for_published(study, s, published::kTableThree.size())) {
      const auto& printed = published::kTableThree[s];
      row[2] = with_sd(printed.tau.value, printed.tau.sd, 3);
      row[5] = fmt::format("{:.0f}", printed.tau_error);
      row[7] = with_sd(printed.zeta.value, printed.zeta.sd, 2);
      row[10] = fmt::format("{:.0f}", printed.zeta_error);
    }
    table.rows.push_back(std::move(row));
  }
  return table;
}

Table table_four(const study::Study& study) {
  Table table{"table4",
              "Table IV. Three constants: shoulder, elbow, two-joint",
              "MS: B_11 = tau_s K_11, B_22 = tau_e K_22, B_12 = tau_tj K_12; MD likewise with 2 zeta sqrt(I "
              "K); otherwise as Table III.",
              {"subject", "tau_s, tau_e, tau_tj (s)", "published", "true", "MS % error", "published",
               "zeta_s, zeta_e, zeta_tj", "published", "true", "MD % error", "published"},
              {}};
  for (std::size_t s = 0; s < study.subjects.size(); ++s) {
    const study::Subject& subject = study.subjects[s];
    if (!subject.unloaded) continue;
    const auto ms = subject.fit(Hypothesis::kMS);
    const auto md = subject.fit(Hypothesis::kMD);
    std::vector<std::string> row{
        subject.name, constants_text(ms), kNone, true_text(subject.true_fit(Hypothesis::kMS)), error_text(ms),
        kNone,        constants_text(md), kNone, true_text(subject.true_fit(Hypothesis::kMD)), error_text(md),
        kNone};
    if (stands_for_published(study, s, published::kTableFour.size())) {
      const auto& printed = published::kTableFour[s];
      row[2] = fmt::format("{:.3f}, {:.3f}, {:.3f}", printed.tau[0], printed.tau[1], printed.tau[2]);
      row[5] = fmt::format("{:.0f}", printed.tau_error);
      row[7] = fmt::format("{:.3f}, {:.3f}, {:.3f}", printed.zeta[0], printed.zeta[1], printed.zeta[2]);
      row[10] = fmt::format("{:.0f}", printed.zeta_error);
    }
    table.rows.push_back(std::move(row));
  }
  return table;
}

}  // namespace tonus::report
