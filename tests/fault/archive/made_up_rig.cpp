#include "tests/fault/archive/made_up_rig.hpp"

#include <algorithm>
#include <spdlog/fmt/fmt.h>

#include "services/store/sample_reader.hpp"

namespace tonus::archive::testing {
namespace {

constexpr std::int64_t kPeriod = 250'000;  // ns, 4 kHz

v1::RigSample sample_at(std::uint64_t sequence) {
  v1::RigSample sample;
  const auto n = static_cast<double>(sequence);
  sample.acquisition_ns(static_cast<std::int64_t>(sequence) * kPeriod);
  sample.encoder_count({n, -n});
  sample.force_V({1e-6 * n, 0.5});
  return sample;
}

Error lost(const std::string& what) { return fail(ErrorCode::kDataLoss, "a receipt was given: " + what); }

}  // namespace

MadeUpRig::Trial MadeUpRig::trial_at(std::uint64_t sequence) {
  const std::uint64_t index = sequence / kTrialSamples;
  const auto attempt = static_cast<std::uint32_t>(index + 1);
  return {trial_id(session(), attempt), attempt, {index * kTrialSamples, (index + 1) * kTrialSamples}};
}

MadeUpRig::Trial MadeUpRig::next_trial() {
  const Trial trial = trial_at(next_);
  next_ = trial.range.end;
  open_[trial.attempt] = trial;
  return trial;
}

v1::SampleBlock MadeUpRig::block(std::uint64_t first, std::uint32_t most, bool is_resent) const {
  const Trial trial = trial_at(first);
  v1::SampleBlock block;
  block.rig_id(id());
  block.session_id(session());
  block.trial_id(trial.id);
  block.epoch(epoch_);
  block.first_sequence(first);
  block.is_resent(is_resent);
  for (std::uint64_t n = first; n < std::min({first + most, trial.range.end, next_}); ++n)
    block.samples().push_back(sample_at(n));
  return block;
}

v1::TrialOutcome MadeUpRig::outcome(const Trial& trial) const {
  v1::TrialOutcome outcome;
  outcome.trial_id(trial.id);
  outcome.program().session_id(session());
  outcome.program().rig_id(id());
  outcome.program().attempt(trial.attempt);
  outcome.epoch(epoch_);
  outcome.first_sequence(trial.range.first);
  outcome.last_sequence(trial.range.end - 1);
  outcome.sample_rate_Hz(4000.0);
  return outcome;
}

v1::RigState MadeUpRig::state() const {
  v1::RigState state;
  state.rig_id(id());
  state.epoch(epoch_);
  state.next_sequence(next_);
  state.received_through(through_);
  return state;
}

Result<void> MadeUpRig::receive(const v1::ArchiveReceipt& receipt) {
  if (receipt.kind() == v1::RECEIPT_SESSION) return {};
  if (receipt.epoch() != epoch_) return lost(fmt::format("for epoch {}, which never was", receipt.epoch()));
  if (receipt.through_sequence() > next_)
    return lost(fmt::format("for samples below {}, of {}", receipt.through_sequence(), next_));
  ++receipts_;
  if (receipt.kind() == v1::RECEIPT_STREAM) {
    through_ = std::max(through_, receipt.through_sequence());
    return {};
  }
  if (receipt.missing_samples() > 0) return {};  // says itself that it is not whole
  const Trial trial = trial_at(receipt.through_sequence() - 1);
  if (trial.id != receipt.subject_id()) return lost("for a trial that never was");
  open_.erase(trial.attempt);
  certified_[trial.attempt] = trial;
  return {};
}

std::vector<MadeUpRig::Trial> MadeUpRig::trials_without_receipt() const {
  std::vector<Trial> trials;
  for (const auto& [attempt, trial] : open_) trials.push_back(trial);
  return trials;
}

Result<void> MadeUpRig::check_samples(store::Store& store, store::SequenceRange range) const {
  const auto samples = store::read_samples(store, stream(), range);
  if (!samples) return lost(samples.error().message);
  for (std::uint64_t n = range.first; n < range.end; ++n) {
    if ((*samples)[n - range.first] != sample_at(n)) return lost(fmt::format("sample {} is another one", n));
  }
  return {};
}

Result<void> MadeUpRig::check(store::Store& store) const {
  if (through_ > 0) {
    if (auto whole = check_samples(store, {0, through_}); !whole) return whole;
  }
  for (const auto& [attempt, trial] : certified_) {
    const auto record = store.find_trial(trial.id);
    if (!record) return record.error();
    if (!record->has_value() || !(*record)->is_certified)
      return lost(fmt::format("trial {} is not certified", attempt));
    if (trial.range.end <= through_) continue;
    if (auto whole = check_samples(store, trial.range); !whole) return whole;
  }
  return {};
}

}  // namespace tonus::archive::testing
