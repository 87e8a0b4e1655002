#include "rig_agent/control/realtime_setup.hpp"

#include <cerrno>
#include <pthread.h>
#include <sched.h>
#include <spdlog/fmt/fmt.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <system_error>

namespace tonus::control {
namespace {

std::string reason(int error) { return std::generic_category().message(error); }

// 0 or the error's number.
int set_fifo(int priority) {
  sched_param parameters{};
  parameters.sched_priority = priority;
  return pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameters);
}

int set_cpu(int cpu) {
  if (cpu < 0 || cpu >= CPU_SETSIZE) return EINVAL;
  cpu_set_t set;
  CPU_ZERO(&set);
  CPU_SET(static_cast<std::size_t>(cpu), &set);
  return pthread_setaffinity_np(pthread_self(), sizeof(set), &set);
}

// Future pages too only without a limit: within one, a later allocation of the process would fail instead.
bool has_unlimited_locking() {
  rlimit limit{};
  return getrlimit(RLIMIT_MEMLOCK, &limit) == 0 && limit.rlim_cur == RLIM_INFINITY;
}

int lock_memory(bool with_future) {
  return mlockall(MCL_CURRENT | (with_future ? MCL_FUTURE : 0)) == 0 ? 0 : errno;
}

}  // namespace

void keep_stacks_small() {
  pthread_attr_t attributes;
  if (pthread_getattr_default_np(&attributes) != 0) return;  // then they are as large as they were
  if (pthread_attr_setstacksize(&attributes, kSmallStack) == 0) (void)pthread_setattr_default_np(&attributes);
  (void)pthread_attr_destroy(&attributes);
}

RealtimeGrant set_up_realtime(const RealtimeRequest& request) {
  RealtimeGrant grant;
  grant.is_complete = true;
  std::string parts;
  const auto say = [&](const std::string& what, int error) {
    parts += parts.empty() ? "" : ", ";
    parts += error == 0 ? what : fmt::format("{} refused ({})", what, reason(error));
    grant.is_complete = grant.is_complete && error == 0;
    return error == 0;
  };
  if (request.fifo_priority) {
    grant.has_fifo =
        say(fmt::format("SCHED_FIFO {}", *request.fifo_priority), set_fifo(*request.fifo_priority));
  }
  if (request.cpu) grant.has_cpu = say(fmt::format("processor {}", *request.cpu), set_cpu(*request.cpu));
  if (request.lock_memory) {
    const bool with_future = has_unlimited_locking();
    grant.has_locked_memory =
        say(with_future ? "locked memory" : "locked memory (present pages only)", lock_memory(with_future));
  }
  grant.statement = "realtime: " + (parts.empty() ? std::string("nothing was asked for") : parts);
  return grant;
}

}  // namespace tonus::control
