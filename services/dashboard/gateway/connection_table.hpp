#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>

namespace tonus::dashboard {

/// What is known of who is at the other end of a connection.
enum class Standing : std::uint8_t {
  kUnproven,  ///< No token yet, or between two requests. May be ended to make room.
  kViewer,
  kOperator,
};

/// Decides which connections there is room for, so that nobody locks operators out: not with idle
/// connections, which give way to newcomers, and not with viewers, who leave room in reserve. No network and
/// no clock; one thread.
///
/// A newcomer is always let in while anybody unproven can give way: the oldest of the newcomer's own address
/// where that has `per_address` of them, else, where all places are taken, the oldest of the address that has
/// most. Viewers take at most `all - reserve` places, and `per_address` of them from one address. Operators
/// take any.
class ConnectionTable {
 public:
  struct Limits {
    std::size_t all = 128;
    std::size_t reserve = 16;  ///< That viewers leave to operators.
    std::size_t per_address = 32;
  };
  using Number = std::uint64_t;

  explicit ConnectionTable(const Limits& limits) : limits_(limits) {}

  struct Arrival {
    std::optional<Number> number;       ///< None: no room.
    std::function<void()> gives_way{};  ///< Ends the connection that makes room, which is forgotten already.
  };
  /// `end` closes the connection; it is not called after leave().
  [[nodiscard]] Arrival arrive(const std::string& address, std::function<void()> end);

  /// False: no room for another viewer; nothing changes. Of a forgotten connection: false.
  [[nodiscard]] bool set_standing(Number number, Standing standing);

  void leave(Number number) { places_.erase(number); }

  [[nodiscard]] std::size_t size() const { return places_.size(); }
  [[nodiscard]] std::size_t count(Standing standing) const;

 private:
  struct Place {
    std::string address;
    Standing standing = Standing::kUnproven;
    std::function<void()> end;
  };
  using Places = std::map<Number, Place>;  ///< Oldest first.

  [[nodiscard]] std::size_t count(Standing standing, const std::string& address) const;
  [[nodiscard]] Places::iterator oldest_unproven(const std::string& address);
  [[nodiscard]] std::optional<std::string> most_unproven_address() const;

  Limits limits_;
  Places places_;
  Number last_ = 0;
};

/// What the limits of an address count: an IPv4 address as it is (also one written as IPv6), of an IPv6
/// address the first 64 bits, which one machine has to itself. `address` as Boost.Asio prints it.
[[nodiscard]] std::string counted_address(const std::string& address);

}  // namespace tonus::dashboard
