#include "services/dashboard/gateway/desk_thread.hpp"

#include <spdlog/spdlog.h>
#include <utility>

#include "idl/topics.hpp"
#include "services/runtime/drain.hpp"

namespace tonus::dashboard {

Result<std::unique_ptr<DeskThread>> DeskThread::start(bus::Bus& bus, Inbox& inbox, const Clock& clock) {
  auto notifier = std::make_shared<bus::Notifier>();
  auto session_commands = bus::TypedWriter<v1::SessionCommand>::create(bus, topics::kSessionCommand);
  if (!session_commands) return session_commands.error();
  auto rig_commands = bus::TypedWriter<v1::RigCommand>::create(bus, topics::kRigCommand);
  if (!rig_commands) return rig_commands.error();
  auto session_replies = bus::TypedReader<v1::SessionReply>::create(bus, topics::kSessionReply, notifier);
  if (!session_replies) return session_replies.error();
  auto rig_replies = bus::TypedReader<v1::RigReply>::create(bus, topics::kRigReply, notifier);
  if (!rig_replies) return rig_replies.error();
  return std::unique_ptr<DeskThread>(new DeskThread({std::move(*session_commands), std::move(*rig_commands),
                                                     std::move(*session_replies), std::move(*rig_replies)},
                                                    std::move(notifier), inbox, clock));
}

DeskThread::DeskThread(Endpoints endpoints, std::shared_ptr<bus::Notifier> notifier, Inbox& inbox,
                       const Clock& clock)
    : endpoints_(std::move(endpoints)),
      notifier_(std::move(notifier)),
      inbox_(inbox),
      desk_({}, clock),
      thread_([this] { run(); }) {}

DeskThread::~DeskThread() {
  is_ending_.store(true, std::memory_order_relaxed);  // the notifier's lock orders it
  notifier_->notify();
  thread_.join();
}

void DeskThread::ask(OperatorRequest request) {
  {
    const std::lock_guard lock(mutex_);
    asked_.push_back(std::move(request));
  }
  notifier_->notify();
}

void DeskThread::run() {
  while (!is_ending_.load(std::memory_order_relaxed)) {
    std::vector<OperatorRequest> asked;
    {
      const std::lock_guard lock(mutex_);
      asked = std::exchange(asked_, {});
    }
    for (auto& request : asked) {
      spdlog::info("{} asks for {}", request.requested_by, request.name);
      carry_out(desk_.ask(std::move(request)));
    }
    hear(endpoints_.rig_replies);
    hear(endpoints_.session_replies);
    carry_out(desk_.tick());
    (void)notifier_->wait_until(desk_.due());
  }
}

template <typename Reply>
void DeskThread::hear(bus::TypedReader<Reply>& replies) {
  for (const auto& received : runtime::drain(replies)) {
    carry_out(
        desk_.on_reply(received.value.request_id(), received.value.is_done(), received.value.message()));
  }
}

void DeskThread::carry_out(OperatorDesk::Effects effects) {
  for (const OperatorCommand& command : effects.commands) {
    const auto* rig = std::get_if<v1::RigCommand>(&command);
    const auto sent = rig != nullptr
                          ? endpoints_.rig_commands.write(*rig)
                          : endpoints_.session_commands.write(std::get<v1::SessionCommand>(command));
    // It is sent again until it is answered or its time is over.
    if (!sent) spdlog::warn("a request was not sent: {}", sent.error().message);
  }
  for (auto& reply : effects.replies) inbox_.put(std::move(reply));
}

}  // namespace tonus::dashboard
