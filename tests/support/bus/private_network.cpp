#include "tests/support/bus/private_network.hpp"

#include <cerrno>
#include <cstring>
#include <fstream>
#include <net/if.h>
#include <sched.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include "services/core/process.hpp"

namespace tonus::test {
namespace {

bool is_private = false;

/// Without privileges: a user namespace too, in which this user is root, so that ip and nft may do their work
/// there.
bool enter_as_mapped_root() {
  const uid_t user = getuid();
  const gid_t group = getgid();
  if (unshare(CLONE_NEWUSER | CLONE_NEWNET) != 0) return false;
  std::ofstream("/proc/self/setgroups") << "deny";
  std::ofstream("/proc/self/uid_map") << "0 " << user << " 1";
  std::ofstream("/proc/self/gid_map") << "0 " << group << " 1";
  return true;
}

Result<void> start_loopback() {
  const int socket_fd = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  ifreq request{};
  std::strncpy(static_cast<char*>(request.ifr_name), "lo", IFNAMSIZ - 1);
  request.ifr_flags = IFF_UP | IFF_RUNNING;
  const int code = ioctl(socket_fd, SIOCSIFFLAGS, &request);
  close(socket_fd);
  if (code == 0) return {};
  return fail(ErrorCode::kUnavailable, std::string("loopback interface: ") + std::strerror(errno));
}

}  // namespace

Result<void> enter_private_network() {
  if (unshare(CLONE_NEWNET) != 0 && !enter_as_mapped_root()) {
    return fail(ErrorCode::kUnavailable, std::string("network namespace: ") + std::strerror(errno));
  }
  auto started = start_loopback();
  is_private = started.has_value();
  return started;
}

bool is_in_private_network() { return is_private; }

Result<void> run_program(const std::vector<std::string>& arguments) {
  TONUS_TRY_ASSIGN(const ProcessEnd end, run_process(arguments, {STDERR_FILENO, {}, {}}));
  if (end.is_success()) return {};
  std::string line;
  for (const std::string& argument : arguments) line += (line.empty() ? "" : " ") + argument;
  return fail(ErrorCode::kUnavailable, "'" + line + "' " + end.text());
}

}  // namespace tonus::test
