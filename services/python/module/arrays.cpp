#include "services/python/module/arrays.hpp"

namespace tonus::python {
namespace {

namespace py = pybind11;

template <typename T>
py::array column(const std::vector<T>& values, std::vector<py::ssize_t> shape, const py::capsule& owner) {
  py::array_t<T> array(std::move(shape), values.data(), owner);
  array.attr("setflags")(py::arg("write") = false);
  return array;
}

}  // namespace

py::dict arrays_of(std::shared_ptr<const Signals> signals) {
  const Signals& s = *signals;
  const py::capsule owner(new std::shared_ptr<const Signals>(std::move(signals)),
                          [](void* held) { delete static_cast<std::shared_ptr<const Signals>*>(held); });
  const auto rows = static_cast<py::ssize_t>(s.rows());
  const auto axes = static_cast<py::ssize_t>(s.axes);
  py::dict arrays;
  arrays["time"] = column(s.time, {rows}, owner);
  arrays["position"] = column(s.position, {rows, axes}, owner);
  arrays["force"] = column(s.force, {rows, axes}, owner);
  arrays["commanded"] = column(s.commanded, {rows, axes}, owner);
  arrays["phase"] = column(s.phase, {rows}, owner);
  arrays["is_missing"] = column(s.is_missing, {rows}, owner).attr("view")("bool");
  return arrays;
}

}  // namespace tonus::python
