#include "analysis_service/identification/condition.hpp"

#include <spdlog/fmt/fmt.h>
#include <tuple>

namespace tonus::identification {
namespace {

auto rank(const Condition& c) {
  return std::tie(c.session, c.rig, c.posture_index, c.posture, c.bias[0], c.bias[1], c.set, c.instruction);
}

}  // namespace

bool operator<(const Condition& a, const Condition& b) { return rank(a) < rank(b); }

Condition set_condition_of(const TrialPlan& plan) {
  Condition condition;
  condition.session = plan.session;
  condition.rig = plan.rig;
  condition.posture_index = plan.posture_index;
  condition.posture = plan.posture;
  condition.position = plan.position;
  condition.bias = plan.bias;
  condition.set = plan.set;
  condition.instruction = plan.instruction;
  return condition;
}

Condition condition_of(const TrialPlan& plan) {
  Condition condition = set_condition_of(plan);
  if (!condition.is_loaded()) condition.set = 0;
  return condition;
}

Id estimate_id(const Condition& condition, impedance::Method method, impedance::Model model) {
  // Adding zero turns -0 into 0, which is the same bias.
  return id_of(fmt::format("{}/{}/{}:{:.3f},{:.3f}/{}/{}/{}", to_hex(condition.session),
                           condition.posture_index, condition.set, condition.bias[0] + 0.0,
                           condition.bias[1] + 0.0, condition.instruction, impedance::name_of(method),
                           impedance::name_of(model)));
}

}  // namespace tonus::identification
