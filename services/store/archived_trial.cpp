#include "services/store/archived_trial.hpp"

#include <algorithm>
#include <cmath>
#include <span>
#include <spdlog/fmt/fmt.h>

#include "services/config/toml_text.hpp"
#include "services/contract/rig.hpp"
#include "services/store/sample_reader.hpp"

namespace tonus::store {
namespace {

/// 7 hours at 4 kHz; more is damage.
constexpr std::uint64_t kMostSamples = 100'000'000;

/// Puts the block's samples where none are yet.
void fill(const v1::SampleBlock& block, SequenceRange range, TrialSamples& trial) {
  const std::uint64_t first = std::max(block.first_sequence(), range.first);
  const std::uint64_t end = std::min(block.first_sequence() + block.samples().size(), range.end);
  for (std::uint64_t number = first; number < end; ++number) {
    if (trial.is_there[number - range.first]) continue;
    trial.samples[number - range.first] = block.samples()[number - block.first_sequence()];
    trial.is_there[number - range.first] = true;
  }
}

/// The samples of a trial that may be read.
Result<SequenceRange> range_of(const Store& store, const SessionTrial& trial) {
  if (!trial.record || !trial.record->has_samples) {
    return fail(ErrorCode::kNotFound,
                fmt::format("trial {}: store '{}' has no samples of it", trial.attempt, store.name()));
  }
  const SequenceRange range = trial.record->range();
  if (range.count() > kMostSamples) {
    return fail(ErrorCode::kDataLoss, fmt::format("trial {}: {} samples are not allowed; expected at most {}",
                                                  trial.attempt, range.count(), kMostSamples));
  }
  return range;
}

/// Puts the block's values where none are yet; `total` values belong to each sample.
void fill(const v1::AuxiliaryBlock& block, SequenceRange range, std::size_t total,
          std::vector<AuxiliarySeries>& series) {
  const std::uint64_t first = std::max(block.first_sequence(), range.first);
  const std::uint64_t end = std::min(block.first_sequence() + block.sample_count(), range.end);
  const std::span values(block.values());
  for (std::uint64_t number = first; number < end; ++number)
    put_values(values.subspan((number - block.first_sequence()) * total, total), number - range.first,
               series);
}

}  // namespace

Result<TrialSamples> read_trial_samples(Store& store, const SessionTrial& trial) {
  TONUS_TRY_ASSIGN(const auto range, range_of(store, trial));
  TrialSamples found;
  v1::RigSample none;
  contract::put_flags({.is_missing = true}, none);
  found.samples.assign(range.count(), none);
  found.is_there.assign(range.count(), false);
  TONUS_TRY(store.visit_blocks({trial.record->stream, range, true}, [&](const Block& block) -> Result<void> {
    const auto wire = decode_block(block);
    if (wire && check(block, store.name())) {
      fill(*wire, range, found);
    } else {
      ++found.damaged_blocks;
    }
    return {};
  }));
  found.absent = static_cast<std::uint64_t>(std::count(found.is_there.begin(), found.is_there.end(), false));
  return found;
}

Result<std::vector<AuxiliarySeries>> read_trial_auxiliary(Store& store, const SessionTrial& trial,
                                                          const v1::RigDescription& rig) {
  TONUS_TRY_ASSIGN(const auto channels, contract::auxiliary_channels_of(rig));
  if (channels.empty()) return std::vector<AuxiliarySeries>();
  TONUS_TRY_ASSIGN(const auto range, range_of(store, trial));
  const double rate = rig.sample_rate_Hz();
  const std::size_t total = values_per_sample(channels, rate);
  auto series = empty_series(channels, rate, range.count());
  const BlockQuery query{trial.record->stream, range, true, true};
  TONUS_TRY(store.visit_blocks(query, [&](const Block& block) -> Result<void> {
    const auto wire = decode_auxiliary_block(block);
    const bool is_whole =
        wire && check(block, store.name()) && wire->values().size() == total * wire->sample_count();
    if (is_whole) fill(*wire, range, total, series);
    return {};
  }));
  return series;
}

Result<TrialRig> rig_in_force(const Session& session, const SessionTrial& trial, double force_sign) {
  if (session.descriptions.empty()) {
    return fail(ErrorCode::kNotFound, fmt::format("session {}: its rig's description is not in the archive",
                                                  to_hex(session.record.session)));
  }
  TrialRig rig;
  const v1::RigDescription* newest = &session.descriptions.front().value;
  for (const auto& description : session.descriptions) {
    if (trial.outcome && description.received_ns <= trial.outcome->received_ns) newest = &description.value;
  }
  rig.description = *newest;
  TONUS_TRY_ASSIGN(rig.geometry, contract::geometry_of(rig.description));
  if (rig.geometry.kind == RigKind::kOneAxis) rig.geometry.force_calibration *= force_sign;
  if (trial.outcome) {
    rig.shoulder = contract::shoulder_of(trial.outcome->value.program());
  }
  return rig;
}

double recorded_force_sign(const Session& session) {
  for (auto c = session.configurations.rbegin(); c != session.configurations.rend(); ++c) {
    if (c->value.role() != v1::ROLE_IDENTIFICATION) continue;
    const auto settings = config::parse_toml(c->value.configuration_toml(), "configuration");
    if (!settings) continue;
    if (const auto sign = (*settings)["force-sign"].value<double>(); sign && std::abs(*sign) == 1.0)
      return *sign;
  }
  return 1.0;
}

}  // namespace tonus::store
