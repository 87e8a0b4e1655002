#pragma once

#include <cstddef>
#include <string>

#include <idl/archive.h>
#include <idl/estimate.h>
#include <idl/rig.h>
#include <idl/service.h>
#include <idl/session.h>
#include <idl/trial.h>

/// Bounds that the .idl files state and the generated code does not check. Encoding and decoding ask
/// bounds_violation(), which bounds.awk makes for every type from the .idl files; the answer is empty where a
/// value is within its bounds. Enumerators of a newer contract are refused here too. Lengths are checked
/// before that, as they are read (bounded_read.hpp).
namespace tonus::v1 {

[[nodiscard]] inline std::string out_of_bounds(const char* what, std::size_t value, std::size_t limit) {
  return std::string(what) + " is " + std::to_string(value) + ", at most " + std::to_string(limit) +
         " is allowed";
}

}  // namespace tonus::v1

#include <idl/type_bounds.hpp>
