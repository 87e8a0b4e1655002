#include "services/dashboard/gateway/trial_course.hpp"

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <optional>
#include <spdlog/fmt/fmt.h>
#include <vector>

#include "services/contract/rig.hpp"
#include "services/store/archived_trial.hpp"

namespace tonus::dashboard {
namespace {

using nlohmann::json;

constexpr double kBefore = 0.2 + 1e-9;  // s; as exact as the clock
constexpr double kAfter = 1.2 + 1e-9;   // s
constexpr std::size_t kMostPoints = 2000;
constexpr std::size_t kMostBefore = 8;

struct Course {
  json value;
  v1::RigDescription description;
};

bool is_measured(const store::TrialSamples& trial, std::size_t i) {
  return trial.is_there[i] && !contract::flags_of(trial.samples[i]).is_missing;
}

/// The first measured sample of the perturbation.
std::optional<std::size_t> onset_of(const store::TrialSamples& trial) {
  for (std::size_t i = 0; i < trial.samples.size(); ++i)
    if (is_measured(trial, i) && trial.samples[i].phase() == v1::PHASE_PERTURBING) return i;
  return std::nullopt;
}

/// Seconds from one sample to another; finite for any two clocks.
double seconds_between(const v1::RigSample& from, const v1::RigSample& to) {
  return (static_cast<double>(to.acquisition_ns()) - static_cast<double>(from.acquisition_ns())) * 1e-9;
}

json course_json(const store::SessionTrial& trial, const store::TrialSamples& found, std::size_t onset,
                 const store::TrialRig& rig) {
  const auto& at_onset = found.samples[onset];
  const Eigen::Vector2d origin = convert(rig.geometry, rig.shoulder, store::raw_of(at_onset)).p_SE;
  std::vector<std::size_t> rows;
  std::size_t missing = 0;
  for (std::size_t i = 0; i < found.samples.size(); ++i) {
    if (!is_measured(found, i)) {
      ++missing;
      continue;
    }
    const double time = seconds_between(at_onset, found.samples[i]);
    if (time >= -kBefore && time <= kAfter) rows.push_back(i);
  }
  const std::size_t stride = (rows.size() + kMostPoints - 1) / kMostPoints;
  std::vector<double> times;
  std::array<std::vector<double>, 2> displacement;
  std::array<std::vector<double>, 2> force;
  for (std::size_t k = 0; k < rows.size(); k += stride) {
    const auto& sample = found.samples[rows[k]];
    const EndpointSample hand = convert(rig.geometry, rig.shoulder, store::raw_of(sample));
    times.push_back(seconds_between(at_onset, sample));
    for (std::size_t axis = 0; axis < 2; ++axis) {
      const auto i = static_cast<Eigen::Index>(axis);
      displacement[axis].push_back(hand.p_SE[i] - origin[i]);
      force[axis].push_back(hand.f_S[i]);
    }
  }
  return {{"attempt", trial.attempt},     {"posture", trial.record ? trial.record->posture : ""},
          {"missing", missing},           {"times_s", times},
          {"displacement", displacement}, {"force", force}};
}

Result<Course> course_of(store::Store& store, const store::Session& session,
                         const store::SessionTrial& trial) {
  TONUS_TRY_ASSIGN(const store::TrialSamples found, store::read_trial_samples(store, trial));
  const auto onset = onset_of(found);
  if (!onset) {
    return fail(ErrorCode::kNotFound,
                fmt::format("trial {}: store '{}' has no onset of it", trial.attempt, store.name()));
  }
  TONUS_TRY_ASSIGN(const store::TrialRig rig,
                   store::rig_in_force(session, trial, store::recorded_force_sign(session)));
  return Course{course_json(trial, found, *onset, rig), rig.description};
}

}  // namespace

Result<std::string> trial_courses(store::Store& store, const store::Session& session, std::uint32_t attempt) {
  const auto wanted = std::find_if(session.trials.begin(), session.trials.end(),
                                   [attempt](const auto& trial) { return trial.attempt == attempt; });
  if (wanted == session.trials.end()) {
    return fail(ErrorCode::kNotFound,
                fmt::format("session {} has no trial {}", to_hex(session.record.session), attempt));
  }
  TONUS_TRY_ASSIGN(const Course first, course_of(store, session, *wanted));
  json courses = json::array({first.value});
  for (auto before = wanted; before != session.trials.begin() && courses.size() <= kMostBefore;) {
    --before;
    if (const auto course = course_of(store, session, *before)) courses.push_back(course->value);
  }
  const json answer{{"displacement_unit", first.description.displacement_unit()},
                    {"force_unit", first.description.force_unit()},
                    {"courses", courses}};
  return answer.dump(-1, ' ', false, json::error_handler_t::replace);
}

}  // namespace tonus::dashboard
