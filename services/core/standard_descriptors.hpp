#pragma once

#include "services/core/result.hpp"

namespace tonus {

/// Opens /dev/null on those of the descriptors 0 to 2 that are closed. Call it before anything is opened:
/// else a data file may get one of these numbers, and what is written to the log overwrites it.
void occupy_standard_descriptors();

/// Hands what was printed to the operating system. kIo: not all of it could be written, now or before.
[[nodiscard]] Result<void> finish_standard_output();

}  // namespace tonus
