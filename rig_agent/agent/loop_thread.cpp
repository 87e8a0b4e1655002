#include "rig_agent/agent/loop_thread.hpp"

#include <cmath>
#include <future>

namespace tonus::rig {

LoopThread::LoopThread(control::RigLoop& loop, bool is_paced, const control::RealtimeRequest& request)
    : pacer_(clock_, std::llround(loop.period() * 1e9)) {
  if (!is_paced) {
    grant_.is_complete = true;
    grant_.statement = "simulated clock, as fast as it goes";
    return;
  }
  std::promise<control::RealtimeGrant> granted;
  auto grant = granted.get_future();
  thread_ = std::thread([this, &loop, &granted, &request] {
    granted.set_value(control::set_up_realtime(request));
    pacer_.start();
    while (!is_stopping_.load(std::memory_order_acquire)) {
      const control::CycleStart cycle = pacer_.wait();
      loop.step(cycle.now_ns, cycle.missed_periods);
    }
  });
  grant_ = grant.get();
}

void LoopThread::stop() {
  is_stopping_.store(true, std::memory_order_release);
  if (thread_.joinable()) thread_.join();
}

}  // namespace tonus::rig
