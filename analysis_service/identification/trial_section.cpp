#include "analysis_service/identification/trial_section.hpp"

#include <algorithm>
#include <cmath>

namespace tonus::identification {
namespace {

template <typename Predicate>
Section section_before(std::span<const Row> rows, std::size_t onset, std::size_t most_rows,
                       Predicate belongs) {
  onset = std::min(onset, rows.size());
  Section section{onset, onset};
  while (section.first > 0 && section.rows() < most_rows && belongs(rows[section.first - 1].phase))
    --section.first;
  return section;
}

}  // namespace

Section rest_before(std::span<const Row> rows, std::size_t onset, std::size_t most_rows) {
  return section_before(rows, onset, most_rows, [](Phase phase) {
    return phase == Phase::kWaiting || phase == Phase::kBiasHold || phase == Phase::kIdle;
  });
}

Section bias_hold_before(std::span<const Row> rows, std::size_t onset, std::size_t most_rows) {
  return section_before(rows, onset, most_rows, [](Phase phase) { return phase == Phase::kBiasHold; });
}

Section perturbation_from(std::span<const Row> rows, std::size_t onset) {
  onset = std::min(onset, rows.size());
  Section section{onset, onset};
  while (section.end < rows.size() && rows[section.end].phase != Phase::kReturning) ++section.end;
  return section;
}

std::size_t rows_of(double duration, double sample_rate, std::size_t least) {
  const double rows = std::round(duration * sample_rate);
  return std::max(least, rows > 0.0 ? static_cast<std::size_t>(rows) : 0);
}

}  // namespace tonus::identification
