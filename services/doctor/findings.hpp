#pragma once

#include <string>
#include <vector>

#include "services/doctor/facts.hpp"

namespace tonus::doctor {

enum class Verdict : std::uint8_t {
  kOk,
  kAdvice,   ///< Works, with something to know or to do.
  kProblem,  ///< A session would fail or be unsafe.
};

/// One line of the answer.
struct Finding {
  std::string subject;  ///< "clock", "realtime", "kernel", ...: fixed words, for programs.
  Verdict verdict = Verdict::kOk;
  std::string text;    ///< What was found.
  std::string remedy;  ///< What to do; empty where it is ok.
};

/// Judges every fact; at least one line for each subject. Knows no machine.
[[nodiscard]] std::vector<Finding> judge(const Facts& facts);

}  // namespace tonus::doctor
