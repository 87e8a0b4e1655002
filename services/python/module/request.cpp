#include "services/python/module/request.hpp"

#include <pybind11/stl.h>
#include <string>

namespace tonus::python {

namespace py = pybind11;

identification::Request request_of(const py::kwargs& settings) {
  identification::Request request;
  for (const auto& [key, value] : settings) {
    const auto name = key.cast<std::string>();
    if (name == "method") {
      request.method = value.cast<std::string>();
    } else if (name == "model") {
      request.model = value.cast<std::string>();
    } else if (name == "window") {
      request.settings.window = value.cast<double>();
    } else if (name == "cutoff") {
      request.settings.cutoff = value.cast<double>();
    } else if (name == "natural_frequency") {
      request.settings.natural_frequency = value.cast<std::optional<double>>();
    } else if (name == "damping_ratio") {
      request.settings.damping_ratio = value.cast<double>();
    } else {
      throw py::type_error("identify() has no setting '" + name +
                           "'; expected method, model, window, cutoff, natural_frequency or damping_ratio");
    }
  }
  return request;
}

}  // namespace tonus::python
