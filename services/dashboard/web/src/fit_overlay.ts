// What an estimate says the force of a trial should have been, to be laid over the measured one. Pure.

import type { Course } from "./trial_recorder";

/// Of one fit, row by row: xx, xy, yx, yy.
export interface FittedMatrices {
  M: readonly number[];
  B: readonly number[];
  K: readonly number[];
}

export interface Fit {
  force: [number[], number[]];
  /// Measured less fitted.
  residual: [number[], number[]];
}

const HALF_WINDOW_S = 0.03; // of the parabola that gives velocity and acceleration

/// F = M a + B v + K x + f0 with x from where the hand was at the onset and f0, the mean measured force before it. Velocity
/// and acceleration are those of the parabola through the displacement of 0.03 s before and after. NaN where the course has
/// too few samples for one.
export function fitOf(course: Course, matrices: FittedMatrices): Fit {
  const before = course.times.map((time) => time < 0);
  const rest = course.force.map((series) => mean(series.filter((_, i) => before[i]))) as [number, number];
  const motion = course.displacement.map((series) => motionOf(course.times, series));
  const { M, B, K } = matrices;
  const fitted = (row: 0 | 1): number[] =>
    course.times.map((_, i) =>
      [0, 1].reduce((sum, column) => {
        const at = 2 * row + column;
        const { velocity, acceleration } = motion[column]!;
        return sum + M[at]! * acceleration[i]! + B[at]! * velocity[i]! + K[at]! * course.displacement[column as 0 | 1][i]!;
      }, rest[row]),
    );
  const force: [number[], number[]] = [fitted(0), fitted(1)];
  const residual = force.map((series, axis) => series.map((value, i) => course.force[axis as 0 | 1][i]! - value)) as [number[], number[]];
  return { force, residual };
}

/// Of the residual over both axes; NaN where nothing of it is known.
export function rootMeanSquare([x, y]: [number[], number[]]): number {
  const known = x.map((value, i) => value * value + y[i]! * y[i]!).filter(Number.isFinite);
  return known.length > 0 ? Math.sqrt(mean(known)) : NaN;
}

const mean = (values: number[]): number => (values.length > 0 ? values.reduce((sum, value) => sum + value, 0) / values.length : 0);

function motionOf(times: readonly number[], series: readonly number[]): { velocity: number[]; acceleration: number[] } {
  const velocity: number[] = [];
  const acceleration: number[] = [];
  let first = 0;
  let last = 0;
  for (const [i, time] of times.entries()) {
    while (times[first]! < time - HALF_WINDOW_S) ++first;
    while (last < times.length && times[last]! <= time + HALF_WINDOW_S) ++last;
    const [slope, curvature] = parabola(times, series, first, last, time);
    velocity[i] = slope;
    acceleration[i] = 2 * curvature;
  }
  return { velocity, acceleration };
}

/// Slope and quadratic coefficient at `at` of the least-squares parabola through rows first .. last - 1.
function parabola(times: readonly number[], series: readonly number[], first: number, last: number, at: number): [number, number] {
  const s = [0, 0, 0, 0, 0]; // sums of powers of the time
  const m = [0, 0, 0]; // and of their products with the value
  for (let i = first; i < last; ++i) {
    const t = (times[i]! - at) / HALF_WINDOW_S;
    let power = 1;
    for (let k = 0; k < 5; ++k) {
      s[k]! += power;
      if (k < 3) m[k]! += power * series[i]!;
      power *= t;
    }
  }
  const [s0, s1, s2, s3, s4] = s as [number, number, number, number, number];
  const [m0, m1, m2] = m as [number, number, number];
  const determinant = s0 * (s2 * s4 - s3 * s3) - s1 * (s1 * s4 - s2 * s3) + s2 * (s1 * s3 - s2 * s2);
  if (last - first < 3 || !(Math.abs(determinant) > 1e-9)) return [NaN, NaN];
  const slope = (s0 * (m1 * s4 - s3 * m2) - m0 * (s1 * s4 - s2 * s3) + s2 * (s1 * m2 - s2 * m1)) / determinant;
  const curvature = (s0 * (s2 * m2 - s3 * m1) - s1 * (s1 * m2 - s2 * m1) + m0 * (s1 * s3 - s2 * s2)) / determinant;
  return [slope / HALF_WINDOW_S, curvature / (HALF_WINDOW_S * HALF_WINDOW_S)];
}
