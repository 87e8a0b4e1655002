#pragma once

#include <optional>
#include <string>
#include <vector>

#include "analysis_service/impedance/arm_model.hpp"
#include "analysis_service/impedance/joint_space.hpp"
#include "analysis_service/impedance/link_masses.hpp"
#include "analysis_service/study/session_analysis.hpp"
#include "services/simulation/cohort.hpp"
#include "services/store/store.hpp"

namespace tonus::study {

/// The true matrices of a simulated subject at a posture.
[[nodiscard]] impedance::CartesianImpedance truth_at(const simulation::SubjectProfile& subject,
                                                     const Eigen::Vector2d& position);

/// One subject with what was measured of him.
struct Subject {
  std::string name;
  TwoLink links;                                    ///< As measured on the person, m.
  std::optional<simulation::SubjectProfile> truth;  ///< Only where every session of the subject is simulated.
  std::optional<SessionAnalysis> unloaded;
  std::optional<SessionAnalysis> loaded;

  /// The unloaded postures by this method, in the order of the protocol; those without an estimate left out.
  [[nodiscard]] std::vector<impedance::PostureImpedance> postures(impedance::Method method) const;
  /// The true ones, at the same places; empty without a truth.
  [[nodiscard]] std::vector<impedance::PostureImpedance> true_postures() const;
  /// How joint damping follows stiffness (Tables III, IV), by state-variable filtering; none where it cannot
  /// be fitted.
  [[nodiscard]] std::optional<impedance::HypothesisFit> fit(impedance::Hypothesis hypothesis) const;
  /// The same of the true matrices.
  [[nodiscard]] std::optional<impedance::HypothesisFit> true_fit(impedance::Hypothesis hypothesis) const;
  /// Link masses that the identified mass matrices imply (Table I); the posture called "proximal" is left
  /// out, as published.
  [[nodiscard]] Result<impedance::LinkMasses> link_masses(impedance::Method method) const;
  /// 95 % intervals of these masses, and of the constants of fit(), from the errors of the identified
  /// matrices (impedance/propagation.hpp); empty where they cannot be computed.
  [[nodiscard]] std::vector<impedance::Interval> link_mass_intervals(impedance::Method method) const;
  [[nodiscard]] std::vector<impedance::Interval> fit_intervals(impedance::Hypothesis hypothesis) const;
};

/// A cohort, by the order of its file.
struct Study {
  std::vector<Subject> subjects;
  std::string archive;        ///< The store's name, without its folder.
  bool is_simulated = false;  ///< Every session is: by what its rig said, not by the subject's name.
};

/// Of each subject of the cohort the newest completed session without and the newest one with bias forces.
/// `progress` is told how many sessions of how many are done. kNotFound: none of the cohort's subjects has a
/// session.
[[nodiscard]] Result<Study> read_study(store::Store& store,
                                       const std::vector<simulation::CohortSubject>& cohort,
                                       const std::function<void(std::size_t, std::size_t)>& progress);

}  // namespace tonus::study
