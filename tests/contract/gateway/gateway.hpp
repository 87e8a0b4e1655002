#pragma once

#include <chrono>
#include <string>
#include <string_view>

#include "tests/support/process.hpp"
#include "tests/support/temporary_folder.hpp"

namespace tonus::testing {

inline constexpr std::chrono::seconds kGatewayLimit{60};

/// A tonus-dashboard on this machine's loopback, with a port of its own.
class Gateway {
 public:
  Gateway(const TemporaryFolder& folder, int domain, std::string_view vendor = "fastdds")
      : process_(program("tonus-dashboard"),
                 {"--domain", std::to_string(domain), "--dds", std::string(vendor), "--listen", "127.0.0.1:0",
                  "--data", (folder / "data").string()},
                 folder / "gateway.log") {}

  /// Where it listens, "http://ADDRESS:PORT/"; empty if it does not within kGatewayLimit.
  [[nodiscard]] std::string url() {
    if (!process_.wait_for_output("dashboard: http://", kGatewayLimit)) return {};
    const auto said = process_.output();
    const auto begin = said.find("http://");
    return said.substr(begin, said.find('\n', begin) - begin);
  }
  [[nodiscard]] std::string output() const { return process_.output(); }
  void signal(int number) const { process_.signal(number); }

 private:
  Process process_;
};

}  // namespace tonus::testing
