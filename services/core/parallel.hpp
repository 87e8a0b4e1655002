#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <thread>
#include <vector>

namespace tonus {

/// Runs work(i) once for every i in 0 .. count - 1, on as many threads as the machine has processors, and
/// returns when all are done. Calls for different i run at the same time and in any order: each writes to a
/// place of its own. `work` must not throw. Not for realtime threads.
template <typename Work>
void for_each_in_parallel(std::size_t count, const Work& work) {
  std::atomic<std::size_t> next{0};
  const auto run = [&] {
    // Relaxed: only the number is shared; the threads' ends order everything else.
    for (std::size_t i = next.fetch_add(1, std::memory_order_relaxed); i < count;
         i = next.fetch_add(1, std::memory_order_relaxed)) {
      work(i);
    }
  };
  const std::size_t processors = std::max<std::size_t>(1, std::thread::hardware_concurrency());
  std::vector<std::jthread> others;
  for (std::size_t i = 1; i < std::min(processors, count); ++i) others.emplace_back(run);
  run();
}

}  // namespace tonus
