#include <pybind11/pybind11.h>

#include "services/python/module/bindings.hpp"
#include "services/python/module/python_version.hpp"

PYBIND11_MODULE(_tonus, module) {
  module.doc() = "The C++ core of tonus. Use the package tonus, which documents everything.";
  module.attr("version") = tonus::python::kVersion;
  tonus::python::bind_recordings(module);
  tonus::python::bind_archives(module);
}
