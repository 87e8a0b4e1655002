#pragma once

#include "analysis_service/impedance/options.hpp"
#include "analysis_service/impedance/parameters.hpp"

namespace tonus::impedance {

/// Calls `body.operator()<kRegressors, kAxes>()` with the sizes of a model on 1 or 2 axes, fixed at compile
/// time.
template <typename Body>
decltype(auto) with_sizes(Model model, int axes, Body&& body) {
  const int size = regressors(model, axes);
  if (axes == 1) {
    return size == 3 ? body.template operator()<3, 1>() : body.template operator()<4, 1>();
  }
  if (size == 5) return body.template operator()<5, 2>();
  return size == 8 ? body.template operator()<8, 2>() : body.template operator()<7, 2>();
}

}  // namespace tonus::impedance
