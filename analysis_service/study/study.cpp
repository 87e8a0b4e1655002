#include "analysis_service/study/study.hpp"

#include <algorithm>
#include <filesystem>
#include <spdlog/fmt/fmt.h>

#include "analysis_service/impedance/propagation.hpp"
#include "services/simulation/true_impedance.hpp"

namespace tonus::study {
namespace {

struct Chosen {
  std::optional<store::Session> unloaded;
  std::optional<store::Session> loaded;
};

bool is_loaded(const store::Session& session) {
  return std::any_of(session.trials.begin(), session.trials.end(), [](const store::SessionTrial& trial) {
    return trial.command && trial.command->value.program().bias_hold_s() > 0.0;
  });
}

bool is_completed(const store::Session& session) {
  return session.state && session.state->phase() == v1::SESSION_COMPLETED;
}

/// The newest completed sessions of a subject, but for pilots; sessions come in the order of their start.
Result<Chosen> choose(store::Store& store, const std::vector<store::SessionRecord>& records,
                      const std::string& subject) {
  Chosen chosen;
  for (const auto& record : records) {
    if (record.subject != subject) continue;
    auto session = store::read_session(store, record.session);
    if (!session) return session.error();
    if (!is_completed(*session) || session->plan.is_pilot()) continue;
    (is_loaded(*session) ? chosen.loaded : chosen.unloaded) = std::move(*session);
  }
  return chosen;
}

std::optional<impedance::HypothesisFit> fit_to(const std::vector<impedance::PostureImpedance>& postures,
                                               const TwoLink& links, impedance::Hypothesis hypothesis) {
  if (postures.empty()) return std::nullopt;
  const auto joints = impedance::joint_matrices(postures, links);
  if (!joints) return std::nullopt;
  auto fitted = impedance::fit_hypothesis(*joints, hypothesis);
  if (!fitted) return std::nullopt;
  return std::move(*fitted);
}

}  // namespace

impedance::CartesianImpedance truth_at(const simulation::SubjectProfile& subject,
                                       const Eigen::Vector2d& position) {
  const auto truth = simulation::true_impedance(subject, position);
  return {truth.mass, truth.damping, truth.stiffness};
}

std::vector<impedance::PostureImpedance> Subject::postures(impedance::Method method) const {
  std::vector<impedance::PostureImpedance> all;
  if (!unloaded) return all;
  for (const auto& condition : unloaded->conditions) {
    const auto* estimate = condition.find(method);
    if (estimate == nullptr) continue;
    all.push_back({condition.condition.position, {estimate->value.M, estimate->value.B, estimate->value.K}});
  }
  return all;
}

std::vector<impedance::PostureImpedance> Subject::true_postures() const {
  std::vector<impedance::PostureImpedance> all;
  if (!unloaded || !truth) return all;
  for (const auto& condition : unloaded->conditions) {
    const Eigen::Vector2d& position = condition.condition.position;
    all.push_back({position, truth_at(*truth, position)});
  }
  return all;
}

std::optional<impedance::HypothesisFit> Subject::fit(impedance::Hypothesis hypothesis) const {
  return fit_to(postures(impedance::Method::kStateVariable), links, hypothesis);
}

std::optional<impedance::HypothesisFit> Subject::true_fit(impedance::Hypothesis hypothesis) const {
  return fit_to(true_postures(), links, hypothesis);
}

Result<impedance::LinkMasses> Subject::link_masses(impedance::Method method) const {
  std::vector<impedance::PostureMass> masses;
  for (const auto& condition : unloaded->conditions) {
    const auto* estimate = condition.find(method);
    if (estimate == nullptr) continue;
    masses.push_back(
        {condition.condition.position, estimate->value.M, condition.condition.posture != "proximal"});
  }
  return impedance::fit_link_masses(masses, {links.l1, links.l2, std::nullopt, std::nullopt});
}

namespace {

/// What is known of the errors at each posture; empty where one has none.
std::vector<impedance::UncertainPosture> uncertain_postures(const Subject& subject,
                                                            impedance::Method method) {
  std::vector<impedance::UncertainPosture> all;
  if (!subject.unloaded) return all;
  for (const auto& condition : subject.unloaded->conditions) {
    const auto* estimate = condition.find(method);
    if (estimate == nullptr) continue;
    const auto posture = impedance::uncertain_posture(condition.condition.position, *estimate);
    if (!posture) return {};
    all.push_back(*posture);
  }
  return all;
}

}  // namespace

std::vector<impedance::Interval> Subject::link_mass_intervals(impedance::Method method) const {
  const auto uncertain = uncertain_postures(*this, method);
  if (uncertain.empty()) return {};
  std::vector<bool> is_used;
  for (const auto& condition : unloaded->conditions) {
    if (condition.find(method) != nullptr) is_used.push_back(condition.condition.posture != "proximal");
  }
  return impedance::propagate(
      uncertain,
      [&](std::span<const impedance::PostureImpedance> postures) -> std::optional<Eigen::VectorXd> {
        std::vector<impedance::PostureMass> masses;
        for (std::size_t i = 0; i < postures.size(); ++i)
          masses.push_back({postures[i].position, postures[i].impedance.M, is_used[i]});
        const auto fitted =
            impedance::fit_link_masses(masses, {links.l1, links.l2, std::nullopt, std::nullopt});
        if (!fitted) return std::nullopt;
        return Eigen::VectorXd(fitted->mass);
      });
}

std::vector<impedance::Interval> Subject::fit_intervals(impedance::Hypothesis hypothesis) const {
  const auto uncertain = uncertain_postures(*this, impedance::Method::kStateVariable);
  if (uncertain.empty()) return {};
  return impedance::propagate(
      uncertain,
      [&](std::span<const impedance::PostureImpedance> postures) -> std::optional<Eigen::VectorXd> {
        const auto fitted = fit_to({postures.begin(), postures.end()}, links, hypothesis);
        if (!fitted) return std::nullopt;
        return fitted->constants;
      });
}

Result<Study> read_study(store::Store& store, const std::vector<simulation::CohortSubject>& cohort,
                         const std::function<void(std::size_t, std::size_t)>& progress) {
  const auto records = store::list_sessions(store);
  if (!records) return records.error();
  Study study;
  study.archive = std::filesystem::path(store.name()).filename().string();
  study.is_simulated = true;
  bool has_any = false;
  for (const simulation::CohortSubject& member : cohort) {
    progress(study.subjects.size(), cohort.size());
    Subject subject{member.name, member.profile.subject.links, {}, {}, {}};
    bool is_simulated = true;
    const auto chosen = choose(store, *records, member.name);
    if (!chosen) return chosen.error();
    for (const bool loaded : {false, true}) {
      const auto& session = loaded ? chosen->loaded : chosen->unloaded;
      if (!session) continue;
      auto analysis = analyse(store, *session);
      if (!analysis) return analysis.error();
      is_simulated &= analysis->is_simulated;
      (loaded ? subject.loaded : subject.unloaded) = std::move(*analysis);
      has_any = true;
    }
    if (is_simulated && (subject.unloaded || subject.loaded)) subject.truth = member.profile.subject;
    study.is_simulated &= is_simulated;
    study.subjects.push_back(std::move(subject));
  }
  progress(cohort.size(), cohort.size());
  if (!has_any) {
    return fail(ErrorCode::kNotFound,
                fmt::format("{}: no completed session of the cohort's {} subjects ('{}' to '{}')",
                            store.name(), cohort.size(), cohort.front().name, cohort.back().name));
  }
  return study;
}

}  // namespace tonus::study
