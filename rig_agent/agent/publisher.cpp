#include "rig_agent/agent/publisher.hpp"

#include <spdlog/spdlog.h>
#include <utility>

#include "idl/bounds.hpp"
#include "rig_agent/agent/wire.hpp"
#include "services/bus/typed.hpp"

namespace tonus::rig {

Publisher::Publisher(const Options& options, Spool& spool, std::unique_ptr<bus::Writer> samples,
                     const Clock& clock)
    : options_(options), spool_(spool), samples_(std::move(samples)), clock_(clock) {
  block_.rig_id(options_.rig);
  block_.epoch(options_.epoch);
  block_.samples().reserve(options_.block_samples);
}

void Publisher::set_trial(const Id& session, const Id& trial) {
  if (block_.trial_id() == trial && block_.session_id() == session) return;
  flush();
  block_.session_id(session);
  block_.trial_id(trial);
}

void Publisher::add(const control::SampleRecord& record) {
  const std::uint64_t expected = block_.first_sequence() + block_.samples().size();
  if (!block_.samples().empty() && record.sequence != expected) flush();  // the loop dropped some
  if (block_.samples().empty()) {
    block_.first_sequence(record.sequence);
    block_begun_ = clock_.now();
  }
  block_.samples().push_back(to_wire(record));
  if (block_.samples().size() >= options_.block_samples) flush();
}

void Publisher::flush_if_due() {
  if (!block_.samples().empty() && clock_.now() - block_begun_ >= options_.block_age) flush();
}

void Publisher::flush() {
  if (block_.samples().empty()) return;
  block_.send_ns(clock_.now().time_since_epoch().count());
  const auto payload = bus::encode(block_);
  if (payload) {
    const auto spooled = spool_.append(options_.epoch, block_.first_sequence(),
                                       static_cast<std::uint32_t>(block_.samples().size()), *payload);
    if (!spooled && spool_error_.empty())
      spdlog::error("samples are not spooled: {}", spooled.error().message);
    spool_error_ = spooled ? "" : spooled.error().message;
    if (!send(*payload, options_.patience)) ++blocks_refused_;
  } else {
    spdlog::error("a block cannot be encoded: {}", payload.error().message);
  }
  block_.samples().clear();
}

void Publisher::resend(const SpooledRange& range) {
  const auto outcome = spool_.read(range.epoch, range.first_sequence, range.last_sequence,
                                   [this](std::span<const std::byte> payload) {
                                     auto block = bus::decode<v1::SampleBlock>(payload);
                                     if (!block) return;
                                     block->is_resent(true);
                                     block->send_ns(clock_.now().time_since_epoch().count());
                                     (void)send(*bus::encode(*block), options_.patience);
                                   });
  if (!outcome) spdlog::error("cannot send again from the spool: {}", outcome.error().message);
}

bool Publisher::send(std::span<const std::byte> payload, std::chrono::milliseconds patience) {
  const auto give_up = clock_.now() + patience;
  while (true) {
    const auto written = samples_->write(payload);
    if (written) return true;
    if (written.error().code != ErrorCode::kTimeout || clock_.now() >= give_up) return false;
  }
}

}  // namespace tonus::rig
