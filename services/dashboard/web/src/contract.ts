// Generated from idl/*.idl by generate_contract.mjs; do not edit. 64-bit integers are bigint; units are in the names.

export const ReceiptKind = {
  RECEIPT_STREAM: 0,
  RECEIPT_TRIAL: 1,
  RECEIPT_SESSION: 2,
} as const;
export type ReceiptKind = (typeof ReceiptKind)[keyof typeof ReceiptKind];

export interface ArchiveReceipt {
  subject_id: Uint8Array;
  kind: ReceiptKind;
  rig_id: Uint8Array;
  session_id: Uint8Array;
  epoch: bigint;
  through_sequence: bigint;
  expected_samples: bigint;
  received_samples: bigint;
  resent_samples: bigint;
  duplicated_samples: bigint;
  missing_samples: bigint;
}

export interface ArchiveResend {
  rig_id: Uint8Array;
  epoch: bigint;
  first_sequence: bigint;
  last_sequence: bigint;
  requested_by: string;
}

export interface MatrixEstimate {
  value: Float64Array;
  standard_error: Float64Array;
  covariance: Float64Array;
  known_bias: Float64Array;
  low95: Float64Array;
  high95: Float64Array;
  has_ellipse: boolean;
  size: number;
  shape: number;
  orientation_deg: number;
  curl: number;
  size_low95: number;
  size_high95: number;
  shape_low95: number;
  shape_high95: number;
  orientation_low95_deg: number;
  orientation_high95_deg: number;
  curl_low95: number;
  curl_high95: number;
}

export interface VectorEstimate {
  value: Float64Array;
  standard_error: Float64Array;
  covariance: Float64Array;
  low95: Float64Array;
  high95: Float64Array;
}

export const EstimateStatus = {
  ESTIMATE_OK: 0,
  ESTIMATE_UNDETERMINED: 1,
  ESTIMATE_SUSPECT: 2,
} as const;
export type EstimateStatus = (typeof EstimateStatus)[keyof typeof EstimateStatus];

export const FitTest = {
  FIT_EXPLAINED_SHARE: 0,
  FIT_COHERENCE: 1,
  FIT_STEADINESS: 2,
  FIT_HALVES: 3,
  FIT_BANDS: 4,
  FIT_REFLEX: 5,
  FIT_LAG: 6,
  FIT_UNITS: 7,
  FIT_FRICTION: 8,
  FIT_HARDENING: 9,
  FIT_POSITION: 10,
  FIT_CLIPPING: 11,
  FIT_HELD_SAMPLES: 12,
  FIT_CROSS_CHECK: 13,
  FIT_WIDTH: 14,
} as const;
export type FitTest = (typeof FitTest)[keyof typeof FitTest];

export interface FitCheck {
  test: FitTest;
  value: number;
  limit: number;
  passed: boolean;
}

export interface ModelParameter {
  name: string;
  unit: string;
  value: number;
  standard_error: number;
  low95: number;
  high95: number;
}

export interface TrialRange {
  attempt: number;
  epoch: bigint;
  first_sequence: bigint;
  onset_sequence: bigint;
  last_sequence: bigint;
}

export interface Estimate {
  estimate_id: Uint8Array;
  session_id: Uint8Array;
  rig_id: Uint8Array;
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
  status: EstimateStatus;
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
  degrees_of_freedom: number;
  natural_frequency_Hz: number;
  damping_ratio: number;
  cutoff_Hz: number;
  window_s: number;
  settled_s: number;
  explained_share: number;
  lag_s: Float64Array;
  lag_low95_s: Float64Array;
  lag_high95_s: Float64Array;
  band_low_Hz: number;
  band_high_Hz: number;
  independent_units: number;
  checks: FitCheck[];
  parameters: ModelParameter[];
  prior: string;
  compared_models: string;
  trials: TrialRange[];
}

export const RigKind = {
  RIG_TWO_LINK: 0,
  RIG_CARTESIAN: 1,
  RIG_ONE_AXIS: 2,
} as const;
export type RigKind = (typeof RigKind)[keyof typeof RigKind];

export interface RigLimits {
  workspace_centre_m: Float64Array;
  workspace_radius_m: number;
  force_N: number;
}

export interface AuxiliaryChannel {
  name: string;
  type: string;
  unit: string;
  unit_per_value: number;
  values_per_sample: number;
}

