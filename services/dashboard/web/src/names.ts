// What people read for the contract's states; the one table of the pages. The compiler refuses a missing entry.

import { EstimateStatus, RigMode, ServiceRole, SessionPhase, TrialEnd, TrialPhase } from "./contract";

export const roleNames: Record<ServiceRole, string> = {
  [ServiceRole.ROLE_RIG]: "rig",
  [ServiceRole.ROLE_SCHEDULER]: "scheduler",
  [ServiceRole.ROLE_IDENTIFICATION]: "identification",
  [ServiceRole.ROLE_ARCHIVE]: "archive",
  [ServiceRole.ROLE_DASHBOARD]: "dashboard",
  [ServiceRole.ROLE_OPERATOR]: "operator",
};

export const modeNames: Record<RigMode, string> = {
  [RigMode.RIG_STARTING]: "starting",
  [RigMode.RIG_FREE]: "free",
  [RigMode.RIG_ARMED]: "armed",
  [RigMode.RIG_IN_TRIAL]: "in trial",
  [RigMode.RIG_HELD]: "held",
};

export const trialPhaseNames: Record<TrialPhase, string> = {
  [TrialPhase.PHASE_IDLE]: "between trials",
  [TrialPhase.PHASE_CENTRING]: "moving to the target",
  [TrialPhase.PHASE_WAITING]: "waiting at rest",
  [TrialPhase.PHASE_BIAS_RAMP]: "bias force rising",
  [TrialPhase.PHASE_BIAS_HOLD]: "holding against the bias force",
  [TrialPhase.PHASE_PERTURBING]: "perturbation",
  [TrialPhase.PHASE_RETURNING]: "returning",
  [TrialPhase.PHASE_SAFE]: "stopped, safe",
};

export const sessionPhaseNames: Record<SessionPhase, string> = {
  [SessionPhase.SESSION_PREPARING]: "preparing",
  [SessionPhase.SESSION_READY]: "ready",
  [SessionPhase.SESSION_RUNNING]: "running",
  [SessionPhase.SESSION_PAUSING]: "pausing",
  [SessionPhase.SESSION_PAUSED]: "paused",
  [SessionPhase.SESSION_WAITING]: "waiting",
  [SessionPhase.SESSION_COMPLETING]: "completing",
  [SessionPhase.SESSION_COMPLETED]: "completed",
  [SessionPhase.SESSION_ABORTED]: "aborted",
  [SessionPhase.SESSION_FAILED]: "failed",
};

export const endNames: Record<TrialEnd, string> = {
  [TrialEnd.TRIAL_COMPLETED]: "completed",
  [TrialEnd.TRIAL_ABORTED]: "aborted",
  [TrialEnd.TRIAL_FAULTED]: "faulted",
  [TrialEnd.TRIAL_NOT_CENTRED]: "not centred",
  [TrialEnd.TRIAL_BIAS_NOT_REACHED]: "bias not reached",
  [TrialEnd.TRIAL_REFUSED]: "refused",
  [TrialEnd.TRIAL_BROKEN_OFF]: "broken off",
};

export const statusNames: Record<EstimateStatus, string> = {
  [EstimateStatus.ESTIMATE_OK]: "ok",
  [EstimateStatus.ESTIMATE_UNDETERMINED]: "undetermined",
  [EstimateStatus.ESTIMATE_SUSPECT]: "suspect",
};

/// The name of a value that came over the wire; "?" where this build does not know it.
export const nameOf = (names: Readonly<Record<number, string>>, value: number): string => names[value] ?? "?";

const endedPhases: readonly SessionPhase[] = [
  SessionPhase.SESSION_COMPLETED,
  SessionPhase.SESSION_ABORTED,
  SessionPhase.SESSION_FAILED,
];

/// Whether a session in this phase has not ended.
export const isActive = (phase: SessionPhase): boolean => !endedPhases.includes(phase);

/// An id as the command line and the archive write it: 32 hexadecimal digits.
export const hex = (id: Uint8Array): string => Array.from(id, (byte) => byte.toString(16).padStart(2, "0")).join("");
