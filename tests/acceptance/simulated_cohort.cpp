#include "tests/acceptance/simulated_cohort.hpp"

#include <algorithm>
#include <iterator>
#include <optional>
#include <utility>

#include "services/core/parallel.hpp"
#include "services/recording/recording.hpp"
#include "tests/support/simulated_study/simulated_study.hpp"

namespace tonus::testing {
namespace {

/// Waits of 2 s: drift and tremor are as good as independent from trial to trial then, as after the published
/// 3 to 5 s.
simulated::Procedure procedure() {
  simulated::Procedure procedure;
  procedure.shortest_wait = procedure.longest_wait = 2.0;
  return procedure;
}

Result<std::vector<impedance::Trial>> trials_of(const recording::Recording& record) {
  impedance::Preparation preparation;
  preparation.sample_period = 1.0 / record.sampling_frequency;
  preparation.handle_mass = record.rig.handle_mass;
  std::vector<impedance::Trial> trials;
  for (const auto& event : record.events) {
    const recording::Stretch stretch = recording::stretch_of(record, event);
    std::vector<EndpointSample> samples;
    for (std::size_t i = stretch.first; i <= stretch.last; ++i)
      samples.push_back(convert(record.rig, record.shoulder, record.rows[i].raw));
    auto trial =
        impedance::prepare_trial(static_cast<std::uint32_t>(event.trial), samples,
                                 static_cast<Eigen::Index>(stretch.onset - stretch.first), preparation);
    if (!trial) return trial.error();
    trials.push_back(std::move(*trial));
  }
  return trials;
}

Result<study::ConditionAnalysis> measure_posture(const simulation::Profile& profile,
                                                 const simulated::Posture& posture) {
  const auto record = simulated::measure(profile, posture, procedure());
  if (!record) return record.error();
  auto trials = trials_of(*record);
  if (!trials) return trials.error();
  study::ConditionAnalysis analysis;
  analysis.condition.posture = posture.name;
  analysis.condition.position = posture.position;
  analysis.trials = std::move(*trials);
  std::vector<impedance::Options> methods(std::size(impedance::kMethods));
  for (std::size_t m = 0; m < methods.size(); ++m) methods[m].method = impedance::kMethods[m];
  for (auto& estimate : impedance::identify_each(analysis.trials, methods)) {
    if (!estimate) return estimate.error();
    analysis.estimates.push_back(std::move(*estimate));
  }
  return analysis;
}

Result<study::Subject> measure_subject(const simulation::CohortSubject& member, std::uint64_t seed) {
  study::Subject subject{member.name, member.profile.subject.links, member.profile.subject, {}, {}};
  subject.unloaded.emplace();
  simulation::Profile profile = member.profile;
  for (const auto& posture : simulated::published_postures()) {
    profile.seed = seed++;
    auto analysis = measure_posture(profile, posture);
    if (!analysis) return analysis.error();
    subject.unloaded->conditions.push_back(std::move(*analysis));
  }
  return subject;
}

}  // namespace

Result<study::Study> simulate_cohort(const std::vector<simulation::CohortSubject>& cohort,
                                     std::uint64_t seed) {
  constexpr std::uint64_t kSeedsOfASubject = 16;
  std::vector<std::optional<Result<study::Subject>>> measured(cohort.size());
  for_each_in_parallel(cohort.size(), [&](std::size_t i) {
    measured[i] = measure_subject(cohort[i], (seed * cohort.size() + i) * kSeedsOfASubject);
  });
  study::Study study;
  study.is_simulated = true;
  for (auto& subject : measured) {
    if (!*subject) return subject->error();
    study.subjects.push_back(std::move(**subject));
  }
  return study;
}

}  // namespace tonus::testing
