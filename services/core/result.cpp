#include "services/core/result.hpp"

#include <cstdio>
#include <cstdlib>

namespace tonus::detail {

void stop_on_error(const Error& error) {
  std::fprintf(stderr, "internal error: the value of a failed result was read: %s\n", error.message.c_str());
  std::abort();
}

void stop_on_value() {
  std::fputs("internal error: the error of a successful result was read\n", stderr);
  std::abort();
}

}  // namespace tonus::detail
