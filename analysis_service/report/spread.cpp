#include "analysis_service/report/spread.hpp"

#include <cmath>
#include <iterator>
#include <spdlog/fmt/fmt.h>

#include "analysis_service/report/published.hpp"
#include "analysis_service/report/tables.hpp"

namespace tonus::report {
namespace {

using impedance::Hypothesis;

void add(EntriesWithin& within, const std::string& name, double found, double truth, double spread) {
  ++within.all;
  if (std::abs(found - truth) <= spread) {
    ++within.inside;
    return;
  }
  within.outside += fmt::format("{}{}: {:.3f}, true {:.3f} ± {:.3f}", within.outside.empty() ? "" : "; ",
                                name, found, truth, spread);
}

void add_constants(EntriesWithin& within, const study::Subject& subject, Hypothesis hypothesis,
                   double spread) {
  const auto found = subject.fit(hypothesis);
  const auto truth = subject.true_fit(hypothesis);
  if (!found || !truth) return;
  for (Eigen::Index i = 0; i < found->constants.size(); ++i) {
    add(within, subject.name + " " + std::string(impedance::name_of(hypothesis)), found->constants[i],
        truth->constants[i], spread);
  }
}

void add_masses(EntriesWithin& within, const study::Subject& subject, const published::TableOneRow& printed) {
  for (std::size_t m = 0; m < std::size(impedance::kMethods); ++m) {
    const auto masses = subject.link_masses(impedance::kMethods[m]);
    if (!masses) continue;
    const std::string name = subject.name + " " + std::string(name_of(impedance::kMethods[m]));
    add(within, name + " m1", masses->mass[0], subject.truth->link_masses[0], printed.upper_arm[m].sd);
    add(within, name + " m2", masses->mass[1], subject.truth->link_masses[1], printed.forearm[m].sd);
  }
}

}  // namespace

std::vector<EntriesWithin> entries_within_spread(const study::Study& study) {
  EntriesWithin one{"I"};
  EntriesWithin three{"III"};
  EntriesWithin four{"IV"};
  for (std::size_t s = 0; s < study.subjects.size(); ++s) {
    const study::Subject& subject = study.subjects[s];
    if (!subject.unloaded || !subject.truth) continue;
    if (s < published::kTableOne.size()) add_masses(one, subject, published::kTableOne[s]);
    if (s >= published::kTableThree.size()) continue;
    const auto& printed = published::kTableThree[s];
    add_constants(three, subject, Hypothesis::kSS, printed.tau.sd);
    add_constants(three, subject, Hypothesis::kSD, printed.zeta.sd);
    add_constants(four, subject, Hypothesis::kMS, printed.tau.sd);
    add_constants(four, subject, Hypothesis::kMD, printed.zeta.sd);
  }
  return {one, three, four};
}

Table spread_table(const study::Study& study) {
  Table table{
      "spread",
      "Entries within the published spread of the cohort's truth",
      "Spread: one standard deviation as printed for the same subject; Table IV prints none, so that of "
      "the subject's tau and zeta in Table III.",
      {"table", "inside", "of", "outside"},
      {}};
  for (const EntriesWithin& within : entries_within_spread(study)) {
    table.rows.push_back({within.table, std::to_string(within.inside), std::to_string(within.all),
                          within.outside.empty() ? "–" : within.outside});
  }
  return table;
}

}  // namespace tonus::report
