#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "services/core/result.hpp"
#include "tests/support/process.hpp"
#include "tests/support/temporary_folder.hpp"

namespace tonus::testing {

/// A PostgreSQL server of a test's own, with its data in a temporary folder and nothing but a socket there.
/// It runs as another user where the test is root, which PostgreSQL refuses.
class PostgresServer {
 public:
  /// Makes a cluster, without waiting for the disk, and starts it. kNotFound: no PostgreSQL 15 or newer is
  /// installed; kUnavailable: it does not start; the message has what it says.
  [[nodiscard]] static Result<std::unique_ptr<PostgresServer>> start();

  /// Its end as of a computer that is switched off: SIGKILL to all of its processes.
  void kill();

  /// Starts it again, with the data that it has.
  [[nodiscard]] Result<void> restart();

  /// URL of a new, empty database.
  [[nodiscard]] Result<std::string> make_database();

 private:
  explicit PostgresServer(std::filesystem::path programs);
  [[nodiscard]] Result<void> run(const std::string& program, std::vector<std::string> arguments) const;
  [[nodiscard]] std::filesystem::path data() const { return folder_ / "data"; }

  std::filesystem::path programs_;
  TemporaryFolder folder_;
  std::unique_ptr<Process> process_;
  int databases_ = 0;
};

}  // namespace tonus::testing
