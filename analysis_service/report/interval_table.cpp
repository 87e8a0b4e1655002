#include <cmath>
#include <spdlog/fmt/fmt.h>

#include "analysis_service/report/tables.hpp"
#include "analysis_service/report/tally.hpp"

namespace tonus::report {
namespace {

using impedance::Hypothesis;
using impedance::Interval;

/// A number with its interval and the truth, and whether it is inside.
std::string cell(const Interval& interval, double value, const std::optional<double>& truth, int digits,
                 Share& inside) {
  std::string text =
      fmt::format("{:.{}f} ({:.{}f} to {:.{}f})", value, digits, interval.low, digits, interval.high, digits);
  if (!truth) return text;
  const bool is_inside = interval.low <= *truth && *truth <= interval.high;
  inside.add(is_inside);
  return text + fmt::format("; true {:.{}f}{}", *truth, digits, is_inside ? "" : ", outside");
}

constexpr const char* kNone = "–";

std::vector<std::string> mass_row(const study::Subject& subject, impedance::Method method, Share& inside) {
  const auto masses = subject.link_masses(method);
  const auto intervals = subject.link_mass_intervals(method);
  std::vector<std::string> row{subject.name, std::string(name_of(method))};
  for (const Eigen::Index link : {0, 1}) {
    if (!masses || intervals.size() != 2) {
      row.emplace_back(kNone);
      continue;
    }
    const auto truth = subject.truth ? std::optional(subject.truth->link_masses[link]) : std::nullopt;
    row.push_back(cell(intervals[static_cast<std::size_t>(link)], masses->mass[link], truth, 2, inside));
  }
  return row;
}

std::string constants_cell(const study::Subject& subject, Hypothesis hypothesis, Share& inside) {
  const auto found = subject.fit(hypothesis);
  const auto intervals = subject.fit_intervals(hypothesis);
  if (!found || static_cast<Eigen::Index>(intervals.size()) != found->constants.size()) return kNone;
  const auto truth = subject.true_fit(hypothesis);
  std::string text;
  for (Eigen::Index i = 0; i < found->constants.size(); ++i) {
    const auto of_truth = truth ? std::optional(truth->constants[i]) : std::nullopt;
    text += (i == 0 ? "" : "; ") +
            cell(intervals[static_cast<std::size_t>(i)], found->constants[i], of_truth, 3, inside);
  }
  return text;
}

}  // namespace

Table intervals_table(const study::Study& study) {
  Table table{
      "intervals",
      "95 % intervals of link masses and joint constants",
      "What the errors of the identified matrices do to the numbers of Tables I, III and IV: first-order "
      "change with each element, through the covariances of each posture, known biases carried. They do "
      "not say how well two cylinders or one constant describe an arm. Constants: method "
      "state_variable.",
      {"subject", "method", "m1 (kg)", "m2 (kg)", "tau of SS (s)", "zeta of SD", "tau of MS (s)",
       "zeta of MD"},
      {}};
  Share inside;
  for (const study::Subject& subject : study.subjects) {
    if (!subject.unloaded) continue;
    for (const impedance::Method method : impedance::kPerturbationMethods) {
      auto row = mass_row(subject, method, inside);
      for (const Hypothesis hypothesis : impedance::kHypotheses)
        row.push_back(method == impedance::Method::kStateVariable
                          ? constants_cell(subject, hypothesis, inside)
                          : std::string(kNone));
      table.rows.push_back(std::move(row));
    }
  }
  if (inside.all > 0) table.note += " True numbers inside: " + inside.text() + ".";
  return table;
}

}  // namespace tonus::report
