#pragma once

#include <string>
#include <vector>

#include "tests/support/made_up_trial/made_up_trial.hpp"

#include <idl/rig.h>
#include <idl/session.h>
#include <idl/trial.h>

/// What a rig that measures made-up trials, and its scheduler, say on the bus.
namespace tonus::identification::testing {

/// The trial as one of the rig and session of these names.
[[nodiscard]] MeasuredTrial as_of(MeasuredTrial trial, const std::string& rig, const Id& session);

[[nodiscard]] v1::RigDescription description_of(const std::string& rig);
[[nodiscard]] v1::SessionPlan plan_of(const std::string& rig, const Id& session,
                                      const std::string& started_at);
[[nodiscard]] v1::TrialCommand command_of(const MeasuredTrial& trial);
/// In blocks of so many rows.
[[nodiscard]] std::vector<v1::SampleBlock> messages_of(const MeasuredTrial& trial, std::size_t rows_a_block);
[[nodiscard]] v1::TrialOutcome outcome_of(const MeasuredTrial& trial);

}  // namespace tonus::identification::testing
