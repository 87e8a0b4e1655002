#pragma once

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "services/store/session_reader.hpp"
#include "tests/support/three_hosts/three_hosts.hpp"

namespace tonus::testing {

/// How the programs of a lab are started.
struct LabOptions {
  std::array<std::string, 3> dds{"fastdds", "fastdds", "fastdds"};  ///< Of each host.
  bool has_discovery_server = false;                                ///< On the server, in place of peers.
  std::filesystem::path security{};  ///< Folder with one for each host's name; empty: none.
  bool resumes_unattended = true;
};

/// The rig agent on the rig's PC, the services on the server, and a session that the desk runs, in real time.
class LabSession {
 public:
  LabSession(const ThreeHosts& hosts, LabOptions options);

  /// Starts `tonus run` on the desk: one posture, so many directions, one perturbation each (about 4 s).
  void start(int directions, int hold_s = 2);
  [[nodiscard]] int finish(std::chrono::seconds limit) { return run_->wait(limit); }

  /// Runs `tonus COMMAND` on a host: exit code, and what it printed.
  struct Answer {
    int code = 0;
    std::string text;
  };
  [[nodiscard]] Answer ask(Host host, const std::string& command, const std::vector<std::string>& more = {});
  /// Waits until the rig agent has printed this; false after `limit`.
  [[nodiscard]] bool rig_prints(const std::string& text, std::chrono::seconds limit) {
    return services_.back()->wait_for_output(text, limit);
  }
  /// Asks again until the answer has `text`; false after `limit`.
  [[nodiscard]] bool ask_until(Host host, const std::string& command, const std::string& text,
                               std::chrono::seconds limit);

  /// Starts another program of the system with the options of that host.
  [[nodiscard]] std::unique_ptr<Process> start_beside(Host host, const std::string& program,
                                                      const std::vector<std::string>& more = {});

  [[nodiscard]] store::Session archived() const;
  [[nodiscard]] std::filesystem::path store_file() const { return folder_ / "server" / "archive.sqlite"; }
  [[nodiscard]] std::string everything_printed() const;

 private:
  [[nodiscard]] std::vector<std::string> options_of(Host host) const;
  std::unique_ptr<Process> begin(Host host, const std::string& program, const std::vector<std::string>& more);

  const ThreeHosts* hosts_;
  LabOptions options_;
  int programs_ = 0;
  TemporaryFolder folder_;
  std::vector<std::unique_ptr<Process>> services_;
  std::unique_ptr<Process> run_;
};

}  // namespace tonus::testing
