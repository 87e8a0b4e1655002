#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "analysis_service/identification/measured_trial.hpp"
#include "services/store/store.hpp"

#include <idl/estimate.h>
#include <idl/rig.h>
#include <idl/session.h>
#include <idl/trial.h>

/// A whole session with trials of closed form, as an archive would hold it after a run.
namespace tonus::made_up {

/// The rig that the made-up trials are measured with.
[[nodiscard]] v1::RigDescription made_up_description();

struct SessionRecipe {
  std::vector<identification::MeasuredTrial> trials;
  bool is_over = true;
  std::uint32_t rejected_attempt = 0;  ///< This one was broken off by the rig; 0: none.
  std::uint32_t reviewed_attempt = 0;  ///< An operator rejected this one by hand, after the last; 0: none.
  std::vector<v1::SessionNote> notes;  ///< Of the session; ids and session are filled in.
  std::function<void(v1::SessionPlan&)> set_plan;          ///< Before it is archived.
  std::function<void(v1::Estimate&)> spoil_estimate;       ///< Before it is archived.
  std::function<void(v1::TrialVerdict&)> spoil_verdict;    ///< Likewise.
  std::function<bool(std::uint64_t first)> is_block_lost;  ///< By its first sample.
  std::function<void(store::Batch&)> spoil_batch;          ///< All, before it is archived.
  std::uint64_t received_ns = 1'700'000'000'000'000'000;
};

/// 16 perturbations, every 45 deg in two sets: samples 1000 to 11399, 650 a trial.
[[nodiscard]] SessionRecipe unloaded_session();

/// Plan, description, commands, samples, outcomes, and the verdicts and estimates of an identification core
/// that was fed with the trials directly. Returns the session's record.
store::SessionRecord put_session(store::Store& store, SessionRecipe recipe);

}  // namespace tonus::made_up
