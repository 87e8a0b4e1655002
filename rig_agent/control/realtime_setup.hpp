#pragma once

#include <cstddef>
#include <optional>
#include <string>

namespace tonus::control {

/// What is asked for the loop's thread.
struct RealtimeRequest {
  std::optional<int> fifo_priority = 80;  ///< SCHED_FIFO, 1 to 99; none leaves the scheduling alone.
  std::optional<int> cpu;                 ///< The one processor to run on.
  bool lock_memory =
      true;  ///< mlockall of the process: present pages, and future ones if RLIMIT_MEMLOCK is unlimited.
};

/// What was permitted. `statement` says it in one line for log and health, with the reason for each refusal,
/// e.g. "realtime: SCHED_FIFO 80 refused (Operation not permitted), processor 1, locked memory".
struct RealtimeGrant {
  bool has_fifo = false;
  bool has_cpu = false;
  bool has_locked_memory = false;
  bool is_complete = false;  ///< Everything that was asked for.
  std::string statement;
};

/// Of threads that begin after keep_stacks_small(), bytes.
inline constexpr std::size_t kSmallStack = std::size_t{1} << 20U;

/// Gives threads that begin later, those of libraries too, a stack of kSmallStack unless they ask for another
/// one. Locked memory holds every stack whole, and the system's default is 8 MB. Call before the first
/// thread.
void keep_stacks_small();

/// Applies the request to the calling thread, as far as permitted. Never fails: a rig without the privileges
/// runs, and says so. Not realtime; call it before the loop starts.
[[nodiscard]] RealtimeGrant set_up_realtime(const RealtimeRequest& request);

}  // namespace tonus::control