export interface RigDescription {
  rig_id: Uint8Array;
  name: string;
  driver: string;
  kind: RigKind;
  link_lengths_m: Float64Array;
  encoder_counts_per_unit: Float64Array;
  encoder_zero_count: Float64Array;
  encoder_sign: Float64Array;
  force_calibration_N_per_V: Float64Array;
  force_offset_V: Float64Array;
  force_sensor_angle_rad: number;
  force_saturation_V: number;
  handle_mass_kg: number;
  home_m: Float64Array;
  loop_rate_Hz: number;
  sample_rate_Hz: number;
  displacement_unit: string;
  force_unit: string;
  calibrated_at: string;
  calibrated_by: string;
  calibration_toml: string;
  moves_nothing_real: boolean;
  resumes_unattended: boolean;
  watchdog_s: number;
  limits_off: string[];
  limits: RigLimits[];
  auxiliary_channels: AuxiliaryChannel[];
  marks_onset: boolean;
}

export const RigMode = {
  RIG_STARTING: 0,
  RIG_FREE: 1,
  RIG_ARMED: 2,
  RIG_IN_TRIAL: 3,
  RIG_HELD: 4,
} as const;
export type RigMode = (typeof RigMode)[keyof typeof RigMode];

export interface RigState {
  rig_id: Uint8Array;
  epoch: bigint;
  mode: RigMode;
  trial_id: Uint8Array;
  session_id: Uint8Array;
  hold_number: number;
  held_because: string;
  next_sequence: bigint;
  received_through: bigint;
  spool_bytes: bigint;
  fault_bits: number;
  fault: string;
  overruns: bigint;
  dropped_samples: bigint;
  is_realtime_paced: boolean;
  rig_clock_ns: bigint;
}

export const TrialPhase = {
  PHASE_IDLE: 0,
  PHASE_CENTRING: 1,
  PHASE_WAITING: 2,
  PHASE_BIAS_RAMP: 3,
  PHASE_BIAS_HOLD: 4,
  PHASE_PERTURBING: 5,
  PHASE_RETURNING: 6,
  PHASE_SAFE: 7,
} as const;
export type TrialPhase = (typeof TrialPhase)[keyof typeof TrialPhase];

export interface RigSample {
  acquisition_ns: bigint;
  encoder_count: Float64Array;
  force_V: Float64Array;
  commanded_m: Float64Array;
  phase: number;
  flags: number;
}

export interface SampleBlock {
  rig_id: Uint8Array;
  session_id: Uint8Array;
  trial_id: Uint8Array;
  epoch: bigint;
  first_sequence: bigint;
  is_resent: boolean;
  send_ns: bigint;
  samples: RigSample[];
}

export interface AuxiliaryBlock {
  rig_id: Uint8Array;
  session_id: Uint8Array;
  trial_id: Uint8Array;
  epoch: bigint;
  first_sequence: bigint;
  sample_count: number;
  is_resent: boolean;
  values: Float32Array;
}

export interface RigTiming {
  rig_id: Uint8Array;
  epoch: bigint;
  scheduling: string;
  period_s: number;
  cycles: bigint;
  overruns: bigint;
  missed_periods: bigint;
  worst_lateness_ns: bigint;
  lateness_count: BigUint64Array;
}

export interface FlightCycle {
  cycle: bigint;
  now_ns: bigint;
  encoder_count: Float64Array;
  force_V: Float64Array;
  position_m: Float64Array;
  velocity_m_per_s: Float64Array;
  force_N: Float64Array;
  reference_m: Float64Array;
  torque_Nm: Float64Array;
  fault_bits: number;
  missed_periods: number;
  phase: number;
}

export interface FlightRecord {
  part_id: Uint8Array;
  rig_id: Uint8Array;
  epoch: bigint;
  fault_number: number;
  fault: string;
  part: number;
  parts: number;
  cycles: FlightCycle[];
}

export const RigRequest = {
  RIG_EMERGENCY_STOP: 0,
  RIG_CLEAR_FAULT: 1,
  RIG_ABORT_TRIAL: 2,
  RIG_ARM: 3,
  RIG_DISARM: 4,
} as const;
export type RigRequest = (typeof RigRequest)[keyof typeof RigRequest];

export interface RigCommand {
  rig_id: Uint8Array;
  request_id: Uint8Array;
  request: RigRequest;
  trial_id: Uint8Array;
  session_id: Uint8Array;
  epoch: bigint;
  hold_number: number;
  requested_by: string;
}

export interface RigStop {
  rig_id: Uint8Array;
  stop_id: Uint8Array;
  number: number;
  requested_by: string;
}

