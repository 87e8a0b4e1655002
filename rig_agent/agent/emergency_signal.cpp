#include "rig_agent/agent/emergency_signal.hpp"

#include <atomic>
#include <csignal>

namespace tonus::rig {
namespace {

// A signal handler gets no argument: what it acts on has to be where it can find it.
std::atomic<control::RigLoop*> stopped_loop{nullptr};
static_assert(std::atomic<control::RigLoop*>::is_always_lock_free);

void stop_loop(int) {
  if (auto* loop = stopped_loop.load(std::memory_order_acquire)) loop->emergency_stop();
}

}  // namespace

// Release pairs with the acquire in the handler: the loop is complete.
EmergencySignal::EmergencySignal(control::RigLoop& loop) {
  stopped_loop.store(&loop, std::memory_order_release);
  struct sigaction action {};
  action.sa_handler = stop_loop;
  action.sa_flags = SA_RESTART;
  sigemptyset(&action.sa_mask);
  sigaction(SIGUSR1, &action, nullptr);
}

EmergencySignal::~EmergencySignal() {
  struct sigaction action {};
  action.sa_handler = SIG_DFL;
  sigaction(SIGUSR1, &action, nullptr);
  stopped_loop.store(nullptr, std::memory_order_release);
}

}  // namespace tonus::rig
