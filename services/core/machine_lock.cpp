#include "services/core/machine_lock.hpp"

#include <cerrno>
#include <cstddef>
#include <cstring>
#include <sys/socket.h>
#include <sys/un.h>
#include <system_error>

namespace tonus {
namespace {

struct Address {
  sockaddr_un socket{};
  socklen_t size = 0;
};

Address address_of(const std::string& name) {
  Address address;
  address.socket.sun_family = AF_UNIX;
  const std::string full = "tonus/" + name;  // behind a zero byte: an abstract name
  std::memcpy(address.socket.sun_path + 1, full.data(), full.size());
  address.size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + 1 + full.size());
  return address;
}

/// "process 17", or "another process" where the kernel does not say.
std::string holder_of(const Address& address) {
  const FileDescriptor client(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  if (!client.is_open() ||
      ::connect(client.get(), reinterpret_cast<const sockaddr*>(&address.socket), address.size) != 0)
    return "another process";
  ucred peer{};
  socklen_t size = sizeof(peer);
  if (::getsockopt(client.get(), SOL_SOCKET, SO_PEERCRED, &peer, &size) != 0) return "another process";
  return "process " + std::to_string(peer.pid);
}

}  // namespace

Result<MachineLock> MachineLock::take(const std::string& name) {
  constexpr std::size_t kLongest = sizeof(sockaddr_un::sun_path) - 1 - sizeof("tonus/");
  if (name.size() > kLongest) {
    return fail(ErrorCode::kInvalidArgument, "name of a lock: '" + name +
                                                 "' is not allowed; expected at most " +
                                                 std::to_string(kLongest) + " bytes");
  }
  FileDescriptor socket(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0));
  if (!socket.is_open()) return fail(ErrorCode::kIo, name + ": " + std::generic_category().message(errno));
  const Address address = address_of(name);
  if (::bind(socket.get(), reinterpret_cast<const sockaddr*>(&address.socket), address.size) != 0) {
    if (errno != EADDRINUSE)
      return fail(ErrorCode::kIo, name + ": " + std::generic_category().message(errno));
    return fail(ErrorCode::kAlreadyExists, name + " is in use by " + holder_of(address));
  }
  // Listening lets the kernel tell others who holds the name.
  if (::listen(socket.get(), 1) != 0)
    return fail(ErrorCode::kIo, name + ": " + std::generic_category().message(errno));
  return MachineLock(std::move(socket));
}

}  // namespace tonus
