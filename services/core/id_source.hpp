#pragma once

#include <functional>

#include "services/core/id.hpp"

namespace tonus {

/// Makes ids that are never made twice: random_id, or a test's.
using IdSource = std::function<Id()>;

}  // namespace tonus
