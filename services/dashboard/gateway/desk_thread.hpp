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

#include <idl/rig.h>
#include <idl/session.h>

namespace tonus::dashboard {

/// The operators' desk on the bus, in a thread of its own: writing a command may wait, and nobody else shall.
class DeskThread {
 public:
  [[nodiscard]] static Result<std::unique_ptr<DeskThread>> start(bus::Bus& bus, Inbox& inbox,
                                                                 const Clock& clock);
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
  DeskThread(Endpoints endpoints, std::shared_ptr<bus::Notifier> notifier, Inbox& inbox, const Clock& clock);
  void run();
  void carry_out(OperatorDesk::Effects effects);
  template <typename Reply>
  void hear(bus::TypedReader<Reply>& replies);

  Endpoints endpoints_;
  std::shared_ptr<bus::Notifier> notifier_;
  Inbox& inbox_;
  OperatorDesk desk_;
  std::mutex mutex_;
  std::vector<OperatorRequest> asked_;
  std::atomic<bool> is_ending_{false};
  std::thread thread_;
};

}  // namespace tonus::dashboard
