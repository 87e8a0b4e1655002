#pragma once

#include <optional>
#include <string>
#include <vector>

#include "services/core/result.hpp"
#include "services/mechanics/auxiliary_channel.hpp"
#include "services/mechanics/rig_geometry.hpp"

#include <idl/rig.h>
#include <idl/trial.h>

/// A rig as the services describe it to each other, and what turns its raw channels into SI.
namespace tonus::contract {

/// The kind on the wire; none for a kind of a newer contract.
[[nodiscard]] std::optional<RigKind> kind_of(v1::RigKind wire);
[[nodiscard]] v1::RigKind to_wire(RigKind kind);

/// The constants of the conversion. kInvalidArgument: an unknown kind, or constants that cannot be converted
/// with (validate(RigGeometry)).
[[nodiscard]] Result<RigGeometry> geometry_of(const v1::RigDescription& description);

/// Sets the description's constants of the conversion, and nothing else of it.
void put_geometry(const RigGeometry& geometry, v1::RigDescription& description);

/// The channels beside force and motion, in the order of their values. kInvalidArgument: channels that cannot
/// be (validate(AuxiliaryChannel)).
[[nodiscard]] Result<std::vector<AuxiliaryChannel>> auxiliary_channels_of(
    const v1::RigDescription& description);

/// Sets the description's auxiliary channels; its sample rate is set already.
void put_auxiliary_channels(std::span<const AuxiliaryChannel> channels, v1::RigDescription& description);

/// Where the subject's shoulder stands for this trial.
[[nodiscard]] ShoulderPose shoulder_of(const v1::TrialProgram& program);
void put_shoulder(const ShoulderPose& shoulder, v1::TrialProgram& program);

/// Bits of RigSample.flags, as idl/rig.idl defines them.
struct SampleFlags {
  bool is_saturated = false;  ///< The sensor was at its end stop.
  bool is_missing = false;    ///< Nothing was measured in this row of a recording.
};

[[nodiscard]] SampleFlags flags_of(const v1::RigSample& sample);
void put_flags(const SampleFlags& flags, v1::RigSample& sample);

/// Units of the channels of a rig; a two-axis rig always has m and N.
struct RigUnits {
  std::string displacement = "m";
  std::string force = "N";
};

/// Units of an impedance's matrices: force over acceleration, velocity, displacement.
struct MatrixUnits {
  std::string mass = "kg";
  std::string damping = "N s/m";
  std::string stiffness = "N/m";
};

/// m and N give kg, N s/m, N/m; rad and N m give kg m2, N m s/rad, N m/rad; anything else is written out,
/// such as "V s2/m". A unit that is not stated is m or N, as in the pages (unitOf in matrices.ts);
/// tests/unit/services/contract/matrix_units.json holds both.
[[nodiscard]] MatrixUnits matrix_units(const RigUnits& units);

}  // namespace tonus::contract
