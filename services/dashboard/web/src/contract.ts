// The messages that the pages read, as omgidl-serialization decodes them: 64-bit integers are bigint, octet[16]
// is a Uint8Array, enumerations are numbers. Units are in the names; the contract is in idl/.

export type Id = Uint8Array;

export interface RigDescription {
  rig_id: Id;
  name: string;
  driver: string;
  kind: number;
  link_lengths_m: Float64Array;
  encoder_counts_per_unit: Float64Array;
  encoder_zero_count: Float64Array;
  encoder_sign: Float64Array;
  force_calibration_N_per_V: Float64Array;
  force_offset_V: Float64Array;
  force_sensor_angle_rad: number;
  home_m: Float64Array;
  sample_rate_Hz: number;
  displacement_unit: string;
  force_unit: string;
}

export interface RigState {
  rig_id: Id;
  epoch: bigint;
  mode: number;
  next_sequence: bigint;
  received_through: bigint;
  spool_bytes: bigint;
  fault_bits: number;
  fault: string;
  overruns: bigint;
  dropped_samples: bigint;
  is_realtime_paced: boolean;
}

export interface RigSample {
  acquisition_ns: bigint;
  encoder_count: Float64Array;
  force_V: Float64Array;
  commanded_m: Float64Array;
  phase: number;
  flags: number;
}

export interface SampleBlock {
  trial_id: Id;
  epoch: bigint;
  first_sequence: bigint;
  is_resent: boolean;
  samples: RigSample[];
}

export interface ServiceHealth {
  instance_id: Id;
  role: number;
  name: string;
  is_ready: boolean;
  state: string;
  software_version: string;
  vendor: string;
  process_id: bigint;
  lag_s: number;
  queue_depth: bigint;
  dropped: bigint;
  is_leaving: boolean;
}

export interface SessionPlan {
  session_id: Id;
  subject: string;
  protocol_name: string;
  planned_trials: number;
  postures: { name: string; position_m: Float64Array; trials: number }[];
  started_at: string;
}

export interface SessionState {
  session_id: Id;
  phase: number;
  waiting_for: string;
  message: string;
  posture: string;
  trial_id: Id;
  attempts: number;
  counted: number;
  rejected: number;
  planned: number;
  remaining_s: number;
  experiment_s: number;
}

export interface SessionCue {
  session_id: Id;
  target_m: Float64Array;
  target_diameter_m: number;
  instruction: string;
  shows_cursor: boolean;
}

export interface TrialProgram {
  session_id: Id;
  attempt: number;
  posture: string;
  posture_m: Float64Array;
  shoulder_origin_m: Float64Array;
  shoulder_angle_rad: number;
  set_number: number;
  instruction: string;
  direction_deg: number;
  amplitude_m: number;
  bias_N: Float64Array;
  recording_index: number;
}

export interface TrialOutcome {
  trial_id: Id;
  program: TrialProgram;
  end: number;
  detail: string;
}

export interface TrialVerdict {
  trial_id: Id;
  session_id: Id;
  attempt: number;
  posture_index: number;
  is_valid: boolean;
  detail: string;
}

export interface MatrixEstimate {
  value: Float64Array;
  standard_error: Float64Array;
  low95: Float64Array;
  high95: Float64Array;
  has_ellipse: boolean;
  size: number;
  shape: number;
  orientation_deg: number;
  curl: number;
}

export interface VectorEstimate {
  value: Float64Array;
  standard_error: Float64Array;
  low95: Float64Array;
  high95: Float64Array;
}

export interface Estimate {
  estimate_id: Id;
  session_id: Id;
  posture: string;
  posture_index: number;
  posture_m: Float64Array;
  bias_N: Float64Array;
  set_number: number;
  instruction: string;
  method: string;
  model: string;
  axes: number;
  displacement_unit: string;
  force_unit: string;
  status: number;
  reasons: string[];
  trials_used: number;
  trials_rejected: number;
  samples: bigint;
  mass_kg: MatrixEstimate;
  damping_Ns_per_m: MatrixEstimate;
  stiffness_N_per_m: MatrixEstimate;
  spring_centre_m: VectorEstimate;
  sigma_N: Float64Array;
  condition_number: number;
  settled_s: number;
}

export interface GatewayStatus {
  utc_ns: number;
  clients: { id: number; peer: string; role: string; thinned: number; waiting_messages: number }[];
  thinned: number;
  arrival_drops: number;
}

export interface OperatorReply {
  request_id: string;
  request: string;
  is_done: boolean;
  message: string;
  requested_by: string;
}

export const roleNames = ["rig", "scheduler", "identification", "archive", "dashboard", "operator"];
export const modeNames = ["starting", "idle", "in trial", "fault"];
export const trialPhaseNames = [
  "between trials",
  "coming to the target",
  "waiting at rest",
  "bias force rising",
  "holding against the bias force",
  "perturbation",
  "returning",
  "stopped, safe",
];
export const phaseNames = [
  "preparing",
  "ready",
  "running",
  "pausing",
  "paused",
  "waiting",
  "completing",
  "completed",
  "aborted",
  "failed",
];
export const endNames = [
  "completed",
  "aborted",
  "faulted",
  "not centred",
  "bias not reached",
  "refused",
  "broken off",
];
export const statusNames = ["ok", "undetermined", "suspect"];

/// session/state's phases that the pages act on, of `phaseNames`.
export const PAUSING = 3;
export const PAUSED = 4;
export const WAITING = 5;
export const COMPLETING = 6;
export const FAILED = 9;
/// rig/state's modes, of `modeNames`.
export const IN_TRIAL = 2;
export const IN_FAULT = 3;

/// Phases in which a session still goes on.
export const isActive = (phase: number): boolean => phase <= COMPLETING;

export const hex = (id: Id): string => Array.from(id, (octet) => octet.toString(16).padStart(2, "0")).join("");
