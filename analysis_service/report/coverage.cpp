#include <array>
#include <spdlog/fmt/fmt.h>

#include "analysis_service/report/tables.hpp"
#include "analysis_service/report/tally.hpp"

namespace tonus::report {
namespace {

using impedance::Method;
using Matrix = impedance::AxisMatrix;

void count_inside(const Matrix& truth, const Matrix& low, const Matrix& high, Share& share) {
  for (Eigen::Index i = 0; i < truth.size(); ++i)
    share.add(low.reshaped()[i] <= truth.reshaped()[i] && truth.reshaped()[i] <= high.reshaped()[i]);
}

void add_bias(const Matrix& truth, const Matrix& found, Spread& bias) {
  const double largest = truth.cwiseAbs().maxCoeff();
  for (const Eigen::Index i : {0, 1}) bias.add((found(i, i) - truth(i, i)) / largest);
}

}  // namespace

Table coverage_table(const study::Study& study) {
  Table table{
      "coverage",
      "True elements inside the stated 95 % intervals",
      "The intervals take the trial as the independent unit; they state the spread over trials and know "
      "nothing of a method's bias. What falls short of 95 % here is bias: slow voluntary drift is fed "
      "back into the displacement by the compliance of rig and arm, so that regressors and error are "
      "correlated, and low-pass filtering attenuates the accelerations. Bias: mean over all postures of the "
      "difference from the truth, of the diagonal elements, as a share of the largest element.",
      {"method", "mass", "damping", "stiffness", "bias of mass", "bias of damping", "bias of stiffness"},
      {}};
  for (const Method method : impedance::kPerturbationMethods) {
    std::array<Share, 3> shares;
    std::array<Spread, 3> bias;
    for (const study::Subject& subject : study.subjects) {
      if (!subject.unloaded || !subject.truth) continue;
      for (const auto& condition : subject.unloaded->conditions) {
        const auto* e = condition.find(method);
        if (e == nullptr) continue;
        const auto truth = study::truth_at(*subject.truth, condition.condition.position);
        count_inside(truth.M, e->low.M, e->high.M, shares[0]);
        count_inside(truth.B, e->low.B, e->high.B, shares[1]);
        count_inside(truth.K, e->low.K, e->high.K, shares[2]);
        add_bias(truth.M, e->value.M, bias[0]);
        add_bias(truth.B, e->value.B, bias[1]);
        add_bias(truth.K, e->value.K, bias[2]);
      }
    }
    std::vector<std::string> row{std::string(name_of(method))};
    for (const Share& share : shares) row.push_back(share.text());
    for (const Spread& spread : bias) row.push_back(fmt::format("{:+.1f} %", 100.0 * spread.mean()));
    table.rows.push_back(std::move(row));
  }
  return table;
}

}  // namespace tonus::report
