#pragma once

#include <array>
#include <string_view>

namespace tonus::dashboard {

/// The contract's .idl files, whole, as the build found them; each is self-contained.
extern const std::array<std::string_view, 6> kIdlTexts;

}  // namespace tonus::dashboard
