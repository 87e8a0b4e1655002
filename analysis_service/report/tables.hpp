#pragma once

#include <vector>

#include "analysis_service/report/table.hpp"
#include "analysis_service/study/study.hpp"

/// The paper's tables from a study, each row beside the published numbers and the simulated truth.
namespace tonus::report {

/// I: link masses implied by the identified mass matrices, by method.
[[nodiscard]] Table table_one(const study::Study& study);
/// II: fitting errors of the models (3), (13), (14), (15).
[[nodiscard]] Table table_two(const study::Study& study);
/// III: one constant between joint damping and stiffness (SS), or damping ratio (SD).
[[nodiscard]] Table table_three(const study::Study& study);
/// IV: three constants each (MS, MD).
[[nodiscard]] Table table_four(const study::Study& study);

/// Which share of the true elements of M, B and K lies in the stated 95 % intervals, by method.
[[nodiscard]] Table coverage_table(const study::Study& study);
/// Link masses and joint constants with their 95 % intervals.
[[nodiscard]] Table intervals_table(const study::Study& study);
/// What each method's numbers are worth on each subject, by simulation around the measured conditions.
[[nodiscard]] Table worth_table(const study::Study& study);
/// How many entries of Tables I, III and IV lie within the published spread of the cohort's truth: one
/// standard deviation as printed for the same subject (Table I: subjects 1 to 3; Table IV, which prints none:
/// that of the subject's tau and zeta in Table III).
[[nodiscard]] Table spread_table(const study::Study& study);
/// The published patterns, each with what this study shows.
[[nodiscard]] Table patterns_table(const study::Study& study);
/// Spring centres, modulation and fitting errors under bias forces.
[[nodiscard]] Table loaded_table(const study::Study& study);

}  // namespace tonus::report
