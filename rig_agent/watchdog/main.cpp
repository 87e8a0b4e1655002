// tonus-rig-watchdog: drops the torque when the rig agent's loop stands still. Started by the rig agent, with
// the page that they share as an open file; not for people.

#include <cerrno>
#include <charconv>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <string>
#include <sys/mman.h>
#include <unistd.h>

#include "rig_agent/control/realtime_setup.hpp"
#include "rig_agent/watchdog/disable.hpp"
#include "rig_agent/watchdog/watch.hpp"
#include "services/core/standard_descriptors.hpp"

namespace {

using namespace tonus;

int refuse(const std::string& what) {
  std::fprintf(stderr, "tonus-rig-watchdog: %s\n", what.c_str());
  return 2;
}

bool parse(const char* text, long& value) {
  const char* end = text + std::strlen(text);
  return std::from_chars(text, end, value).ptr == end;
}

std::chrono::nanoseconds now() {
  timespec t{};
  clock_gettime(CLOCK_MONOTONIC, &t);
  return std::chrono::seconds(t.tv_sec) + std::chrono::nanoseconds(t.tv_nsec);
}

void rest(std::chrono::nanoseconds duration) {
  const timespec t{0, static_cast<long>(duration.count())};
  nanosleep(&t, nullptr);
}

}  // namespace

int main(int argc, char** argv) {
  occupy_standard_descriptors();
  if (argc == 2 && (std::strcmp(argv[1], "--help") == 0 || std::strcmp(argv[1], "--version") == 0)) {
    std::printf(
        "tonus-rig-watchdog: started by tonus-rig-agent, drops the torque when the agent's loop stands "
        "still\n"
        "usage: tonus-rig-watchdog PAGE AGENT LIMIT_US PRIORITY DRIVER FILE OPTIONS\n");
    const auto finished = finish_standard_output();
    return finished ? 0 : refuse(finished.error().message);
  }
  long page = 0;
  long agent = 0;
  long limit_us = 0;
  long priority = 0;
  if (argc != 8 || !parse(argv[1], page) || !parse(argv[2], agent) || !parse(argv[3], limit_us) ||
      !parse(argv[4], priority))
    return refuse("it is started by tonus-rig-agent; --help says how");
  if (limit_us < 1000 || limit_us > 500000)
    return refuse("the limit is not allowed; expected 1000 to 500000 us");
  void* memory =
      mmap(nullptr, sizeof(control::Pulse), PROT_READ | PROT_WRITE, MAP_SHARED, static_cast<int>(page), 0);
  // NOLINTNEXTLINE(performance-no-int-to-ptr): the system's macro
  if (memory == MAP_FAILED) return refuse(std::string("no shared page: ") + std::strerror(errno));
  auto disable = watchdog::disable_of(argv[5], argv[6], argv[7]);
  if (!disable) return refuse(disable.error().message);

  // Ctrl-C is for the agent; this program ends after it.
  std::signal(SIGINT, SIG_IGN);
  std::signal(SIGTERM, SIG_IGN);
  control::RealtimeRequest realtime;
  realtime.fifo_priority.reset();
  if (priority > 0) realtime.fifo_priority = static_cast<int>(priority);
  (void)control::set_up_realtime(realtime);
  auto& pulse = *static_cast<control::Pulse*>(memory);
  (void)watchdog::watch(pulse, {.limit = std::chrono::microseconds(limit_us),
                                .disable = *disable,
                                .is_agent_there = [agent] { return getppid() == static_cast<pid_t>(agent); },
                                .rest = rest,
                                .now = now});
  return 0;
}
