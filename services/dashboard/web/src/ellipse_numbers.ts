// Size, shape, orientation and curl of a matrix with their 95 % intervals, as the estimate has them.

import type { MatrixEstimate } from "./contract";

/// As analysis_service/impedance/ellipse.hpp defines them: size pi l1 l2 (unit squared), shape l2/l1, orientation of l2's
/// eigenvector in deg, curl |za| / sqrt(l1 l2).
export const ellipseNumberNames = ["size", "shape", "orientation_deg", "curl"] as const;
export type EllipseNumber = (typeof ellipseNumberNames)[number];

/// Low and high; undefined where it is not known.
export function intervalOf(matrix: MatrixEstimate, name: EllipseNumber): [number, number] | undefined {
  const intervals: Record<EllipseNumber, [number, number]> = {
    size: [matrix.size_low95, matrix.size_high95],
    shape: [matrix.shape_low95, matrix.shape_high95],
    orientation_deg: [matrix.orientation_low95_deg, matrix.orientation_high95_deg],
    curl: [matrix.curl_low95, matrix.curl_high95],
  };
  return intervals[name].every(Number.isFinite) ? intervals[name] : undefined;
}

const MOST_DECIMALS = 6;
const USUAL_DIGITS = 4;

/// "0.84 [0.79, 0.90]", with two digits of the interval's half width; the value alone where there is no interval.
export function withInterval(value: number, interval: [number, number] | undefined): string {
  if (!Number.isFinite(value)) return "–";
  if (!interval) return value.toPrecision(USUAL_DIGITS);
  const half = (interval[1] - interval[0]) / 2;
  const decimals = half > 0 ? Math.max(0, Math.min(MOST_DECIMALS, 1 - Math.floor(Math.log10(half)))) : USUAL_DIGITS;
  const [shown, low, high] = [value, ...interval].map((number) => number.toFixed(decimals));
  return `${shown} [${low}, ${high}]`;
}

/// Half of the widest 95 % interval of an element, as a share of the largest element: how well the matrix is known.
export function relativeHalfWidth(matrix: MatrixEstimate, elements: readonly number[]): number {
  const largest = Math.max(...elements.map((i) => Math.abs(matrix.value[i]!)));
  const widest = Math.max(...elements.map((i) => (matrix.high95[i]! - matrix.low95[i]!) / 2));
  return widest / largest;
}
