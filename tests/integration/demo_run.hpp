#pragma once

#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "services/store/session_reader.hpp"
#include "tests/support/process.hpp"
#include "tests/support/temporary_folder.hpp"

namespace tonus::testing {

/// `tonus demo` with a domain and a data folder of its own.
class DemoRun {
 public:
  explicit DemoRun(std::vector<std::string> arguments);

  [[nodiscard]] Process& process() { return *process_; }
  /// Waits for its end; the exit code, with what it printed and its services' logs in case of a failure.
  [[nodiscard]] int finish();
  [[nodiscard]] std::string everything_printed() const;
  [[nodiscard]] nlohmann::json results() const;
  /// The session as its archive holds it; a test failure and an empty one where it cannot be read.
  [[nodiscard]] store::Session archived() const;
  [[nodiscard]] const TemporaryFolder& folder() const { return folder_; }

 private:
  TemporaryFolder folder_;
  std::unique_ptr<Process> process_;
};

/// Checks that M, B and K of all five postures are there, and each element within `share` of the largest
/// element of the true matrix of the default profile's subject.
void expect_truth_within(const nlohmann::json& results, double share);

}  // namespace tonus::testing
