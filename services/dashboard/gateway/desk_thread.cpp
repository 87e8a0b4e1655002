#include "services/dashboard/gateway/desk_thread.hpp"

#include <spdlog/spdlog.h>
#include <utility>

#include "idl/topics.hpp"
#include "services/runtime/drain.hpp"

namespace tonus::dashboard {
namespace {

constexpr std::size_t kMostStops = 64;
constexpr std::chrono::seconds kStopLimit{3};
constexpr std::chrono::seconds kStopWait{1};

}  // namespace

Result<std::unique_ptr<DeskThread>> DeskThread::start(bus::Bus& bus, std::unique_ptr<bus::Bus> stop_bus,
                                                      Inbox& inbox, const Clock& clock) {
  TONUS_TRY_ASSIGN(auto stops, runtime::RigStopSender::create(std::move(stop_bus), clock));
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
                                                    std::move(stops), std::move(notifier), inbox, clock));
}

DeskThread::DeskThread(Endpoints endpoints, runtime::RigStopSender stops,
                       std::shared_ptr<bus::Notifier> notifier, Inbox& inbox, const Clock& clock)
    : endpoints_(std::move(endpoints)),
      notifier_(std::move(notifier)),
      inbox_(inbox),
      desk_({}, clock),
      stops_(std::move(stops)),
      thread_([this] { run(); }),
      stop_thread_([this] { run_stops(); }) {}

DeskThread::~DeskThread() {
  is_ending_.store(true, std::memory_order_relaxed);  // the notifier's lock orders it
  notifier_->notify();
  stop_asked_.notify();
  thread_.join();
  stop_thread_.join();
}

void DeskThread::ask(OperatorRequest request) {
  const auto* rig = std::get_if<v1::RigCommand>(&request.command);
  const bool is_stop = rig != nullptr && rig->request() == v1::RIG_EMERGENCY_STOP;
  {
    const std::lock_guard lock(mutex_);
    if (is_stop && asked_stops_.size() < kMostStops) asked_stops_.push_back(request);
    asked_.push_back(std::move(request));
  }
  if (is_stop) stop_asked_.notify();
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

void DeskThread::run_stops() {
  while (!is_ending_.load(std::memory_order_relaxed)) {
    std::vector<OperatorRequest> asked;
    {
      const std::lock_guard lock(mutex_);
      asked = std::exchange(asked_stops_, {});
    }
    for (const OperatorRequest& request : asked) {
      const Id rig = std::get<v1::RigCommand>(request.command).rig_id();
      if (auto took = stops_.stop(rig, request.id, request.requested_by, kStopLimit); !took)
        spdlog::error("stop by {}: {}", request.requested_by, took.error().message);
    }
    (void)stop_asked_.wait_until(std::chrono::steady_clock::now() + kStopWait);
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
