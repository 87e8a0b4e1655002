#include "services/store/wire.hpp"

#include <spdlog/fmt/fmt.h>

namespace tonus::store {

Result<TrialRecord> to_record(const v1::TrialOutcome& wire) {
  TrialRecord record;
  record.has_samples = wire.end() != v1::TRIAL_REFUSED;
  if (record.has_samples && (wire.last_sequence() < wire.first_sequence() ||
                             wire.last_sequence() > kLargestSequence || wire.epoch() > kLargestSequence)) {
    return fail(ErrorCode::kInvalidArgument,
                fmt::format("trial/outcome of attempt {}: samples {} to {} of epoch {} are not allowed; "
                            "expected first <= last, last and epoch up to {}",
                            wire.program().attempt(), wire.first_sequence(), wire.last_sequence(),
                            wire.epoch(), kLargestSequence));
  }
  record.trial = wire.trial_id();
  record.session = wire.program().session_id();
  record.stream = {wire.program().rig_id(), wire.epoch()};
  record.attempt = wire.program().attempt();
  record.planned_index = wire.program().planned_index();
  record.posture = wire.program().posture();
  record.set = wire.program().set_number();
  record.end = wire.end();
  record.first_sequence = wire.first_sequence();
  record.onset_sequence = wire.onset_sequence();
  record.last_sequence = wire.last_sequence();
  record.sample_rate = wire.sample_rate_Hz();
  return record;
}

SessionRecord to_record(const v1::SessionPlan& wire) {
  return {wire.session_id(), wire.rig_id(),         wire.subject(),    wire.protocol_name(),
          wire.seed(),       wire.planned_trials(), wire.started_at(), wire.software_version()};
}

}  // namespace tonus::store
