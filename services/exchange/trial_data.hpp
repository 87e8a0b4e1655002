#pragma once

#include <vector>

#include "services/archive/session_reader.hpp"
#include "services/core/result.hpp"
#include "services/core/rig_geometry.hpp"

#include <idl/rig.h>

namespace tonus::exchange {

/// RigSample::flags
inline constexpr std::uint8_t kSaturated = 1U << 0;
inline constexpr std::uint8_t kNotMeasured = 1U << 1;

/// A trial's samples in order, one for each number of its range. Where the archive has none (lost, or in a
/// damaged block) stands a sample with flag kNotMeasured.
struct TrialSamples {
  std::vector<v1::RigSample> samples;
  std::vector<bool> is_there;        ///< For each sample: the archive has it.
  std::uint64_t absent = 0;          ///< How many the archive has not.
  std::uint64_t damaged_blocks = 0;  ///< Left out.
};

/// Reads what there is. kNotFound: the trial has no samples. Other errors are the store's.
[[nodiscard]] Result<TrialSamples> read_all_samples(archive::Store& store,
                                                    const archive::SessionTrial& trial);

/// The rig description that a trial's samples are converted with: the newest when its outcome came, else the
/// session's first. kNotFound: the archive has none.
[[nodiscard]] Result<v1::RigDescription> description_of(const archive::Session& session,
                                                        const archive::SessionTrial& trial);

/// From the trial's program.
[[nodiscard]] ShoulderPose shoulder_of(const archive::SessionTrial& trial);

}  // namespace tonus::exchange
