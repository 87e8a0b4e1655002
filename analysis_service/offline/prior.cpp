#include "analysis_service/offline/prior.hpp"

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <numbers>
#include <optional>
#include <spdlog/fmt/fmt.h>
#include <utility>

#include "analysis_service/impedance/belief.hpp"
#include "analysis_service/impedance/ellipse.hpp"
#include "analysis_service/impedance/ellipse_intervals.hpp"
#include "analysis_service/service/wire.hpp"
#include "services/contract/names.hpp"
#include "services/core/text_file.hpp"

namespace tonus::identification {
namespace {

using impedance::Belief;
using nlohmann::json;

constexpr const char* kValues[] = {"M_kg", "B_Ns_per_m", "K_N_per_m"};
constexpr const char* kCovariances[] = {"M_kg2", "B_N2s2_per_m2", "K_N2_per_m2"};

/// Row by row, whatever its depth; empty where a number is missing.
void flatten(const json& values, std::vector<double>& all) {
  if (values.is_array()) {
    for (const json& value : values) flatten(value, all);
  } else {
    all.push_back(values.is_number() ? values.get<double>() : std::numeric_limits<double>::quiet_NaN());
  }
}

std::optional<Eigen::VectorXd> numbers(const json& object, const char* key, Eigen::Index size) {
  if (!object.is_object() || !object.contains(key)) return std::nullopt;
  std::vector<double> all;
  flatten(object.at(key), all);
  if (static_cast<Eigen::Index>(all.size()) != size) return std::nullopt;
  const Eigen::VectorXd found = Eigen::Map<const Eigen::VectorXd>(all.data(), size);
  return found.allFinite() ? std::optional(found) : std::nullopt;
}

std::string text_at(const json& condition, const char* key) {
  const auto found = condition.find(key);
  return found != condition.end() && found->is_string() ? found->get<std::string>() : std::string{};
}

bool is_for(const json& condition, const v1::Estimate& estimate) {
  const auto bias = numbers(condition, "bias_N", 2);
  const bool is_same_bias =
      bias && std::hypot((*bias)[0] - estimate.bias_N()[0], (*bias)[1] - estimate.bias_N()[1]) < 0.01;
  return is_same_bias && text_at(condition, "posture") == estimate.posture() &&
         text_at(condition, "method") == estimate.method() && text_at(condition, "model") == "linear" &&
         text_at(condition, "status") != "undetermined" && text_at(condition, "prior").empty();
}

/// One matrix in the results; none where they do not have it.
std::optional<Belief> belief_of(const std::vector<const json*>& conditions, std::size_t matrix,
                                Eigen::Index size, double change) {
  Eigen::MatrixXd values(size, static_cast<Eigen::Index>(conditions.size()));
  for (std::size_t i = 0; i < conditions.size(); ++i) {
    const auto value = numbers(*conditions[i], kValues[matrix], size);
    if (!value) return std::nullopt;
    values.col(static_cast<Eigen::Index>(i)) = *value;
  }
  if (conditions.size() > 1) return impedance::belief_of_many(values);
  const json& one = *conditions.front();
  if (!one.contains("covariance")) return std::nullopt;
  const auto covariance = numbers(one.at("covariance"), kCovariances[matrix], size * size);
  if (!covariance) return std::nullopt;
  Belief belief{values.col(0), covariance->reshaped(size, size), 1.0};
  const double spread = change * belief.value.cwiseAbs().maxCoeff();
  belief.covariance.diagonal().array() += spread * spread;
  const auto freedom = one.find("degrees_of_freedom");
  if (freedom != one.end() && freedom->is_number()) belief.freedom = freedom->get<double>();
  return belief;
}

v1::MatrixEstimate& matrix_of(v1::Estimate& estimate, std::size_t matrix) {
  if (matrix == 0) return estimate.mass_kg();
  return matrix == 1 ? estimate.damping_Ns_per_m() : estimate.stiffness_N_per_m();
}

Belief belief_of(const v1::MatrixEstimate& wire, Eigen::Index axes, double freedom) {
  Belief belief{Eigen::VectorXd(axes * axes), Eigen::MatrixXd(axes * axes, axes * axes), freedom};
  for (Eigen::Index i = 0; i < axes * axes; ++i) {
    belief.value[i] = wire.value()[static_cast<std::size_t>(i)];
    for (Eigen::Index j = 0; j < axes * axes; ++j)
      belief.covariance(i, j) = wire.covariance()[static_cast<std::size_t>(4 * i + j)];
  }
  return belief;
}

void set_matrix(const impedance::Combined& combined, v1::MatrixEstimate& wire) {
  v1::MatrixEstimate fresh = unknown_matrix();
  const Eigen::Index size = combined.belief.value.size();
  for (Eigen::Index i = 0; i < size; ++i) {
    const auto at = static_cast<std::size_t>(i);
    fresh.value()[at] = combined.belief.value[i];
    fresh.standard_error()[at] = combined.std[i];
    fresh.low95()[at] = combined.belief.value[i] - combined.half[i];
    fresh.high95()[at] = combined.belief.value[i] + combined.half[i];
  }
  set_covariance(combined.belief.covariance, fresh);
  if (size == 4) {
    Eigen::Matrix2d Z;
    Z << combined.belief.value[0], combined.belief.value[1], combined.belief.value[2],
        combined.belief.value[3];
    const Eigen::Matrix4d C = combined.belief.covariance;
    set_ellipse(Z,
                impedance::ellipse_intervals(
                    Z, C,
                    [&](const Eigen::Vector4d& w) {
                      return impedance::CombinationSpread{std::sqrt(w.dot(C * w)), combined.belief.freedom};
                    }),
                fresh);
  }
  wire = fresh;
}

/// The estimate combined with the results for it; none where there are none.
std::optional<v1::Estimate> combined_with(const std::vector<const json*>& conditions, v1::Estimate estimate,
                                          const PriorChoice& choice) {
  const auto axes = static_cast<Eigen::Index>(estimate.axes());
  double apart = 0.0;
  for (std::size_t matrix = 0; matrix < 3; ++matrix) {
    v1::MatrixEstimate& wire = matrix_of(estimate, matrix);
    const auto prior = belief_of(conditions, matrix, axes * axes, choice.change);
    const Belief own = belief_of(wire, axes, estimate.degrees_of_freedom());
    if (!prior || !own.covariance.allFinite() || !(own.covariance.diagonal().minCoeff() > 0.0) ||
        !(prior->covariance.diagonal().minCoeff() > 0.0))
      return std::nullopt;
    const impedance::Combined combined = impedance::combine(own, *prior);
    apart = std::max(apart, combined.apart);
    set_matrix(combined, wire);
  }
  const std::string what = conditions.size() > 1
                               ? fmt::format("{} results", conditions.size())
                               : fmt::format("1 result, change of {:.3g} %", 100.0 * choice.change);
  estimate.prior(fmt::format("{} ({}); the data differ from it by at most {:.2f} joint 95 % half-widths",
                             choice.results.filename().string(), what, apart));
  return estimate;
}

Result<json> read_results(const std::filesystem::path& file) {
  TONUS_TRY_ASSIGN(const auto text, read_text_file(file));
  json results = json::parse(text, nullptr, false);
  const bool is_results =
      results.is_object() && results.contains("conditions") && results["conditions"].is_array();
  if (!is_results)
    return fail(
        ErrorCode::kInvalidArgument,
        fmt::format("prior: '{}' is not allowed; expected a file of tonus identify --json", file.string()));
  return results;
}

}  // namespace

Result<std::vector<OfflineEstimate>> with_prior(std::vector<OfflineEstimate> estimates,
                                                const PriorChoice& choice) {
  TONUS_TRY_ASSIGN(const json results, read_results(choice.results));
  std::vector<OfflineEstimate> all;
  bool has_any = false;
  for (OfflineEstimate& one : estimates) {
    all.push_back(one);
    const bool is_determined = one.estimate.status() != v1::ESTIMATE_UNDETERMINED;
    if (!is_determined || one.estimate.model() != "linear") continue;
    std::vector<const json*> conditions;
    for (const json& condition : results.at("conditions")) {
      if (condition.is_object() && is_for(condition, one.estimate)) conditions.push_back(&condition);
    }
    if (conditions.empty()) continue;
    auto combined = combined_with(conditions, one.estimate, choice);
    if (!combined) continue;
    has_any = true;
    all.push_back(std::move(one));
    all.back().estimate = std::move(*combined);
  }
  if (!has_any)
    return fail(
        ErrorCode::kInvalidArgument,
        fmt::format("prior: '{}' has no result for these conditions; expected the same posture, bias and "
                    "method, model linear, with covariances",
                    choice.results.string()));
  return all;
}

}  // namespace tonus::identification
