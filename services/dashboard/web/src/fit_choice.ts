// Which estimate is laid over a trial: the one of its own condition. Pure.

import { EstimateStatus, type Estimate, type TrialProgram } from "./contract";
import { fitOf, type Fit } from "./fit_overlay";
import { hex } from "./names";
import { methodOf } from "./matrices";
import type { Course } from "./trial_recorder";

const USUAL_METHOD = "state_variable";

type Program = Pick<TrialProgram, "session_id" | "posture" | "posture_index" | "instruction" | "set_number" | "bias_N">;

/// The fit of the newest determined estimate of the trial's posture, instruction and bias force; that of all sets where there
/// is one, and by the usual method where there is one. Undefined where none fits.
export function fitFor(estimates: readonly Estimate[], program: Program, course: Course): (Fit & { of: string }) | undefined {
  const estimate = estimates
    .filter((one) => isOf(one, program))
    .sort((a, b) => rank(a) - rank(b) || b.trials_used - a.trials_used)[0];
  if (!estimate) return undefined;
  const matrices = { M: Array.from(estimate.mass_kg.value), B: Array.from(estimate.damping_Ns_per_m.value), K: Array.from(estimate.stiffness_N_per_m.value) };
  return { ...fitOf(course, matrices), of: `the fit of ${methodOf(estimate)} over ${estimate.trials_used} trials` };
}

const rank = (estimate: Estimate): number => (methodOf(estimate) === USUAL_METHOD ? 0 : 2) + (estimate.set_number === 0 ? 0 : 1);

const NEAR_N = 1e-6;

function isOf(estimate: Estimate, program: Program): boolean {
  const isPlace = estimate.posture_index === program.posture_index && estimate.posture === program.posture && estimate.instruction === program.instruction;
  const isSet = estimate.set_number === 0 || estimate.set_number === program.set_number;
  const isBias = [0, 1].every((i) => Math.abs(estimate.bias_N[i]! - program.bias_N[i]!) < NEAR_N);
  return hex(estimate.session_id) === hex(program.session_id) && isPlace && isSet && isBias && estimate.status !== EstimateStatus.ESTIMATE_UNDETERMINED && estimate.axes === 2;
}
