#pragma once

#include <string>
#include <vector>

#include "analysis_service/impedance/options.hpp"
#include "analysis_service/offline/offline.hpp"
#include "services/store/store.hpp"

namespace tonus::identification {

/// What a person asks to have identified: `tonus identify` and Python's identify() are this.
struct Request {
  std::string method{impedance::kAutomatic};  ///< A name of options.hpp, auto, or all.
  std::string model = "linear";               ///< A name of options.hpp, or all.
  impedance::Options settings;                ///< Window, cutoff, filter: of every analysis.
};

/// Every combination of the methods and models asked for. kInvalidArgument names a method or model that does
/// not exist.
[[nodiscard]] Result<std::vector<impedance::Options>> analyses_of(const Request& request);

/// An archived session: `wanted` as store::find_session() takes it, its trials judged by `judge` where no
/// verdict is archived. Errors: those of reading, and of options
/// that the session's sample rate does not allow.
[[nodiscard]] Result<std::vector<OfflineEstimate>> identify_archived(
    store::Store& store, const std::string& wanted, const std::vector<impedance::Options>& analyses,
    const JudgeChoice& judge = {});

}  // namespace tonus::identification
