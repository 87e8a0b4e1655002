#include "services/contract/estimate_json.hpp"

#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "services/contract/names.hpp"
#include "services/contract/rig.hpp"

namespace tonus::contract {
namespace {

using nlohmann::json;

json matrix(const std::array<double, 4>& values, unsigned axes) {
  if (axes == 1) return json::array({json::array({values[0]})});
  return json::array({json::array({values[0], values[1]}), json::array({values[2], values[3]})});
}

json vector(const std::array<double, 2>& values, unsigned axes) {
  return axes == 1 ? json::array({values[0]}) : json::array({values[0], values[1]});
}

json matrix_intervals(const v1::MatrixEstimate& m, unsigned axes) {
  json rows = json::array();
  for (unsigned row = 0; row < axes; ++row) {
    json cells = json::array();
    for (unsigned column = 0; column < axes; ++column) {
      const std::size_t i = row * 2 + column;
      cells.push_back(json::array({m.low95()[i], m.high95()[i]}));
    }
    rows.push_back(cells);
  }
  return rows;
}

json vector_intervals(const v1::VectorEstimate& v, unsigned axes) {
  json cells = json::array();
  for (unsigned i = 0; i < axes; ++i) cells.push_back(json::array({v.low95()[i], v.high95()[i]}));
  return cells;
}

json known_or_null(double value) { return std::isfinite(value) ? json(value) : json(nullptr); }

json interval(double low, double high) { return json::array({known_or_null(low), known_or_null(high)}); }

json ellipse(const v1::MatrixEstimate& m) {
  if (!m.has_ellipse()) return {{"reason", "not positive definite"}};
  return {{"size", m.size()},
          {"shape", m.shape()},
          {"orientation_deg", m.orientation_deg()},
          {"size_ci95", interval(m.size_low95(), m.size_high95())},
          {"shape_ci95", interval(m.shape_low95(), m.shape_high95())},
          {"orientation_ci95_deg", interval(m.orientation_low95_deg(), m.orientation_high95_deg())},
          {"curl_ci95", interval(m.curl_low95(), m.curl_high95())}};
}

/// Of the elements row by row; null: not known.
json covariance(const v1::MatrixEstimate& m, unsigned axes) {
  json rows = json::array();
  for (unsigned i = 0; i < axes * axes; ++i) {
    json cells = json::array();
    for (unsigned j = 0; j < axes * axes; ++j) cells.push_back(known_or_null(m.covariance()[4 * i + j]));
    rows.push_back(cells);
  }
  return rows;
}

json covariance(const v1::VectorEstimate& v, unsigned axes) {
  json rows = json::array();
  for (unsigned i = 0; i < axes; ++i) {
    json cells = json::array();
    for (unsigned j = 0; j < axes; ++j) cells.push_back(known_or_null(v.covariance()[2 * i + j]));
    rows.push_back(cells);
  }
  return rows;
}

json known_bias(const v1::MatrixEstimate& m, unsigned axes) {
  if (!std::isfinite(m.known_bias()[0])) return nullptr;
  return matrix(m.known_bias(), axes);
}

json known_or_null(const std::array<double, 2>& values, unsigned axes) {
  json cells = json::array();
  for (unsigned i = 0; i < axes; ++i) cells.push_back(known_or_null(values[i]));
  return cells;
}

json checks(const v1::Estimate& e) {
  json all = json::array();
  for (const v1::FitCheck& check : e.checks()) {
    all.push_back({{"test", v1::test_name(check.test())},
                   {"value", known_or_null(check.value())},
                   {"limit", known_or_null(check.limit())},
                   {"passed", check.passed()}});
  }
  return all;
}

json parameters(const v1::Estimate& e) {
  json all = json::array();
  for (const v1::ModelParameter& parameter : e.parameters()) {
    all.push_back({{"name", parameter.name()},
                   {"unit", parameter.unit()},
                   {"value", parameter.value()},
                   {"std", parameter.standard_error()},
                   {"ci95", {parameter.low95(), parameter.high95()}}});
  }
  return all;
}

}  // namespace

json json_of(const v1::Estimate& e) {
  const unsigned axes = e.axes();
  json c = {{"posture", e.posture()},
            {"bias_N", {e.bias_N()[0], e.bias_N()[1]}},
            {"set", e.set_number() == 0 ? json(nullptr) : json(e.set_number())},
            {"instruction", e.instruction().empty() ? json(nullptr) : json(e.instruction())},
            {"method", e.method()},
            {"model", e.model()},
            {"trials_used", e.trials_used()},
            {"samples", e.samples()},
            {"status", v1::status_name(e.status())},
            {"reasons", e.reasons()}};
  if (e.status() != v1::ESTIMATE_UNDETERMINED) {
    c["M_kg"] = matrix(e.mass_kg().value(), axes);
    c["B_Ns_per_m"] = matrix(e.damping_Ns_per_m().value(), axes);
    c["K_N_per_m"] = matrix(e.stiffness_N_per_m().value(), axes);
    c["X0_m"] = vector(e.spring_centre_m().value(), axes);
    c["std"] = {{"M_kg", matrix(e.mass_kg().standard_error(), axes)},
                {"B_Ns_per_m", matrix(e.damping_Ns_per_m().standard_error(), axes)},
                {"K_N_per_m", matrix(e.stiffness_N_per_m().standard_error(), axes)},
                {"X0_m", vector(e.spring_centre_m().standard_error(), axes)}};
    c["ci95"] = {{"M_kg", matrix_intervals(e.mass_kg(), axes)},
                 {"B_Ns_per_m", matrix_intervals(e.damping_Ns_per_m(), axes)},
                 {"K_N_per_m", matrix_intervals(e.stiffness_N_per_m(), axes)},
                 {"X0_m", vector_intervals(e.spring_centre_m(), axes)}};
    c["covariance"] = {{"M_kg2", covariance(e.mass_kg(), axes)},
                       {"B_N2s2_per_m2", covariance(e.damping_Ns_per_m(), axes)},
                       {"K_N2_per_m2", covariance(e.stiffness_N_per_m(), axes)},
                       {"X0_m2", covariance(e.spring_centre_m(), axes)}};
    c["known_bias"] = {{"M_kg", known_bias(e.mass_kg(), axes)},
                       {"B_Ns_per_m", known_bias(e.damping_Ns_per_m(), axes)},
                       {"K_N_per_m", known_bias(e.stiffness_N_per_m(), axes)}};
    c["sigma_N"] = vector(e.sigma_N(), axes);
    c["condition_number"] = e.condition_number();
    c["lag_s"] = known_or_null(e.lag_s(), axes);
    c["lag_ci95_s"] = {{"low", known_or_null(e.lag_low95_s(), axes)},
                       {"high", known_or_null(e.lag_high95_s(), axes)}};
    c["band_Hz"] = e.band_high_Hz() > 0.0 ? json::array({e.band_low_Hz(), e.band_high_Hz()}) : json(nullptr);
  }
  c["explained_share"] = known_or_null(e.explained_share());
  c["independent_units"] = e.independent_units();
  c["degrees_of_freedom"] = e.degrees_of_freedom();
  c["checks"] = checks(e);
  if (!e.parameters().empty()) c["parameters"] = parameters(e);
  if (!e.prior().empty()) c["prior"] = e.prior();
  if (!e.compared_models().empty()) c["compared_models"] = e.compared_models();
  if (axes == 2 && e.status() != v1::ESTIMATE_UNDETERMINED) {
    c["ellipses"] = {{"M", ellipse(e.mass_kg())},
                     {"B", ellipse(e.damping_Ns_per_m())},
                     {"K", ellipse(e.stiffness_N_per_m())}};
    c["curl"] = {
        {"M", e.mass_kg().curl()}, {"B", e.damping_Ns_per_m().curl()}, {"K", e.stiffness_N_per_m().curl()}};
  }
  if (axes == 1) {
    const MatrixUnits units = matrix_units({e.displacement_unit(), e.force_unit()});
    c["units"] = {{"M_kg", units.mass},
                  {"B_Ns_per_m", units.damping},
                  {"K_N_per_m", units.stiffness},
                  {"X0_m", e.displacement_unit()},
                  {"sigma_N", e.force_unit()}};
  }
  return c;
}

}  // namespace tonus::contract