export interface RigLease {
  rig_id: Uint8Array;
  session_id: Uint8Array;
  epoch: bigint;
  number: bigint;
}

export interface RigReply {
  rig_id: Uint8Array;
  request_id: Uint8Array;
  is_done: boolean;
  message: string;
  rig_clock_ns: bigint;
}

export const Constants = {
  SAMPLE_SATURATED: 1,
  SAMPLE_MISSING: 2,
} as const;
export type Constants = (typeof Constants)[keyof typeof Constants];

export const ServiceRole = {
  ROLE_RIG: 0,
  ROLE_SCHEDULER: 1,
  ROLE_IDENTIFICATION: 2,
  ROLE_ARCHIVE: 3,
  ROLE_DASHBOARD: 4,
  ROLE_OPERATOR: 5,
} as const;
export type ServiceRole = (typeof ServiceRole)[keyof typeof ServiceRole];

export interface ServiceHealth {
  instance_id: Uint8Array;
  role: ServiceRole;
  name: string;
  host: string;
  is_ready: boolean;
  state: string;
  warnings: string[];
  idl_hash: Uint8Array;
  software_version: string;
  vendor: string;
  started_ns: bigint;
  process_id: bigint;
  lag_s: number;
  queue_depth: bigint;
  dropped: bigint;
  is_leaving: boolean;
}

export interface ServiceConfiguration {
  instance_id: Uint8Array;
  role: ServiceRole;
  name: string;
  software_version: string;
  build: string;
  configuration_toml: string;
  started_ns: bigint;
}

export interface ClockProbe {
  asker_id: Uint8Array;
  answerer_id: Uint8Array;
  number: bigint;
  asked_ns: bigint;
}

export interface ClockEcho {
  asker_id: Uint8Array;
  answerer_id: Uint8Array;
  number: bigint;
  asked_ns: bigint;
  received_ns: bigint;
  answered_ns: bigint;
}

export interface ClockOffset {
  pair_id: Uint8Array;
  asker_id: Uint8Array;
  answerer_id: Uint8Array;
  offset_ns: bigint;
  uncertainty_ns: bigint;
  probes: bigint;
  measured_ns: bigint;
}

export interface PlannedPosture {
  name: string;
  position_m: Float64Array;
  trials: number;
}

export interface SubjectFacts {
  age_years: number;
  sex: string;
  handedness: string;
  measured_arm: string;
  height_m: number;
  weight_kg: number;
  link_lengths_m: Float64Array;
  circumferences_m: Float64Array;
  shoulder_m: Float64Array;
}

export interface SessionPlan {
  session_id: Uint8Array;
  rig_id: Uint8Array;
  subject: string;
  subject_facts: SubjectFacts;
  operator_name: string;
  study: string;
  is_pilot: boolean;
  protocol_name: string;
  protocol_toml: string;
  seed: bigint;
  planned_trials: number;
  postures: PlannedPosture[];
  started_at: string;
  software_version: string;
}

export const SessionPhase = {
  SESSION_PREPARING: 0,
  SESSION_READY: 1,
  SESSION_RUNNING: 2,
  SESSION_PAUSING: 3,
  SESSION_PAUSED: 4,
  SESSION_WAITING: 5,
  SESSION_COMPLETING: 6,
  SESSION_COMPLETED: 7,
  SESSION_ABORTED: 8,
  SESSION_FAILED: 9,
} as const;
export type SessionPhase = (typeof SessionPhase)[keyof typeof SessionPhase];

export interface ConditionProgress {
  posture: string;
  posture_index: number;
  set_number: number;
  instruction: string;
  counted: number;
  planned: number;
  precision: number;
  precision_goal: number;
  is_finished: boolean;
  finished_because: string;
}

export interface SessionState {
  session_id: Uint8Array;
  phase: SessionPhase;
  waiting_for: string;
  message: string;
  posture: string;
  trial_id: Uint8Array;
  attempts: number;
  counted: number;
  rejected: number;
  planned: number;
  remaining_s: number;
  experiment_s: number;
  conditions: ConditionProgress[];
}

export const SessionRequest = {
  SESSION_START: 0,
  SESSION_PAUSE: 1,
  SESSION_RESUME: 2,
  SESSION_ABORT: 3,
  SESSION_REJECT_TRIAL: 4,
  SESSION_NOTE: 5,
} as const;
export type SessionRequest = (typeof SessionRequest)[keyof typeof SessionRequest];

