#include "services/exchange/trial_data.hpp"

#include <algorithm>
#include <spdlog/fmt/fmt.h>

#include "idl/bounds.hpp"
#include "services/bus/typed.hpp"

namespace tonus::exchange {

Result<TrialSamples> read_all_samples(archive::Store& store, const archive::SessionTrial& trial) {
  if (!trial.record || !trial.record->has_samples) {
    return fail(ErrorCode::kNotFound,
                fmt::format("trial {}: has no samples in store '{}'", trial.attempt, store.name()));
  }
  constexpr std::uint64_t kMostSamples = 100'000'000;  // 7 hours at 4 kHz; more is damage
  const archive::SequenceRange range = trial.record->range();
  if (range.count() > kMostSamples) {
    return fail(ErrorCode::kDataLoss, fmt::format("trial {}: {} samples are not allowed: at most {}",
                                                  trial.attempt, range.count(), kMostSamples));
  }
  TrialSamples found;
  v1::RigSample none;
  none.flags(kNotMeasured);
  found.samples.assign(range.count(), none);
  found.is_there.assign(range.count(), false);
  const archive::BlockQuery query{trial.record->stream, range, true};
  const auto visited = store.visit_blocks(query, [&](const archive::Block& block) -> Result<void> {
    const auto wire = bus::decode<v1::SampleBlock>(*block.payload);
    if (!archive::check(block, store.name()) || !wire || wire->first_sequence() != block.first_sequence ||
        wire->samples().size() != block.count) {
      ++found.damaged_blocks;
      return {};
    }
    const std::uint64_t first = std::max(block.first_sequence, range.first);
    const std::uint64_t end = std::min(block.range().end, range.end);
    for (std::uint64_t number = first; number < end; ++number) {
      found.samples[number - range.first] = wire->samples()[number - block.first_sequence];
      found.is_there[number - range.first] = true;
    }
    return {};
  });
  if (!visited) return visited.error();
  found.absent = static_cast<std::uint64_t>(std::count(found.is_there.begin(), found.is_there.end(), false));
  return found;
}

Result<v1::RigDescription> description_of(const archive::Session& session,
                                          const archive::SessionTrial& trial) {
  if (session.descriptions.empty()) {
    return fail(ErrorCode::kNotFound, fmt::format("session {}: its rig's description is not in the archive",
                                                  to_hex(session.record.session)));
  }
  const v1::RigDescription* newest = &session.descriptions.front().value;
  for (const auto& description : session.descriptions) {
    if (trial.outcome && description.received_ns <= trial.outcome->received_ns) newest = &description.value;
  }
  return *newest;
}

ShoulderPose shoulder_of(const archive::SessionTrial& trial) {
  if (!trial.outcome) return {};
  const auto& program = trial.outcome->value.program();
  return {{program.shoulder_origin_m()[0], program.shoulder_origin_m()[1]}, program.shoulder_angle_rad()};
}

}  // namespace tonus::exchange
