#pragma once

#include <cstdint>
#include <span>

#include "rig_agent/agent/spool.hpp"
#include "rig_agent/control/sample_record.hpp"
#include "services/bus/bus.hpp"
#include "services/core/clock.hpp"
#include "services/core/id.hpp"

#include <idl/rig.h>

namespace tonus::rig {

/// Puts samples, and the values of the auxiliary channels with them, together into blocks, keeps each block
/// in the spool and then publishes it: rig/samples, and behind it rig/auxiliary with the same range. A block
/// that the bus does not take in time stays in the spool: its consumers see the gap and ask for it. One
/// thread.
class Publisher {
 public:
  struct Options {
    Id rig{};
    std::uint64_t epoch = 0;
    std::size_t auxiliary_values = 0;  ///< With each sample; 0: there are no auxiliary channels.
    std::size_t block_samples = 100;   ///< A block is closed when it has so many, or one message is full,
    std::chrono::milliseconds block_age{20};  ///< or when its first sample is so old.
    std::chrono::milliseconds patience{0};    ///< How long to try again when readers do not keep up.
  };

  /// `auxiliary` may be null where there are no auxiliary channels.
  Publisher(const Options& options, Spool& spool, std::unique_ptr<bus::Writer> samples,
            std::unique_ptr<bus::Writer> auxiliary, const Clock& clock);

  /// The trial that following samples belong to; none: kNoId twice.
  void set_trial(const Id& session, const Id& trial);

  /// `auxiliary` has Options::auxiliary_values values.
  void add(const control::SampleRecord& record, std::span<const float> auxiliary = {});

  /// Closes the open block if it is old enough.
  void flush_if_due();
  void flush();

  /// Publishes spooled samples once more, marked as resent.
  void resend(const SpooledRange& range);

  [[nodiscard]] bool has_readers() const { return samples_->status().matched_readers > 0; }
  [[nodiscard]] std::uint64_t blocks_refused() const { return blocks_refused_; }
  /// True where the last write to the spool failed: nothing new may be begun.
  [[nodiscard]] const std::string& spool_error() const { return spool_error_; }

 private:
  void keep_and_send(const Spool::Messages& messages);
  void resend(const Spool::Messages& messages);
  bool send(bus::Writer& writer, std::span<const std::byte> payload);

  Options options_;
  Spool& spool_;
  std::unique_ptr<bus::Writer> samples_;
  std::unique_ptr<bus::Writer> auxiliary_;
  const Clock& clock_;
  v1::SampleBlock block_;
  v1::AuxiliaryBlock values_;  // of the same samples
  Clock::TimePoint block_begun_;
  std::uint64_t blocks_refused_ = 0;
  std::string spool_error_;
};

}  // namespace tonus::rig