export interface SessionCommand {
  session_id: Uint8Array;
  request_id: Uint8Array;
  request: SessionRequest;
  protocol_toml: string;
  subject: string;
  subject_facts: SubjectFacts;
  study: string;
  is_pilot: boolean;
  seed: bigint;
  trial_id: Uint8Array;
  text: string;
  note_kind: string;
  requested_by: string;
}

export interface SessionReply {
  session_id: Uint8Array;
  request_id: Uint8Array;
  is_done: boolean;
  message: string;
}

export interface SessionNote {
  note_id: Uint8Array;
  session_id: Uint8Array;
  trial_id: Uint8Array;
  kind: string;
  text: string;
  written_by: string;
  written_ns: bigint;
  has_rig_clock: boolean;
  rig_clock_ns: bigint;
  epoch: bigint;
}

export interface SessionCue {
  session_id: Uint8Array;
  target_m: Float64Array;
  target_diameter_m: number;
  instruction: string;
  shows_cursor: boolean;
}

export const TrialKind = {
  TRIAL_PERTURBATION: 0,
  TRIAL_RECORDING: 1,
  TRIAL_CONTRACTION: 2,
} as const;
export type TrialKind = (typeof TrialKind)[keyof typeof TrialKind];

export interface TrialProgram {
  session_id: Uint8Array;
  rig_id: Uint8Array;
  attempt: number;
  planned_index: number;
  kind: TrialKind;
  posture: string;
  posture_index: number;
  posture_m: Float64Array;
  shoulder_origin_m: Float64Array;
  shoulder_angle_rad: number;
  set_number: number;
  instruction: string;
  direction_deg: number;
  amplitude_m: number;
  rise_time_s: number;
  hold_s: number;
  wait_s: number;
  bias_N: Float64Array;
  bias_ramp_s: number;
  bias_hold_s: number;
  bias_threshold_N: number;
  recording_index: number;
  recording_event: number;
}

export interface TrialCommand {
  trial_id: Uint8Array;
  program: TrialProgram;
}

export const TrialEnd = {
  TRIAL_COMPLETED: 0,
  TRIAL_ABORTED: 1,
  TRIAL_FAULTED: 2,
  TRIAL_NOT_CENTRED: 3,
  TRIAL_BIAS_NOT_REACHED: 4,
  TRIAL_REFUSED: 5,
  TRIAL_BROKEN_OFF: 6,
} as const;
export type TrialEnd = (typeof TrialEnd)[keyof typeof TrialEnd];

export interface TrialOutcome {
  trial_id: Uint8Array;
  program: TrialProgram;
  epoch: bigint;
  end: TrialEnd;
  detail: string;
  first_sequence: bigint;
  onset_sequence: bigint;
  last_sequence: bigint;
  sample_rate_Hz: number;
  is_onset_marked: boolean;
  mark_sequence: bigint;
}

export const VerdictReason = {
  REASON_NOT_COMPLETED: 0,
  REASON_OFF_TARGET: 1,
  REASON_BIAS_NOT_REACHED: 2,
  REASON_BIAS_NOT_HELD: 3,
  REASON_EARLY_REACTION: 4,
  REASON_SATURATED: 5,
  REASON_GAP: 6,
  REASON_EXCURSION: 7,
  REASON_NOT_AT_REST: 8,
  REASON_UNKNOWN_RIG: 9,
  REASON_LET_GO: 10,
  REASON_MUSCLES_ACTIVE: 11,
  REASON_REJECTED_BY_HAND: 12,
} as const;
export type VerdictReason = (typeof VerdictReason)[keyof typeof VerdictReason];

export interface MuscleActivity {
  channel: string;
  is_normalised: boolean;
  before_onset: number;
  short_latency: number;
  long_latency: number;
}

export interface TrialVerdict {
  trial_id: Uint8Array;
  session_id: Uint8Array;
  attempt: number;
  planned_index: number;
  posture_index: number;
  is_valid: boolean;
  reasons: Uint32Array;
  detail: string;
  start_offset_m: number;
  rest_speed_m_per_s: number;
  rest_force_N: number;
  excursion_m: number;
  end_speed_m_per_s: number;
  saturated_samples: number;
  missing_samples: number;
  muscles: MuscleActivity[];
  co_contraction: number;
}

export interface TrialReview {
  trial_id: Uint8Array;
  session_id: Uint8Array;
  attempt: number;
  planned_index: number;
  posture_index: number;
  is_rejected: boolean;
  reason: string;
  reviewed_by: string;
  reviewed_ns: bigint;
}
