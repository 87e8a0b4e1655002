#include "services/core/lifetime.hpp"

#include <csignal>
#include <pthread.h>
#include <utility>

namespace tonus {
namespace {

sigset_t stop_signals() {
  sigset_t set;
  sigemptyset(&set);
  sigaddset(&set, SIGINT);
  sigaddset(&set, SIGTERM);
  return set;
}

}  // namespace

StopSignal::StopSignal(std::function<void()> on_stop) : on_stop_(std::move(on_stop)) {
  const sigset_t set = stop_signals();
  pthread_sigmask(SIG_BLOCK, &set, nullptr);
  waiter_ = std::thread([this, set] {
    while (true) {
      int signal = 0;
      sigwait(&set, &signal);
      if (is_ending_.load(std::memory_order_acquire)) return;  // woken by the destructor
      requests_.fetch_add(1, std::memory_order_release);
      if (on_stop_) on_stop_();
    }
  });
}

StopSignal::~StopSignal() {
  is_ending_.store(true, std::memory_order_release);
  pthread_kill(waiter_.native_handle(), SIGTERM);
  waiter_.join();
}

void unblock_stop_signals() {
  const sigset_t set = stop_signals();
  pthread_sigmask(SIG_UNBLOCK, &set, nullptr);
}

}  // namespace tonus
