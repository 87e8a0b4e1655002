#pragma once

namespace tonus::bus {

/// Takes out of this process's environment, and so out of its children's, what Fast DDS and Cyclone DDS would
/// read there: servers to ask, files of profiles, statistics, whole configurations. What other programs of a
/// machine need must not lead tonus off loopback or to another discovery. Fast DDS's file of profiles in the
/// working folder is turned off as well. create_bus() calls it; the first call precedes the program's
/// threads, later ones find nothing to change.
void ignore_vendor_environment();

}  // namespace tonus::bus
