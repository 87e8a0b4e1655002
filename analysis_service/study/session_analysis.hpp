#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "analysis_service/identification/condition.hpp"
#include "analysis_service/impedance/identification.hpp"
#include "analysis_service/impedance/static_stiffness.hpp"
#include "services/store/session_reader.hpp"

namespace tonus::study {

/// One condition of an archived session, identified anew from its raw samples.
struct ConditionAnalysis {
  identification::Condition condition;
  std::vector<impedance::Trial> trials;  ///< Those that count, by attempt.
  std::vector<impedance::Estimate> estimates;

  /// None where it was not asked for or could not be made.
  [[nodiscard]] const impedance::Estimate* find(impedance::Method method = impedance::Method::kStateVariable,
                                                impedance::Model model = impedance::Model::kLinear) const;

  /// Average fitting error (16) of the measured force by state-variable filtering, N per axis
  /// (impedance/reconstruction.hpp); none without that estimate.
  [[nodiscard]] std::optional<impedance::AxisVector> fitting_error(impedance::Model model) const;
};

/// How the study scans a trial for rest (19): as published, the speed being that of the displacement below 5
/// Hz. An encoder step of 0.25 mm that is low-passed at 10 Hz shows 5 mm/s by itself.
[[nodiscard]] impedance::StaticOptions static_options();

/// A session of one subject.
struct SessionAnalysis {
  Id session{};
  std::string subject;
  std::string protocol;
  std::string software_version;
  std::uint64_t seed = 0;
  std::uint32_t trials = 0;    ///< That count.
  std::uint32_t rejected = 0;  ///< Attempts that do not.
  bool is_loaded = false;
  bool is_simulated = false;                  ///< By every description of its rig, driver "simulated".
  std::vector<ConditionAnalysis> conditions;  ///< By posture, then set.
};

/// The trials with a valid verdict, converted, by condition: of unloaded sessions one a posture, of loaded
/// ones each set. kDataLoss: samples are missing or damaged.
[[nodiscard]] Result<std::map<identification::Condition, std::vector<impedance::Trial>>> condition_trials(
    store::Store& store, const store::Session& session);

/// Every trial with a valid verdict, converted and identified as the streaming service does it: by each
/// published method with the linear model, and by state-variable filtering with each other model. Unloaded
/// sessions have one condition a posture; in loaded ones each set is one. kDataLoss: samples are missing or
/// damaged.
[[nodiscard]] Result<SessionAnalysis> analyse(store::Store& store, const store::Session& session);

}  // namespace tonus::study
