#include "rig_agent/agent/loop_thread.hpp"

#include <future>

namespace tonus::rig {

LoopThread::LoopThread(control::RigLoop& loop, bool is_paced)
    : pacer_(clock_, std::llround(loop.period() * 1e9)), statement_("simulated clock, as fast as it goes") {
  if (!is_paced) return;
  std::promise<std::string> granted;
  auto statement = granted.get_future();
  thread_ = std::thread([this, &loop, &granted] {
    granted.set_value(control::set_up_realtime({}).statement);
    pacer_.start();
    while (!is_stopping_.load(std::memory_order_acquire)) {
      const control::CycleStart cycle = pacer_.wait();
      loop.step(cycle.now_ns, cycle.missed_periods);
    }
  });
  statement_ = statement.get();
}

void LoopThread::stop() {
  is_stopping_.store(true, std::memory_order_release);
  if (thread_.joinable()) thread_.join();
}

}  // namespace tonus::rig
