#pragma once

#include <limits>
#include <map>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "analysis_service/muscles/emg.hpp"
#include "services/core/id.hpp"
#include "services/mechanics/auxiliary_series.hpp"

namespace tonus::muscles {

/// What a protocol says of muscles.
struct MuscleSettings {
  /// Largest mean before the onset, as a share of the reference contraction; infinite: none. Without a
  /// reference contraction nothing is said of it.
  double most_activity = std::numeric_limits<double>::infinity();
  std::vector<std::pair<std::string, std::string>> antagonists;  ///< Names of channels.

  bool operator==(const MuscleSettings&) const = default;
};

/// One muscle in one trial: means of the rectified EMG, relative to the reference contraction or, where there
/// is none, in the channel's unit. NaN: not known.
struct Activity {
  std::string channel;
  bool is_normalised = false;
  double before_onset = 0.0;
  double short_latency = 0.0;  ///< 20 to 50 ms after the onset.
  double long_latency = 0.0;   ///< 50 to 100 ms.
};

struct TrialActivity {
  std::vector<Activity> muscles;  ///< One for each EMG channel, in the rig's order.
  double co_contraction =
      std::numeric_limits<double>::quiet_NaN();  ///< Before the onset, mean over the pairs.

  /// Those whose activity before the onset is above the limit, "biceps 0.21"; empty: none.
  [[nodiscard]] std::vector<std::string> above(double limit) const;
};

/// The levels of a session's reference contractions, by channel, and what trials show relative to them. Not
/// for use by several threads.
class Reference {
 public:
  /// A trial in which the subject contracted: of all of them the largest level of each channel counts.
  void add(const Id& trial, std::span<const AuxiliarySeries> series);
  /// That contraction does not count any more; nothing happens where it is not known.
  void withdraw(const Id& trial) { levels_.erase(trial); }
  void clear() { levels_.clear(); }

  /// The level of a channel; NaN: none was recorded.
  [[nodiscard]] double level(const std::string& channel) const;

  /// `rest` before the onset and `onset`, in s after the trial's first sample.
  [[nodiscard]] TrialActivity measure(std::span<const AuxiliarySeries> series, const Window& rest,
                                      double onset, const MuscleSettings& settings) const;

 private:
  std::map<Id, std::map<std::string, double>> levels_;  // by trial and channel
};

}  // namespace tonus::muscles
