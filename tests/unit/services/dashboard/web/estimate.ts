import { EstimateStatus, type Estimate, type MatrixEstimate, type VectorEstimate } from "../../../../../services/dashboard/web/src/contract";

/// A symmetric matrix with these semi-axes and direction, known without error.
export function matrix(changes: Partial<MatrixEstimate> = {}): MatrixEstimate {
  return {
    value: new Float64Array([2, 0, 0, 1]),
    standard_error: new Float64Array([0.1, 0.1, 0.1, 0.1]),
    low95: new Float64Array([1.8, -0.2, -0.2, 0.8]),
    high95: new Float64Array([2.2, 0.2, 0.2, 1.2]),
    has_ellipse: true,
    size: 2 * Math.PI,
    shape: 0.5,
    orientation_deg: 0,
    curl: 0,
    ...changes,
  };
}

const vector = (): VectorEstimate => ({
  value: new Float64Array([0.001, -0.002]),
  standard_error: new Float64Array(2),
  low95: new Float64Array(2),
  high95: new Float64Array(2),
});

export function estimate(changes: Partial<Estimate> = {}): Estimate {
  return {
    estimate_id: new Uint8Array(16),
    session_id: new Uint8Array(16),
    rig_id: new Uint8Array(16),
    posture: "distal",
    posture_index: 0,
    posture_m: new Float64Array([0, 0.52]),
    bias_N: new Float64Array(2),
    set_number: 0,
    instruction: "",
    method: "state_variable",
    model: "linear",
    axes: 2,
    displacement_unit: "m",
    force_unit: "N",
    status: EstimateStatus.ESTIMATE_OK,
    reasons: [],
    trials_used: 16,
    trials_rejected: 0,
    samples: 0n,
    mass_kg: matrix(),
    damping_Ns_per_m: matrix(),
    stiffness_N_per_m: matrix(),
    spring_centre_m: vector(),
    sigma_N: new Float64Array([0.1, 0.2]),
    condition_number: 1,
    degrees_of_freedom: 1000,
    natural_frequency_Hz: 10,
    damping_ratio: 0.7,
    cutoff_Hz: 20,
    window_s: 0.3,
    settled_s: 0.3,
    explained_share: 0.99,
    lag_s: new Float64Array(2),
    lag_low95_s: new Float64Array(2),
    lag_high95_s: new Float64Array(2),
    band_low_Hz: 0.5,
    band_high_Hz: 10,
    independent_units: 16,
    checks: [],
    parameters: [],
    compared_models: "",
    trials: [],
    ...changes,
  };
}
