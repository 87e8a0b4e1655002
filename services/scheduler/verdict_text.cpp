#include "services/scheduler/verdict_text.hpp"

#include <algorithm>

#include "services/contract/names.hpp"

namespace tonus::scheduler {
std::string verdict_text(const v1::TrialVerdict& verdict) {
  std::string text;
  for (const auto reason : verdict.reasons())
    text += (text.empty() ? "" : ", ") + std::string(v1::reason_name(reason));
  if (text.empty()) text = "not valid";
  return verdict.detail().empty() ? text : text + ": " + verdict.detail();
}

bool may_be_lost_on_the_way(const v1::TrialVerdict& verdict) {
  return std::any_of(verdict.reasons().begin(), verdict.reasons().end(), [](v1::VerdictReason reason) {
    return reason == v1::REASON_GAP || reason == v1::REASON_UNKNOWN_RIG || reason == v1::REASON_NOT_COMPLETED;
  });
}

}  // namespace tonus::scheduler
