#pragma once

#include <string>

#include "services/core/result.hpp"

namespace tonus::protocol {

/// Where in a protocol's text a problem is, for forms that show it there.
struct Refusal {
  std::string key;      ///< From the root, "posture[2].position_m"; empty: of none.
  int line = 0;         ///< 0: of none.
  std::string message;  ///< Without source and line.
};

/// The parts of an error of parse_protocol() and of checks against a rig, whose `source` was this.
[[nodiscard]] Refusal refusal_of(const Error& error, const std::string& source);

}  // namespace tonus::protocol
