#pragma once

#include <functional>
#include <set>
#include <string>
#include <string_view>

namespace tonus {

using Words = std::set<std::string, std::less<>>;

/// What to say of a word that is not among the known ones: "did you mean X?" where X differs by a slip of the
/// keyboard (at most two letters, and less than half of the word), else "expected one of A, B, C".
[[nodiscard]] std::string instead_of(std::string_view word, const Words& known);

}  // namespace tonus
