#pragma once

#include <filesystem>

namespace tonus::testing {

/// Writes the protocol of a short session in real time: one posture, one perturbation in each direction, held
/// for `hold_s`; with 1.5 s a trial takes about 4 s. After `rejection_limit` rejected trials it asks the
/// operator.
void write_short_protocol(const std::filesystem::path& file, int directions, double hold_s = 1.5,
                          int rejection_limit = 8);

/// Writes a profile for a machine that others use: it holds a loop up for longer than a rig's own would, and
/// that is not what is tested. A scheduler that is silent for `command_timeout_s` ends the trial.
void write_patient_profile(const std::filesystem::path& file, double command_timeout_s = 3.0);

}  // namespace tonus::testing
