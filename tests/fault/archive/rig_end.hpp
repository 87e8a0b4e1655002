#pragma once

#include <memory>

#include "services/bus/bus.hpp"
#include "services/bus/typed.hpp"
#include "tests/fault/archive/made_up_rig.hpp"

#include <idl/archive.h>
#include <idl/rig.h>
#include <idl/trial.h>

namespace tonus::archive::testing {

/// A MadeUpRig's end of a real bus. What the bus refuses is asked for again by the archive.
class RigEnd {
 public:
  /// `rig` must live longer.
  static Result<RigEnd> create(MadeUpRig& rig, int domain, bus::Vendor vendor,
                               const std::shared_ptr<bus::Notifier>& notifier);

  /// True as soon as an archive hears everything that this rig says.
  [[nodiscard]] bool is_heard() const;

  void run_trial();
  void repeat_outcomes_without_receipt();

  /// Says how the rig is, sends again what is asked for, and takes the receipts that have come.
  [[nodiscard]] Result<void> answer();
  [[nodiscard]] Result<void> take_receipts();

  [[nodiscard]] bus::Bus& bus() { return *bus_; }

 private:
  RigEnd(MadeUpRig& rig, std::unique_ptr<bus::Bus> bus, bus::TypedWriter<v1::SampleBlock> samples,
         bus::TypedWriter<v1::TrialOutcome> outcomes, bus::TypedWriter<v1::RigState> states,
         bus::TypedReader<v1::ArchiveReceipt> receipts, bus::TypedReader<v1::ArchiveResend> resends);
  void send(store::SequenceRange range, bool is_resent);

  MadeUpRig* rig_;
  std::unique_ptr<bus::Bus> bus_;
  bus::TypedWriter<v1::SampleBlock> samples_;
  bus::TypedWriter<v1::TrialOutcome> outcomes_;
  bus::TypedWriter<v1::RigState> states_;
  bus::TypedReader<v1::ArchiveReceipt> receipts_;
  bus::TypedReader<v1::ArchiveResend> resends_;
};

}  // namespace tonus::archive::testing
