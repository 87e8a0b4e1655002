#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

#include "services/core/result.hpp"

namespace tonus {

/// Name of a thing on the bus: 16 bytes, all zero for "none".
using Id = std::array<std::uint8_t, 16>;

inline constexpr Id kNoId{};

/// 128 random bits from the operating system.
[[nodiscard]] Id random_id();

/// The same id for the same text, different for different texts (first 16 bytes of two 64-bit FNV-1a
/// hashes): what lets a restarted service, rig or estimate take its place again without asking anybody.
[[nodiscard]] Id id_of(std::string_view text);

/// Id of an attempt in a session: unique in the session, and the same after a scheduler's restart.
[[nodiscard]] Id trial_id(const Id& session, std::uint32_t attempt);

/// 32 lower-case hexadecimal digits.
[[nodiscard]] std::string to_hex(const Id& id);

/// Inverse of to_hex; also takes hyphens between digits.
[[nodiscard]] Result<Id> id_from_hex(std::string_view text);

}  // namespace tonus
