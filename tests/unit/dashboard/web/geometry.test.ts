import assert from "node:assert/strict";
import { test } from "node:test";
import type { RigDescription, RigSample } from "../../../../services/dashboard/web/src/contract";
import { handOf, robotFrame, rotate } from "../../../../services/dashboard/web/src/geometry";

// Links of 0.3 and 0.4 m, 1000 counts a rad, 10 N/V.
const rig = {
  kind: 0,
  link_lengths_m: new Float64Array([0.3, 0.4]),
  encoder_counts_per_unit: new Float64Array([1000, 1000]),
  encoder_zero_count: new Float64Array([100, 0]),
  encoder_sign: new Float64Array([1, -1]),
  force_calibration_N_per_V: new Float64Array([10, 0, 0, 10]),
  force_offset_V: new Float64Array([0.5, 0]),
  force_sensor_angle_rad: 0,
} as unknown as RigDescription;

const sample = (counts: [number, number], volts: [number, number]): RigSample =>
  ({ encoder_count: new Float64Array(counts), force_V: new Float64Array(volts) }) as unknown as RigSample;

const close = (actual: number[], expected: number[]): void =>
  actual.forEach((value, i) => assert.ok(Math.abs(value - expected[i]!) < 1e-12, `${actual} is not ${expected}`));

test("both joints at zero: the hand is at the length of both links, the force that of the sensor without offset", () => {
  const hand = handOf(rig, robotFrame, sample([100, 0], [0.7, 0.1]));
  close(hand.position, [0.7, 0]);
  close(hand.force, [2, 1]);
});

test("joint angles are counted from the zero and with the encoder's sign, and turn the sensor", () => {
  const quarter = (1000 * Math.PI) / 2;
  const hand = handOf(rig, robotFrame, sample([100 + quarter, quarter], [0.7, 0.1])); // 90 and -90 degrees
  close(hand.position, [0.4, 0.3]);
  close(hand.force, [2, 1]);
});

test("the shoulder's frame is shifted and turned against the robot's", () => {
  const hand = handOf(rig, { origin: [0.7, -0.5], angle: Math.PI / 2 }, sample([100, 0], [0.7, 0.1]));
  close(hand.position, [0.5, 0]);
  close(hand.force, [1, -2]);
});

test("channels that are displacements already are scaled only", () => {
  const hand = handOf({ ...rig, kind: 2 }, robotFrame, sample([300, 0], [0.5, 0]));
  close(hand.position, [0.2, 0]);
});

test("a quarter turn brings x to y", () => close(rotate([1, 0], Math.PI / 2), [0, 1]));
