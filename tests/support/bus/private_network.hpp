#pragma once

#include <string>
#include <vector>

#include "services/core/result.hpp"

namespace tonus::test {

/// Moves this process, and the children that it starts, into a network of its own with nothing but a loopback
/// interface: tests in parallel do not hear each other, and packet filters harm nobody. Call before any
/// thread or socket is made. kUnavailable where the system does not permit it.
[[nodiscard]] Result<void> enter_private_network();

/// True after enter_private_network() has succeeded in this process.
[[nodiscard]] bool is_in_private_network();

/// Runs a program and waits for it. kUnavailable when it is missing or ends with an error.
[[nodiscard]] Result<void> run_program(const std::vector<std::string>& arguments);

}  // namespace tonus::test
