// Size, shape, orientation and curl of a matrix with their 95 % intervals. The values are the estimate's own; the intervals
// are of first order in the elements' standard errors, which are taken as independent, with the quantile of the elements' own
// intervals.

import type { MatrixEstimate } from "./contract";
import { quantileOf } from "./matrices";

/// As analysis_service/impedance/ellipse.hpp defines them: size pi l1 l2 (unit squared), shape l2/l1, orientation of l2's
/// eigenvector in deg, curl |za| / sqrt(l1 l2).
export interface EllipseNumbers {
  size: number;
  shape: number;
  orientation_deg: number;
  curl: number;
}

export const ellipseNumberNames = ["size", "shape", "orientation_deg", "curl"] as const;

/// Of the elements xx, xy, yx, yy; undefined where the symmetric part is not positive definite.
export function numbersOfElements([xx, xy, yx, yy]: readonly [number, number, number, number]): EllipseNumbers | undefined {
  const off = (xy + yx) / 2;
  const root = Math.hypot(xx - yy, 2 * off);
  const major = (xx + yy + root) / 2;
  const minor = (xx * yy - off * off) / major;
  if (!(major > 0) || !(minor > 0)) return undefined;
  return {
    size: Math.PI * minor * major,
    shape: major / minor,
    orientation_deg: (90 / Math.PI) * Math.atan2(2 * off, xx - yy),
    curl: Math.abs(xy - yx) / 2 / Math.sqrt(minor * major),
  };
}

/// Half widths of the 95 % intervals; NaN where an error is not known or the number has no derivative there.
export function halfWidthsOf(matrix: MatrixEstimate): EllipseNumbers {
  const sums: EllipseNumbers = { size: 0, shape: 0, orientation_deg: 0, curl: 0 };
  const value = [0, 1, 2, 3].map((i) => matrix.value[i]!);
  const scale = Math.max(...value.map(Math.abs));
  const step = 1e-5 * scale;
  for (const i of [0, 1, 2, 3]) {
    const [above, below] = [step, -step].map((by) => numbersOfElements(value.map((v, j) => (j === i ? v + by : v)) as [number, number, number, number]));
    for (const name of ellipseNumberNames) {
      let change = above && below ? above[name] - below[name] : NaN;
      if (name === "orientation_deg") change -= 180 * Math.round(change / 180);
      sums[name] += ((change / (2 * step)) * matrix.standard_error[i]!) ** 2;
    }
  }
  const quantile = quantileOf(matrix);
  for (const name of ellipseNumberNames) sums[name] = quantile * Math.sqrt(sums[name]);
  return sums;
}

/// Half of the widest 95 % interval of an element, as a share of the largest element: how well the matrix is known.
export function relativeHalfWidth(matrix: MatrixEstimate, elements: readonly number[]): number {
  const largest = Math.max(...elements.map((i) => Math.abs(matrix.value[i]!)));
  const widest = Math.max(...elements.map((i) => (matrix.high95[i]! - matrix.low95[i]!) / 2));
  return widest / largest;
}
