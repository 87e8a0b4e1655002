import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";
import {
  bandOf,
  conditionOf,
  ellipseOf,
  inOrder,
  toneClass,
  unitOf,
  withError,
} from "../../../../../services/dashboard/web/src/matrices";
import { postureTones } from "../../../../../services/dashboard/web/src/posture_style";
import { estimate, matrix } from "./estimate";

const close = (actual: number, expected: number): void => assert.ok(Math.abs(actual - expected) < 1e-12, `${actual} is not ${expected}`);

test("the ellipse has the semi-axes whose product is size / pi and whose ratio is the shape", () => {
  const ellipse = ellipseOf(matrix({ size: 6 * Math.PI, shape: 2 / 3, orientation_deg: 90 }))!;
  close(ellipse.major, 3);
  close(ellipse.minor, 2);
  close(ellipse.angle, Math.PI / 2);
});

test("a ratio above one is the same ellipse", () => {
  const ellipse = ellipseOf(matrix({ size: 6 * Math.PI, shape: 1.5 }))!;
  close(ellipse.major, 3);
  close(ellipse.minor, 2);
});

test("a matrix that is not positive definite has no ellipse", () => {
  assert.equal(ellipseOf(matrix({ has_ellipse: false })), undefined);
  assert.equal(bandOf(matrix({ has_ellipse: false })), undefined);
});

test("the band's semi-axes end where the intervals of the diagonal do, for axes along x and y", () => {
  const band = bandOf(matrix())!; // the interval of xx is 1.8 to 2.2, that of yy 0.8 to 1.2
  close(band.inner.major, 1.8);
  close(band.outer.major, 2.2);
  close(band.inner.minor, 0.8);
  close(band.outer.minor, 1.2);
});

test("turned by 45 degrees all four errors share in each semi-axis", () => {
  // sqrt(4 (0.5 * 0.1)^2) = 0.1, as for an axis along x
  const band = bandOf(matrix({ orientation_deg: 45 }))!;
  close(band.outer.major, 2.2);
});

interface UnitCase {
  displacement: string;
  force: string;
  mass: string;
  damping: string;
  stiffness: string;
}

test("units follow the rig's, and the pages and the services agree on them", () => {
  const file = process.env["TONUS_UNIT_CASES"];
  assert.ok(file, "TONUS_UNIT_CASES is the path of matrix_units.json");
  const cases = JSON.parse(readFileSync(file, "utf8")) as UnitCase[];
  assert.ok(cases.length > 0);
  for (const one of cases) {
    const found = estimate({ displacement_unit: one.displacement, force_unit: one.force });
    assert.deepEqual([unitOf(found, "M"), unitOf(found, "B"), unitOf(found, "K")], [one.mass, one.damping, one.stiffness]);
  }
});

test("a condition is named by posture, bias force, set and instruction", () => {
  const named = estimate({ bias_N: new Float64Array([0.7, -0.25]), set_number: 3, instruction: "stiffen" });
  assert.equal(conditionOf(named), "distal, bias 0.7, -0.3 N, set 3, “stiffen”");
  assert.equal(conditionOf(estimate({ posture: "" })), "posture 1");
});

test("estimates come in the order of postures, then of conditions, numbers by their value", () => {
  const list = [estimate({ posture_index: 1 }), estimate({ set_number: 10 }), estimate({ set_number: 9 })].sort(inOrder);
  assert.deepEqual(list.map((one) => one.set_number), [9, 10, 0]);
});

test("one posture has one colour, whatever its conditions", () => {
  const tones = postureTones([estimate(), estimate({ posture: "left" }), estimate({ set_number: 2 })]);
  assert.deepEqual([...tones], [["distal", 0], ["left", 1]]);
  assert.equal(toneClass(6), "tone-0");
});

test("a value has as many digits as two of its error make sense of", () => {
  assert.equal(withError(204.56, 3.61), "204.6 ± 3.6");
  assert.equal(withError(651.2, 11.4), "651 ± 11");
  assert.equal(withError(1.23456, 0.00521), "1.2346 ± 0.0052");
  assert.equal(withError(NaN, 1), "–");
  assert.equal(withError(12.3456, Infinity), "12.35");
});
