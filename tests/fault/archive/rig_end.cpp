#include "tests/fault/archive/rig_end.hpp"

#include <utility>

#include "idl/topics.hpp"

namespace tonus::archive::testing {
namespace {

constexpr std::uint32_t kBlockSamples = 20;

}  // namespace

Result<RigEnd> RigEnd::create(MadeUpRig& rig, int domain, bus::Vendor vendor,
                              const std::shared_ptr<bus::Notifier>& notifier) {
  bus::BusOptions options;
  options.vendor = vendor;
  options.domain = domain;
  options.partition = "rig";
  options.participant_name = "made-up rig";
  auto bus = bus::create_bus(options);
  if (!bus) return bus.error();
  auto samples = bus::TypedWriter<v1::SampleBlock>::create(**bus, topics::kRigSamples);
  if (!samples) return samples.error();
  auto outcomes = bus::TypedWriter<v1::TrialOutcome>::create(**bus, topics::kTrialOutcome);
  if (!outcomes) return outcomes.error();
  auto states = bus::TypedWriter<v1::RigState>::create(**bus, topics::kRigState);
  if (!states) return states.error();
  auto receipts = bus::TypedReader<v1::ArchiveReceipt>::create(**bus, topics::kArchiveReceipt, notifier);
  if (!receipts) return receipts.error();
  auto resends = bus::TypedReader<v1::ArchiveResend>::create(**bus, topics::kArchiveResend, notifier);
  if (!resends) return resends.error();
  return RigEnd(rig, std::move(*bus), std::move(*samples), std::move(*outcomes), std::move(*states),
                std::move(*receipts), std::move(*resends));
}

RigEnd::RigEnd(MadeUpRig& rig, std::unique_ptr<bus::Bus> bus, bus::TypedWriter<v1::SampleBlock> samples,
               bus::TypedWriter<v1::TrialOutcome> outcomes, bus::TypedWriter<v1::RigState> states,
               bus::TypedReader<v1::ArchiveReceipt> receipts, bus::TypedReader<v1::ArchiveResend> resends)
    : rig_(&rig),
      bus_(std::move(bus)),
      samples_(std::move(samples)),
      outcomes_(std::move(outcomes)),
      states_(std::move(states)),
      receipts_(std::move(receipts)),
      resends_(std::move(resends)) {}

bool RigEnd::is_heard() const {
  return samples_.status().matched_readers > 0 && outcomes_.status().matched_readers > 0 &&
         states_.status().matched_readers > 0;
}

void RigEnd::run_trial() {
  const auto trial = rig_->next_trial();
  send(trial.range, false);
  static_cast<void>(outcomes_.write(rig_->outcome(trial)));
}

void RigEnd::repeat_outcomes_without_receipt() {
  for (const auto& trial : rig_->trials_without_receipt())
    static_cast<void>(outcomes_.write(rig_->outcome(trial)));
}

Result<void> RigEnd::answer() {
  static_cast<void>(states_.write(rig_->state()));
  std::vector<bus::Received<v1::ArchiveResend>> requests;
  resends_.take(requests);
  for (const auto& request : requests)
    send({request.value.first_sequence(), request.value.last_sequence() + 1}, true);
  return take_receipts();
}

Result<void> RigEnd::take_receipts() {
  std::vector<bus::Received<v1::ArchiveReceipt>> taken;
  receipts_.take(taken);
  for (const auto& receipt : taken) {
    if (auto good = rig_->receive(receipt.value); !good) return good;
  }
  return {};
}

void RigEnd::send(store::SequenceRange range, bool is_resent) {
  for (std::uint64_t first = range.first; first < range.end;) {
    const auto block = rig_->block(first, kBlockSamples, is_resent);
    if (block.samples().empty()) return;
    first += block.samples().size();
    static_cast<void>(samples_.write(block));
  }
}

}  // namespace tonus::archive::testing
