#include "tests/support/short_session.hpp"

#include <fstream>
#include <spdlog/fmt/fmt.h>

namespace tonus::testing {
namespace {

constexpr char kProtocol[] = R"(
schema = 1
kind = "unloaded"
name = "short"
rejection_limit = {2}
[[posture]]
name = "reference"
position_m = [0.000, 0.380]
[perturbation]
directions = {0}
sets = 1
amplitude_m = 0.005
rise_time_s = 0.2
hold_s = [{1:.1f}, {1:.1f}]
wait_s = [0.5, 0.7]
)";

}  // namespace

void write_short_protocol(const std::filesystem::path& file, int directions, double hold_s,
                          int rejection_limit) {
  std::ofstream(file) << fmt::format(kProtocol, directions, hold_s, rejection_limit);
}

void write_patient_profile(const std::filesystem::path& file, double command_timeout_s) {
  std::ofstream(file) << fmt::format(
      "[limits]\nmissed_periods = 2000\nmissed_share = 0\ncommand_timeout_s = {:.1f}\n", command_timeout_s);
}

}  // namespace tonus::testing
