#include "rig_agent/agent/publisher.hpp"

#include <algorithm>
#include <spdlog/spdlog.h>
#include <utility>

#include "idl/bounds.hpp"
#include "rig_agent/agent/wire.hpp"
#include "services/bus/typed.hpp"
#include "services/contract/block_bounds.hpp"

namespace tonus::rig {

Publisher::Publisher(const Options& options, Spool& spool, std::unique_ptr<bus::Writer> samples,
                     std::unique_ptr<bus::Writer> auxiliary, const Clock& clock)
    : options_(options),
      spool_(spool),
      samples_(std::move(samples)),
      auxiliary_(std::move(auxiliary)),
      clock_(clock) {
  if (options_.auxiliary_values > 0)
    options_.block_samples =
        std::min(options_.block_samples, contract::kMostAuxiliaryValues / options_.auxiliary_values);
  block_.rig_id(options_.rig);
  block_.epoch(options_.epoch);
  block_.samples().reserve(options_.block_samples);
  values_.rig_id(options_.rig);
  values_.epoch(options_.epoch);
  values_.values().reserve(options_.block_samples * options_.auxiliary_values);
}

void Publisher::set_trial(const Id& session, const Id& trial) {
  if (block_.trial_id() == trial && block_.session_id() == session) return;
  flush();
  block_.session_id(session);
  block_.trial_id(trial);
}

void Publisher::add(const control::SampleRecord& record, std::span<const float> auxiliary) {
  const std::uint64_t expected = block_.first_sequence() + block_.samples().size();
  if (!block_.samples().empty() && record.sequence != expected) flush();  // the loop dropped some
  if (block_.samples().empty()) {
    block_.first_sequence(record.sequence);
    block_begun_ = clock_.now();
  }
  block_.samples().push_back(to_wire(record));
  values_.values().insert(values_.values().end(), auxiliary.begin(), auxiliary.end());
  if (block_.samples().size() >= options_.block_samples) flush();
}

void Publisher::flush_if_due() {
  if (!block_.samples().empty() && clock_.now() - block_begun_ >= options_.block_age) flush();
}

void Publisher::flush() {
  if (block_.samples().empty()) return;
  block_.send_ns(clock_.now().time_since_epoch().count());
  values_.session_id(block_.session_id());
  values_.trial_id(block_.trial_id());
  values_.first_sequence(block_.first_sequence());
  values_.sample_count(static_cast<std::uint32_t>(block_.samples().size()));
  const auto samples = bus::encode(block_);
  const auto values = options_.auxiliary_values > 0
                          ? bus::encode(values_)
                          : Result<std::vector<std::byte>>(std::vector<std::byte>());
  if (samples && values) {
    keep_and_send({*samples, *values});
  } else {
    spdlog::error("a block cannot be encoded: {}", (samples ? values : samples).error().message);
  }
  block_.samples().clear();
  values_.values().clear();
}

void Publisher::keep_and_send(const Spool::Messages& messages) {
  const auto spooled = spool_.append(options_.epoch, block_.first_sequence(),
                                     static_cast<std::uint32_t>(block_.samples().size()), messages);
  if (!spooled && spool_error_.empty()) spdlog::error("samples are not spooled: {}", spooled.error().message);
  spool_error_ = spooled ? "" : spooled.error().message;
  if (!send(*samples_, messages.samples)) ++blocks_refused_;
  if (!messages.auxiliary.empty() && !send(*auxiliary_, messages.auxiliary)) ++blocks_refused_;
}

void Publisher::resend(const SpooledRange& range) {
  const auto outcome = spool_.read(range.epoch, range.first_sequence, range.last_sequence,
                                   [this](const Spool::Messages& messages) { resend(messages); });
  if (!outcome) spdlog::error("cannot send again from the spool: {}", outcome.error().message);
}

// An earlier run of the agent may have had auxiliary channels that this one has not.
void Publisher::resend(const Spool::Messages& messages) {
  auto block = bus::decode<v1::SampleBlock>(messages.samples);
  if (!block) return;
  block->is_resent(true);
  block->send_ns(clock_.now().time_since_epoch().count());
  (void)send(*samples_, *bus::encode(*block));
  if (messages.auxiliary.empty() || !auxiliary_) return;
  auto values = bus::decode<v1::AuxiliaryBlock>(messages.auxiliary);
  if (!values) return;
  values->is_resent(true);
  (void)send(*auxiliary_, *bus::encode(*values));
}

bool Publisher::send(bus::Writer& writer, std::span<const std::byte> payload) {
  const auto give_up = clock_.now() + options_.patience;
  while (true) {
    const auto written = writer.write(payload);
    if (written) return true;
    if (written.error().code != ErrorCode::kTimeout || clock_.now() >= give_up) return false;
  }
}

}  // namespace tonus::rig
