#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <variant>

#include "services/formats/csv_columns.hpp"
#include "services/store/archived_trial.hpp"

#include <idl/estimate.h>
#include <idl/rig.h>

/// What an HDF5 file of a session holds, as tables: the attributes of each group, the datasets of a trial.
namespace tonus::formats {

using AttributeValue = std::variant<std::int64_t, double, std::string>;

/// An attribute of a group that describes one Row.
template <typename Row>
struct Attribute {
  const char* name;
  AttributeValue (*value)(const Row& row);
};

/// A trial with what was found of its samples.
struct TrialGroup {
  const TrialRow row;
  std::string reason;  ///< Why it does not count.
  std::uint64_t missing_samples = 0;
};

[[nodiscard]] std::span<const Attribute<store::Session>> session_attributes();
[[nodiscard]] std::span<const Attribute<v1::RigDescription>> rig_attributes();
[[nodiscard]] std::span<const Attribute<TrialGroup>> trial_attributes();
[[nodiscard]] std::span<const Attribute<v1::Estimate>> estimate_attributes();
[[nodiscard]] std::span<const Attribute<NoteRow>> note_attributes();

/// A dataset of two real numbers a sample; NaN where nothing was measured.
struct PairDataset {
  const char* name;
  std::string (*unit)(const v1::RigDescription& rig);
  const char* description;
  std::array<double, 2> (*values)(const v1::RigSample& sample, const EndpointSample& converted);
};
[[nodiscard]] std::span<const PairDataset> pair_datasets();

}  // namespace tonus::formats
