#pragma once

#include <atomic>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "services/bus/typed.hpp"
#include "services/core/clock.hpp"
#include "services/dashboard/gateway/inbox.hpp"
#include "services/dashboard/gateway/operator_desk.hpp"
#include "services/runtime/rig_stop.hpp"

#include <idl/rig.h>
#include <idl/session.h>

namespace tonus::dashboard {

/// The operators' desk on the bus, in a thread of its own: writing a command may wait, and nobody else shall.
/// Stops go over a bus and from a thread of their own besides, which no other request can hold up.
class DeskThread {
 public:
  /// `stop_bus` is not shared with anything else.
  [[nodiscard]] static Result<std::unique_ptr<DeskThread>> start(bus::Bus& bus,
                                                                 std::unique_ptr<bus::Bus> stop_bus,
                                                                 Inbox& inbox, const Clock& clock);
  ~DeskThread();

  /// From any thread; does not wait.
  void ask(OperatorRequest request);

 private:
  struct Endpoints {
    bus::TypedWriter<v1::SessionCommand> session_commands;
    bus::TypedWriter<v1::RigCommand> rig_commands;
    bus::TypedReader<v1::SessionReply> session_replies;
    bus::TypedReader<v1::RigReply> rig_replies;
  };
  DeskThread(Endpoints endpoints, runtime::RigStopSender stops, std::shared_ptr<bus::Notifier> notifier,
             Inbox& inbox, const Clock& clock);
  void run();
  void run_stops();
  void carry_out(OperatorDesk::Effects effects);
  template <typename Reply>
  void hear(bus::TypedReader<Reply>& replies);

  Endpoints endpoints_;
  std::shared_ptr<bus::Notifier> notifier_;
  Inbox& inbox_;
  OperatorDesk desk_;
  std::mutex mutex_;
  std::vector<OperatorRequest> asked_;
  runtime::RigStopSender stops_;
  bus::Notifier stop_asked_;
  std::vector<OperatorRequest> asked_stops_;
  std::atomic<bool> is_ending_{false};
  std::thread thread_;
  std::thread stop_thread_;
};

}  // namespace tonus::dashboard
