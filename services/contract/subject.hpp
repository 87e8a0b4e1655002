#pragma once

#include <idl/session.h>

namespace tonus::contract {

/// A subject of whom nothing is known: empty texts, numbers that are not finite.
[[nodiscard]] v1::SubjectFacts unknown_subject();

}  // namespace tonus::contract
