#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "services/core/progress.hpp"
#include "services/store/session_reader.hpp"
#include "services/verification/estimate_difference.hpp"

namespace tonus::verification {

/// A trial's samples as they are there, beside its certificate. Where the rig has auxiliary channels, a
/// sample is there with the auxiliary values of its time.
struct TrialCheck {
  std::uint32_t attempt = 0;
  store::Certificate certificate;  ///< As the archive issued it.
  bool is_certified = false;
  std::uint64_t found = 0;  ///< Counted in the blocks themselves.
  std::uint64_t absent = 0;
};

/// A published estimate beside the one that the raw data give.
struct EstimateCheck {
  enum class Outcome : std::uint8_t {
    kEqual,         ///< Bit for bit, with all trials fed through the service's code.
    kEqualAsNamed,  ///< Bit for bit from the trials that it names; the remark says what differs now.
    kDiffers,
    kNotReproduced,  ///< The raw data give none.
    kNotPublished,   ///< The raw data give one that was not published.
  };
  v1::Estimate estimate;  ///< As published, or as found where it was not.
  Outcome outcome = Outcome::kEqual;
  EstimateDifference difference;
  std::string remark;
};

/// A verdict beside the one that the raw data give.
struct VerdictCheck {
  std::uint32_t attempt = 0;
  bool is_equal = true;   ///< Validity and reasons.
  std::string published;  ///< "valid", or why not; empty: none.
  std::string found;
};

struct Verification {
  std::uint64_t blocks = 0;  ///< Of samples and of auxiliary values.
  std::uint64_t damaged_blocks = 0;
  std::uint64_t messages = 0;
  std::uint64_t damaged_messages = 0;
  std::vector<TrialCheck> trials;
  store::Certificate certificate;  ///< Sums of the trials'.
  std::vector<VerdictCheck> verdicts;
  std::vector<EstimateCheck> estimates;
  bool is_over = true;   ///< False: the session still runs, and what is not there yet is no fault.
  std::string settings;  ///< Where the settings of identification come from.
  std::vector<std::string> problems;  ///< Empty: all is well.
  std::vector<std::string> remarks;

  [[nodiscard]] bool is_well() const { return problems.empty(); }
};

/// Checks every block and message of a session against its checksum, every trial's samples against its
/// certificate, and verdicts and estimates against what the same code makes of the raw data. Reads only.
/// Errors: what keeps it from checking at all; what it finds amiss is in `problems`.
[[nodiscard]] Result<Verification> verify_session(store::Store& store, const store::SessionRecord& record,
                                                  const Progress& progress = {});

[[nodiscard]] const char* name_of(EstimateCheck::Outcome outcome);

/// "reference, all sets, unloaded" and the like.
[[nodiscard]] std::string condition_text(const v1::Estimate& estimate);

}  // namespace tonus::verification
