#pragma once

namespace tonus {

/// Opens /dev/null on those of the descriptors 0 to 2 that are closed. Call it before anything is opened:
/// else a data file may get one of these numbers, and what is written to the log overwrites it.
void occupy_standard_descriptors();

}  // namespace tonus
