#pragma once

#include <cstdint>
#include <functional>

namespace tonus {

/// Called with how much of a long piece of work is done; may be empty.
using Progress = std::function<void(std::uint64_t done, std::uint64_t total)>;

}  // namespace tonus
