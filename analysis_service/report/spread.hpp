#pragma once

#include <string>
#include <vector>

#include "analysis_service/study/study.hpp"

namespace tonus::report {

/// How many entries of one of the paper's tables lie within the published spread of the cohort's truth.
struct EntriesWithin {
  std::string table;  ///< Its number: "I", "III", "IV".
  int inside = 0;
  int all = 0;
  std::string outside{};  ///< The others, each with its truth and spread; empty: none.
};

/// Tables I, III and IV, in this order; see spread_table().
[[nodiscard]] std::vector<EntriesWithin> entries_within_spread(const study::Study& study);

}  // namespace tonus::report
