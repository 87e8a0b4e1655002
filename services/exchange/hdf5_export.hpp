#pragma once

#include <filesystem>

#include "services/archive/session_reader.hpp"
#include "services/core/result.hpp"
#include "services/exchange/progress.hpp"

namespace tonus::exchange {

/// Writes a session as one HDF5 file; the unit of each dataset is its attribute `units`, its meaning
/// `description`.
///
///     /                 attributes: format, session_id, subject, protocol_name, protocol_toml, seed, ...
///     /rig              attributes: the constants that convert counts and volts, names with units
///     /trials/0001/     attributes: what was to be done, verdict, certificate; datasets of one row a sample:
///                       time, acquisition, phase, flags, encoder, force_raw, endpoint, force, commanded
///     /estimates/001/   attributes: condition, method, model, status, figures of the fit; datasets M, B, K,
///     X0,
///                       each with _standard_error, _low95 and _high95
///
/// Where a sample was not measured stand NaN. Errors as export_csv().
[[nodiscard]] Result<void> export_hdf5(archive::Store& store, const archive::Session& session,
                                       const std::filesystem::path& file, const Progress& progress = {});

}  // namespace tonus::exchange
