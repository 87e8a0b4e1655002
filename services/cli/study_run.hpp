#pragma once

#include "services/cli/operator_connection.hpp"
#include "services/cli/session_run.hpp"
#include "services/cli/system.hpp"
#include "services/protocol/protocol.hpp"

namespace tonus::cli {

/// Runs every session of a study, one subject after the other, each with services of its own and the
/// simulated rig of this subject, all into one archive. `cohort` is the file of the subjects' profiles
/// (services/simulation/cohort.hpp). The first session that does not complete is the error.
[[nodiscard]] Result<void> run_study(const SystemOptions& system, const RunOptions& run,
                                     const protocol::Protocol& study, const std::string& cohort);

/// Whom `run.subject` names; kInvalidArgument lists the study's subjects.
[[nodiscard]] Result<protocol::StudySubject> study_subject(const RunOptions& run,
                                                           const protocol::Protocol& study);

/// Every session that the study of this name has for one subject, one after the other, on services that are
/// up. The first one that does not complete is the error. The sessions belong to the study, or to that of
/// run.people.study.
[[nodiscard]] Result<void> run_study_subject(OperatorConnection& op, const RunOptions& run,
                                             const std::string& study, const protocol::StudySubject& subject);

}  // namespace tonus::cli
