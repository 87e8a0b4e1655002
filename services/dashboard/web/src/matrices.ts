// The three matrices of an estimate, and what is drawn of them.

import type { Estimate, MatrixEstimate } from "./contract";

export type MatrixName = "M" | "B" | "K";

export const matrixNames: MatrixName[] = ["M", "B", "K"];
export const matrixTitles: Record<MatrixName, string> = { M: "Mass M", B: "Damping B", K: "Stiffness K" };
export const elementNames = ["xx", "xy", "yx", "yy"];

export function matrixOf(estimate: Estimate, name: MatrixName): MatrixEstimate {
  switch (name) {
    case "M":
      return estimate.mass_kg;
    case "B":
      return estimate.damping_Ns_per_m;
    case "K":
      return estimate.stiffness_N_per_m;
  }
}

/// As matrix_units() in services/contract/rig.cpp; one file of cases holds both.
export function unitOf(estimate: Estimate, name: MatrixName): string {
  const force = estimate.force_unit || "N";
  const displacement = estimate.displacement_unit || "m";
  if (force === "N" && displacement === "m") return { M: "kg", B: "N s/m", K: "N/m" }[name];
  if (force === "N m" && displacement === "rad") return { M: "kg m2", B: "N m s/rad", K: "N m/rad" }[name];
  return { M: `${force} s2/${displacement}`, B: `${force} s/${displacement}`, K: `${force}/${displacement}` }[name];
}

/// Elements in use: all four, or the first one of a one-axis rig.
export const elementsOf = (estimate: Estimate): number[] => (estimate.axes === 1 ? [0] : [0, 1, 2, 3]);

/// Semi-axes in the matrix's unit, direction of the major one in rad, counter-clockwise.
export interface Ellipse {
  major: number;
  minor: number;
  angle: number;
}

/// The ellipse of the matrix: from size (pi l1 l2) and shape, the ratio of the semi-axes, whichever way round.
export function ellipseOf(matrix: MatrixEstimate): Ellipse | undefined {
  if (!matrix.has_ellipse || !(matrix.size > 0) || !(matrix.shape > 0)) return undefined;
  const one = Math.sqrt(matrix.size / (Math.PI * matrix.shape));
  const other = matrix.shape * one;
  return { major: Math.max(one, other), minor: Math.min(one, other), angle: (matrix.orientation_deg * Math.PI) / 180 };
}

/// Ellipses with each semi-axis at the ends of its 95 % interval. First order in the elements' errors, with
/// their covariance where it is known, else taken as independent; the quantile is the one that the elements' own intervals were made with.
export function bandOf(matrix: MatrixEstimate): { inner: Ellipse; outer: Ellipse } | undefined {
  const ellipse = ellipseOf(matrix);
  if (!ellipse) return undefined;
  const quantile = quantileOf(matrix);
  const spread = (angle: number): number => {
    const [c, s] = [Math.cos(angle), Math.sin(angle)];
    const weights = [c * c, c * s, c * s, s * s];
    return quantile * Math.sqrt(variance(matrix, weights));
  };
  const major = spread(ellipse.angle);
  const minor = spread(ellipse.angle + Math.PI / 2);
  if (!Number.isFinite(major) || !Number.isFinite(minor)) return undefined;
  return {
    inner: {
      major: Math.max(0, ellipse.major - major),
      minor: Math.max(0, ellipse.minor - minor),
      angle: ellipse.angle,
    },
    outer: { major: ellipse.major + major, minor: ellipse.minor + minor, angle: ellipse.angle },
  };
}

/// Of a weighted sum of the elements.
function variance({ covariance, standard_error }: MatrixEstimate, weights: readonly number[]): number {
  const isKnown = covariance.every(Number.isFinite) && covariance.some((value) => value !== 0);
  const sum = weights.reduce((all, a, i) => all + weights.reduce((row, b, j) => row + a * b * (isKnown ? covariance[4 * i + j]! : i === j ? standard_error[i]! ** 2 : 0), 0), 0);
  return Math.max(0, sum);
}

/// Of the 95 % intervals: half width over standard error.
export function quantileOf(matrix: MatrixEstimate): number {
  const i = matrix.standard_error.findIndex((error) => error > 0);
  return i < 0 ? 1.96 : (matrix.high95[i]! - matrix.low95[i]!) / (2 * matrix.standard_error[i]!);
}

/// What estimates of one condition have in common, whatever their method.
export function conditionOf(estimate: Estimate): string {
  const bias = estimate.bias_N;
  const parts = [postureOf(estimate)];
  if (Math.hypot(bias[0]!, bias[1]!) > 0) parts.push(`bias ${bias[0]!.toFixed(1)}, ${bias[1]!.toFixed(1)} N`);
  if (estimate.set_number !== 0) parts.push(`set ${estimate.set_number}`);
  if (estimate.instruction) parts.push(`“${estimate.instruction}”`);
  return parts.join(", ");
}

export const postureOf = (estimate: Estimate): string => estimate.posture || `posture ${estimate.posture_index + 1}`;

/// Of all sets of a condition together, as against one set of them.
export const isWhole = (estimate: Estimate): boolean => estimate.set_number === 0;

/// There are six colours; what comes after begins anew.
export const toneClass = (tone: number): string => `tone-${tone % 6}`;

export function methodOf(estimate: Estimate): string {
  return estimate.model && estimate.model !== "linear" ? `${estimate.method} (${estimate.model})` : estimate.method;
}

export function inOrder(a: Estimate, b: Estimate): number {
  return (
    a.posture_index - b.posture_index ||
    conditionOf(a).localeCompare(conditionOf(b), "en", { numeric: true }) ||
    methodOf(a).localeCompare(methodOf(b))
  );
}

/// As many digits as a standard error makes sense of: two of its own.
export function withError(value: number, error: number): string {
  if (!Number.isFinite(value)) return "–";
  if (!(error > 0) || !Number.isFinite(error)) return value.toPrecision(4);
  const digits = Math.max(0, Math.min(6, 1 - Math.floor(Math.log10(error))));
  return `${value.toFixed(digits)} ± ${error.toFixed(digits)}`;
}
