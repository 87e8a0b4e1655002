#pragma once

#include <algorithm>
#include <array>
#include <cstddef>

namespace tonus::control {

/// Name of what the subject is told in a trial, "stiffen_x"; empty: hold still. Of fixed size, for the loop;
/// a longer name is cut.
struct InstructionName {
  std::array<char, 48> text{};  ///< Ends with a zero.

  InstructionName() = default;
  InstructionName(const char* name, std::size_t size) noexcept {
    std::copy_n(name, std::min(size, text.size() - 1), text.begin());
  }
  [[nodiscard]] const char* c_str() const noexcept { return text.data(); }
};

}  // namespace tonus::control
