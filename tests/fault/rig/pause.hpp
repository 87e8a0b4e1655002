#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "services/core/result.hpp"

namespace tonus::testing {

/// Pauses of random sets of a system's programs, as a laptop's sleep or a frozen virtual machine makes them.
struct PauseCampaign {
  std::string dds = "fastdds";
  std::uint64_t seed = 1;
  unsigned pauses = 100;
  double shortest_s = 4.0;
  double longest_s = 8.0;
  bool prints_each = false;
};

struct Pause {
  std::string programs;
  double seconds = 0.0;
  double back_after_s = 0.0;  ///< Until the next trial was commanded.
};

struct PauseReport {
  std::vector<Pause> pauses;
  unsigned late = 0;  ///< After which the session did not go on within 10 s.
};

/// Runs sessions in real time, pauses, lets go and waits for the next trial. An error where a session does
/// not go on within two minutes.
[[nodiscard]] Result<PauseReport> run_paused_sessions(const PauseCampaign& campaign);

[[nodiscard]] std::string text_of(const Pause& pause);
[[nodiscard]] std::string text_of(const PauseReport& report);

}  // namespace tonus::testing
