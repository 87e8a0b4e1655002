#include "services/python/module/signals.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <limits>

#include "services/contract/rig.hpp"

namespace tonus::python {
namespace {

constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();

/// What a damaged archive says of its ranges takes no more memory than this before it has been read.
constexpr std::size_t kMostReserved = 20'000'000;

unsigned axes_of(const RigGeometry& rig) { return rig.kind == RigKind::kOneAxis ? 1 : 2; }

void reserve(Signals& signals, std::size_t rows) {
  signals.time.reserve(rows);
  signals.position.reserve(2 * rows);
  signals.force.reserve(2 * rows);
  signals.commanded.reserve(2 * rows);
  signals.phase.reserve(rows);
  signals.is_missing.reserve(rows);
}

/// Makes room for `rows` more, as rows that are missing.
void grow(Signals& signals, std::size_t rows) {
  const std::size_t all = signals.rows() + rows;
  signals.time.resize(all, kNothing);
  signals.position.resize(all * signals.axes, kNothing);
  signals.force.resize(all * signals.axes, kNothing);
  signals.commanded.resize(all * signals.axes, kNothing);
  signals.phase.resize(all, 0);
  signals.is_missing.resize(all, 1);
}

void put(Signals& signals, std::size_t row, const EndpointSample& sample,
         const std::array<double, 2>& commanded) {
  signals.is_missing[row] = 0;
  for (unsigned axis = 0; axis < signals.axes; ++axis) {
    const std::size_t i = row * signals.axes + axis;
    signals.position[i] = sample.p_SE[axis];
    signals.force[i] = sample.f_S[axis];
    signals.commanded[i] = commanded[axis];
  }
}

/// Appends a trial's rows.
Result<TrialRows> append(store::Store& store, const store::Session& session, const store::SessionTrial& trial,
                         SessionSignals& all) {
  Signals& signals = all.signals;
  TrialRows place;
  place.attempt = trial.attempt;
  place.first = signals.rows();
  if (!trial.outcome || !trial.record || !trial.record->has_samples) return place;
  TONUS_TRY_ASSIGN(const auto rig, store::rig_in_force(session, trial));
  TONUS_TRY_ASSIGN(const auto found, store::read_trial_samples(store, trial));
  if (signals.rows() == 0) signals.axes = axes_of(rig.geometry);
  if (signals.axes != axes_of(rig.geometry)) {
    return fail(ErrorCode::kInvalidArgument, "trial " + std::to_string(trial.attempt) + ": axes " +
                                                 std::to_string(axes_of(rig.geometry)) +
                                                 " are not allowed; expected " +
                                                 std::to_string(signals.axes) + " as the trials before it");
  }
  const v1::TrialOutcome& outcome = trial.outcome->value;
  grow(signals, found.samples.size());
  for (std::size_t i = 0; i < found.samples.size(); ++i) {
    const std::size_t row = place.first + i;
    const auto after_onset =
        static_cast<std::int64_t>(outcome.first_sequence() + i - outcome.onset_sequence());
    signals.time[row] = static_cast<double>(after_onset) / outcome.sample_rate_Hz();
    const v1::RigSample& sample = found.samples[i];
    signals.phase[row] = sample.phase();
    if (contract::flags_of(sample).is_missing) continue;
    put(signals, row, convert(rig.geometry, rig.shoulder, store::raw_of(sample)), sample.commanded_m());
  }
  place.rows = found.samples.size();
  place.onset = static_cast<std::int64_t>(outcome.onset_sequence() - outcome.first_sequence());
  return place;
}

}  // namespace

Signals signals_of(const recording::Recording& record) {
  Signals signals;
  signals.axes = axes_of(record.rig);
  grow(signals, record.rows.size());
  for (std::size_t row = 0; row < record.rows.size(); ++row) {
    signals.time[row] = static_cast<double>(row) / record.sampling_frequency;
    if (!record.phases.empty()) signals.phase[row] = record.phases[row];
    if (record.rows[row].is_missing) continue;
    const auto commanded = record.commanded.empty() ? std::array{kNothing, kNothing} : record.commanded[row];
    put(signals, row, convert(record.rig, record.shoulder, record.rows[row].raw), commanded);
  }
  return signals;
}

Result<SessionSignals> read_signals(store::Store& store, const store::Session& session,
                                    const std::vector<const store::SessionTrial*>& trials) {
  SessionSignals all;
  std::size_t rows = 0;
  for (const store::SessionTrial* trial : trials) {
    if (trial->record) rows += std::min<std::size_t>(trial->record->range().count(), kMostReserved);
  }
  reserve(all.signals, std::min(rows, kMostReserved));
  for (const store::SessionTrial* trial : trials) {
    TONUS_TRY_ASSIGN(const auto place, append(store, session, *trial, all));
    all.trials.push_back(place);
  }
  return all;
}

Result<TrialAuxiliary> read_auxiliary(store::Store& store, const store::Session& session,
                                      const store::SessionTrial& trial) {
  TrialAuxiliary found;
  if (!trial.outcome || !trial.record || !trial.record->has_samples) return found;
  TONUS_TRY_ASSIGN(const auto rig, store::rig_in_force(session, trial));
  TONUS_TRY_ASSIGN(found.series, store::read_trial_auxiliary(store, trial, rig.description));
  const v1::TrialOutcome& outcome = trial.outcome->value;
  found.first_sample_time =
      static_cast<double>(static_cast<std::int64_t>(outcome.first_sequence() - outcome.onset_sequence())) /
      outcome.sample_rate_Hz();
  return found;
}

}  // namespace tonus::python
