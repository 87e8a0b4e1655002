#include "services/contract/subject.hpp"

#include <limits>

namespace tonus::contract {

v1::SubjectFacts unknown_subject() {
  constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
  v1::SubjectFacts facts;
  facts.age_years(kUnknown);
  facts.height_m(kUnknown);
  facts.weight_kg(kUnknown);
  facts.link_lengths_m({kUnknown, kUnknown});
  facts.circumferences_m({kUnknown, kUnknown});
  facts.shoulder_m({kUnknown, kUnknown});
  return facts;
}

}  // namespace tonus::contract
