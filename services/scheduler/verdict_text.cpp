#include "services/scheduler/verdict_text.hpp"

#include <algorithm>

namespace tonus::scheduler {
namespace {

const char* reason_name(v1::VerdictReason reason) {
  switch (reason) {
    case v1::REASON_NOT_COMPLETED:
      return "not completed";
    case v1::REASON_OFF_TARGET:
      return "off target";
    case v1::REASON_BIAS_NOT_REACHED:
      return "bias not reached";
    case v1::REASON_BIAS_NOT_HELD:
      return "bias not held";
    case v1::REASON_EARLY_REACTION:
      return "early reaction";
    case v1::REASON_SATURATED:
      return "saturated";
    case v1::REASON_GAP:
      return "gap";
    case v1::REASON_EXCURSION:
      return "excursion";
    case v1::REASON_NOT_AT_REST:
      return "not at rest";
    case v1::REASON_UNKNOWN_RIG:
      return "unknown rig";
    case v1::REASON_LET_GO:
      return "let go";
  }
  return "unknown reason";
}

}  // namespace

std::string verdict_text(const v1::TrialVerdict& verdict) {
  std::string text;
  for (const auto reason : verdict.reasons())
    text += (text.empty() ? "" : ", ") + std::string(reason_name(reason));
  if (text.empty()) text = "not valid";
  return verdict.detail().empty() ? text : text + ": " + verdict.detail();
}

bool may_be_lost_on_the_way(const v1::TrialVerdict& verdict) {
  return std::any_of(verdict.reasons().begin(), verdict.reasons().end(), [](v1::VerdictReason reason) {
    return reason == v1::REASON_GAP || reason == v1::REASON_UNKNOWN_RIG || reason == v1::REASON_NOT_COMPLETED;
  });
}

}  // namespace tonus::scheduler
