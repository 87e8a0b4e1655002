#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "services/core/result.hpp"
#include "services/recording/json_file.hpp"
#include "services/recording/recording.hpp"

namespace tonus::recording {

/// What a column of `_motion.tsv` holds for us.
enum class Column : std::uint8_t {
  kIgnored,
  kCount0,
  kCount1,
  kForce0,
  kForce1,
  kCommanded0,
  kCommanded1,
  kLatency,
  kPhase
};

/// A column, and what one of its unit is in the unit that a recording has.
struct ColumnUse {
  Column what = Column::kIgnored;
  double scale = 1.0;
};
using Columns = std::vector<ColumnUse>;

/// One row of `_channels.tsv`.
struct Channel {
  std::string name;
  std::string component;  ///< "x", "y" or "n/a".
  std::string type;       ///< BIDS channel type.
  std::string tracked_point;
  std::string units;
};

/// Takes a `_channels.tsv` and what `_channels.json` says: chooses the channels (raw before converted), fills
/// the recording's rig, units, posture and names, and returns what each column holds. Converted channels may
/// be in mm, cm, um, deg, mN, kN, N mm, N cm, mN m or kN m, time stamps in ms or us. kInvalidArgument also
/// for a name that occurs twice, and for a channel with another `sampling_frequency` than the recording's
/// `nominal`.
[[nodiscard]] Result<Columns> read_channels(const std::filesystem::path& table_file, const JsonFile& json,
                                            Recording& recording, double nominal);

/// The channels that a recording is written with, in the order of its columns.
[[nodiscard]] std::vector<Channel> channels_of(const Recording& recording, bool with_converted);

/// Content of `_channels.tsv`.
[[nodiscard]] std::string channels_text(const std::vector<Channel>& channels);

/// Content of `_channels.json`: rig, shoulder, posture.
[[nodiscard]] std::string channels_json(const Recording& recording);

}  // namespace tonus::recording
