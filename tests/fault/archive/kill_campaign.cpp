#include <csignal>
#include <spdlog/fmt/fmt.h>

#include "services/core/clock.hpp"
#include "tests/fault/archive/crash_campaign.hpp"
#include "tests/fault/archive/rig_end.hpp"
#include "tests/support/process.hpp"

namespace tonus::archive::testing {
namespace {

using namespace std::chrono_literals;

constexpr auto kPatience = 20s;

}  // namespace

Result<void> KillCampaign::live(const std::string& file, MadeUpRig& rig) {
  // Cyclone DDS takes seconds to end with a peer that was killed: every eighth life shows that it makes no
  // difference.
  const bool is_fast = draw(0, 7) != 0;
  const auto notifier = std::make_shared<bus::Notifier>();
  tonus::testing::Process archive(program_,
                                  {"--store", file, "--domain", std::to_string(domain_), "--dds",
                                   is_fast ? "fastdds" : "cyclonedds", "--log", "warn"},
                                  folder_ / "archive.log");
  auto end =
      RigEnd::create(rig, domain_, is_fast ? bus::Vendor::kFastDds : bus::Vendor::kCycloneDds, notifier);
  if (!end) return end.error();
  const SystemClock clock;
  const auto deadline = clock.now() + kPatience;
  while (!end->is_heard()) {
    if (archive.wait(0ms) != tonus::testing::Process::kStillRunning || clock.now() > deadline) {
      ++counts_.failed_starts;
      return fail(ErrorCode::kUnavailable, "the archive did not start: " + archive.output());
    }
    static_cast<void>(notifier->wait_until(clock.now() + 2ms));
  }
  // Killed at a random moment after its first receipts of this life, or before them.
  end->repeat_outcomes_without_receipt();
  const std::size_t wanted = rig.receipts() + draw(0, 20);
  while (rig.receipts() < wanted && clock.now() < deadline) {
    if (rig.next_sequence() - rig.through() < 10 * MadeUpRig::kTrialSamples) end->run_trial();
    if (auto good = end->answer(); !good) return good;
    static_cast<void>(notifier->wait_until(clock.now() + 1ms));
  }
  if (rig.receipts() < wanted)
    return fail(ErrorCode::kTimeout, fmt::format("{} receipts came, {} were waited for; {}", rig.receipts(),
                                                 wanted, archive.output()));
  end->run_trial();
  static_cast<void>(notifier->wait_until(clock.now() + std::chrono::microseconds(draw(0, 8000))));
  archive.signal(SIGKILL);
  if (archive.wait(5s) != -SIGKILL) return fail(ErrorCode::kInternal, "the archive did not die");
  return end->take_receipts();
}

}  // namespace tonus::archive::testing
