#pragma once

#include "services/core/result.hpp"
#include "services/store/records.hpp"

#include <idl/session.h>
#include <idl/trial.h>

/// Records that are made from what a message says, so that whoever has the messages has the records too: the
/// archive as they come, the import, and the recovery of a damaged file. Pure.
namespace tonus::store {

/// kInvalidArgument: a range of samples that cannot be. Without a certificate.
[[nodiscard]] Result<TrialRecord> to_record(const v1::TrialOutcome& wire);

[[nodiscard]] SessionRecord to_record(const v1::SessionPlan& wire);

}  // namespace tonus::store
