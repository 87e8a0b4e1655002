#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <random>
#include <string>

#include "services/core/result.hpp"
#include "tests/fault/archive/made_up_rig.hpp"

namespace tonus::archive::testing {

/// What a campaign has done. Counts are of the whole campaign.
struct CrashCounts {
  std::uint64_t crashes = 0;
  std::uint64_t receipts = 0;
  std::uint64_t samples = 0;  ///< That a receipt was given for and that were found.
  std::uint64_t files = 0;
  std::uint64_t disk_errors = 0;    ///< Operations refused before the power went.
  std::uint64_t failed_starts = 0;  ///< Lives that ended before the store was open.
};

/// A series of crashes of an archive in the middle of its work, each followed by the check of everything that
/// a receipt was ever given for. Several crashes share a file, then a new one begins. The same seed brings
/// the same failures.
class CrashCampaign {
 public:
  CrashCampaign(std::filesystem::path folder, std::uint64_t seed);
  virtual ~CrashCampaign() = default;

  /// One life of the archive, its end, and the check. The error says what was lost or could not be opened.
  [[nodiscard]] Result<void> crash();

  [[nodiscard]] const CrashCounts& counts() const { return counts_; }

 protected:
  /// Works on `file` until it is crashed, and leaves nothing open.
  [[nodiscard]] virtual Result<void> live(const std::string& file, MadeUpRig& rig) = 0;

  std::uint64_t draw(std::uint64_t low, std::uint64_t high);
  std::mt19937_64& generator() { return generator_; }

  CrashCounts counts_;
  std::filesystem::path folder_;

 private:
  [[nodiscard]] Result<void> check(const std::string& file);
  void begin_file();

  std::mt19937_64 generator_;
  std::optional<MadeUpRig> rig_;
  std::string file_;
  std::uint64_t crashes_left_ = 0;
};

/// The archive's core on a FaultyDisk: errors first in some lives, then the loss of power.
class PowerLossCampaign final : public CrashCampaign {
 public:
  using CrashCampaign::CrashCampaign;

 private:
  [[nodiscard]] Result<void> live(const std::string& file, MadeUpRig& rig) override;
};

/// tonus-archive, on a bus of its own with a made-up rig, ended by SIGKILL.
class KillCampaign final : public CrashCampaign {
 public:
  KillCampaign(std::filesystem::path folder, std::uint64_t seed, std::filesystem::path program, int domain)
      : CrashCampaign(std::move(folder), seed), program_(std::move(program)), domain_(domain) {}

 private:
  [[nodiscard]] Result<void> live(const std::string& file, MadeUpRig& rig) override;

  std::filesystem::path program_;
  int domain_;
};

}  // namespace tonus::archive::testing
