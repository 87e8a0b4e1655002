#pragma once

#include <map>
#include <string>
#include <vector>

#include "analysis_service/identification/condition_book.hpp"
#include "analysis_service/offline/offline.hpp"
#include "analysis_service/service/wire.hpp"

namespace tonus::identification {

/// The trials of one recording or archived session, those that count and those that do not, and what is
/// identified from them: a ConditionBook that also knows why trials were left out. A condition of which every
/// trial was left out has estimates too, undetermined ones. Not for use by several threads.
class OfflineBook {
 public:
  /// `owner` fills the labels of every estimate: participant, session, run.
  OfflineBook(const std::vector<impedance::Options>& analyses, OfflineEstimate owner);

  /// As ConditionBook::set_precision_led().
  void set_precision_led(bool is_precision_led) { book_.set_precision_led(is_precision_led); }

  /// A trial that counts; if the book has no room for it, it is left out.
  void add(const TrialReport& report, const impedance::Trial& trial);
  void leave_out(const TrialReport& report, std::string why);

  /// Every analysis of every condition, by posture, bias, set. `axes` are those of the rig.
  [[nodiscard]] std::vector<OfflineEstimate> identify(const RigUnits& units, int axes);

 private:
  ConditionBook book_;
  OfflineEstimate owner_;
  std::map<Condition, std::vector<LeftOut>> left_out_;  // also of single unloaded sets
};

}  // namespace tonus::identification
