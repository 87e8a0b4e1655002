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
  std::promise<void> ended;
  ended_ = ended.get_future();
  thread_ = std::thread([this, &loop, &granted, &request, ended = std::move(ended)]() mutable {
    granted.set_value(control::set_up_realtime(request));
    pacer_.start();
    while (!is_stopping_.load(std::memory_order_acquire)) {
      const control::CycleStart cycle = pacer_.wait();
      loop.step(cycle.now_ns, cycle.missed_periods);
    }
    ended.set_value();
  });
  grant_ = grant.get();
}

bool LoopThread::stop(std::chrono::milliseconds limit) {
  is_stopping_.store(true, std::memory_order_release);
  if (!thread_.joinable()) return true;
  if (ended_.wait_for(limit) != std::future_status::ready) return false;
  thread_.join();
  return true;
}

}  // namespace tonus::rig
