#include "services/python/module/errors.hpp"

#include <pybind11/pybind11.h>

namespace tonus::python {
namespace {

const char* class_of(ErrorCode code) {
  switch (code) {
    case ErrorCode::kInvalidArgument:
      return "InvalidArgumentError";
    case ErrorCode::kNotFound:
      return "NotFoundError";
    case ErrorCode::kAlreadyExists:
      return "AlreadyExistsError";
    case ErrorCode::kTimeout:
      return "TimeoutError";
    case ErrorCode::kUnavailable:
      return "UnavailableError";
    case ErrorCode::kDataLoss:
      return "DataLossError";
    case ErrorCode::kIo:
      return "IoError";
    case ErrorCode::kInternal:
      return "InternalError";
  }
  return "InternalError";
}

}  // namespace

void raise(const Error& error) {
  const auto kind = pybind11::module_::import("tonus.errors").attr(class_of(error.code));
  PyErr_SetString(kind.ptr(), error.message.c_str());
  throw pybind11::error_already_set();
}

}  // namespace tonus::python
