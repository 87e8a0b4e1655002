#pragma once

#include <filesystem>

#include "services/core/progress.hpp"
#include "services/core/result.hpp"
#include "services/store/session_reader.hpp"

namespace tonus::formats {

/// Writes a session as one HDF5 file; the unit of each dataset is its attribute `units`, its meaning
/// `description`.
///
/// - `/`, attributes: format, session_id, subject, protocol_name, protocol_toml, seed, ...
/// - `/rig`, attributes and datasets: the constants that convert counts and volts, names with units
/// - `/trials/0001`, attributes: what was planned, verdict, certificate; datasets of one row a sample: time,
///   acquisition, phase, flags, encoder, force_raw, endpoint, force, commanded
/// - `/estimates/001`, attributes: condition, method, model, status, figures of the fit; datasets:
///   M, B, K, each with _standard_error, _low95 and _high95; X0 and X0_standard_error; sigma
///
/// - `/notes/001`, attributes: kind, text, name, the rig's clock; attempt 0: about no trial
///
/// NaN stands where a sample was not measured. Errors as export_csv(); a failure leaves nothing.
[[nodiscard]] Result<void> export_hdf5(store::Store& store, const store::Session& session,
                                       const std::filesystem::path& file, const Progress& progress = {});

}  // namespace tonus::formats
