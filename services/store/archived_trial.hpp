#pragma once

#include <cstdint>
#include <vector>

#include "services/core/result.hpp"
#include "services/mechanics/auxiliary_series.hpp"
#include "services/mechanics/rig_geometry.hpp"
#include "services/store/session_reader.hpp"

#include <idl/rig.h>

/// An archived trial: its samples, and the rig that they were measured with. Whatever converts, exports,
/// identifies or checks archived trials begins here.
namespace tonus::store {

/// The measured values of a sample.
[[nodiscard]] inline RawSample raw_of(const v1::RigSample& wire) {
  return {wire.acquisition_ns(), wire.encoder_count(), wire.force_V()};
}

/// A trial's samples in order, one for each number of its range. Where the archive has none (lost, or in a
/// damaged block) stands a sample that is flagged as missing. Of a sample that is there twice the block with
/// the smaller first number counts.
struct TrialSamples {
  std::vector<v1::RigSample> samples;
  std::vector<bool> is_there;        ///< For each sample: the archive has it.
  std::uint64_t absent = 0;          ///< How many the archive does not have.
  std::uint64_t damaged_blocks = 0;  ///< Left out.
};

/// Reads what there is. kNotFound: the trial has no samples (it never began, or is still running). kDataLoss:
/// its range cannot be. Other errors are the store's.
[[nodiscard]] Result<TrialSamples> read_trial_samples(Store& store, const SessionTrial& trial);

/// What the auxiliary channels that `rig` describes gave during the trial's samples, each in its unit on its
/// own time axis, which begins with the trial's first sample. NaN where the archive has nothing. Empty where
/// the rig describes none. Errors as read_trial_samples(); kInvalidArgument: channels that cannot be.
[[nodiscard]] Result<std::vector<AuxiliarySeries>> read_trial_auxiliary(Store& store,
                                                                        const SessionTrial& trial,
                                                                        const v1::RigDescription& rig);

/// What converts a trial's samples to displacement and force (services/mechanics/rig_geometry.hpp).
struct TrialRig {
  v1::RigDescription description;  ///< In force when the trial's outcome came, else the session's first.
  RigGeometry geometry;            ///< The description's constants.
  ShoulderPose shoulder;           ///< Of the trial's program.
};

/// `force_sign` (+1 or -1) turns the force of a one-axis rig and leaves others alone, as the option of the
/// identification service does; recorded_force_sign() is that of the service that was there. kNotFound: the
/// archive has no description of the session's rig. kInvalidArgument: it cannot be converted with.
[[nodiscard]] Result<TrialRig> rig_in_force(const Session& session, const SessionTrial& trial,
                                            double force_sign = 1.0);

/// The force sign that the session's identification service was started with, from its newest archived
/// configuration that states one; else +1.
[[nodiscard]] double recorded_force_sign(const Session& session);

}  // namespace tonus::store
