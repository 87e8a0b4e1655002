#pragma once

#include <cstdint>
#include <functional>

namespace tonus::exchange {

/// Told how far a long piece of work is; may be empty.
using Progress = std::function<void(std::uint64_t done, std::uint64_t total)>;

}  // namespace tonus::exchange
