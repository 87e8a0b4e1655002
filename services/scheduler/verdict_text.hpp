#pragma once

#include <string>

#include <idl/trial.h>

namespace tonus::scheduler {

/// Why a verdict is not valid, for a person: its reasons and its detail.
[[nodiscard]] std::string verdict_text(const v1::TrialVerdict& verdict);

/// True where a verdict's reasons may lie in the carrying of the samples, not in what was measured.
[[nodiscard]] bool may_be_lost_on_the_way(const v1::TrialVerdict& verdict);

}  // namespace tonus::scheduler
