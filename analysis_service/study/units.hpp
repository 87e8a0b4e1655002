#pragma once

#include <numbers>

/// From SI to what people read.
namespace tonus::study {

inline constexpr double kDegrees = 180.0 / std::numbers::pi;  ///< In a rad.
inline constexpr double kMillimetres = 1e3;                   ///< In a m.

}  // namespace tonus::study
