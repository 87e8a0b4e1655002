import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";
import { RigKind, type RigDescription, type RigSample } from "../../../../../services/dashboard/web/src/contract";
import { handOf, robotFrame, rotate } from "../../../../../services/dashboard/web/src/geometry";

// Links of 0.3 and 0.4 m, 1000 counts a rad, 10 N/V.
const rig = {
  kind: RigKind.RIG_TWO_LINK,
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
  actual.forEach((value, i) => assert.ok(Math.abs(value - expected[i]!) < 1e-12, `${actual.join(", ")} is not ${expected.join(", ")}`));

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
  const hand = handOf({ ...rig, kind: RigKind.RIG_ONE_AXIS }, robotFrame, sample([300, 0], [0.5, 0]));
  close(hand.position, [0.2, 0]);
});

test("a quarter turn brings x to y", () => close(rotate([1, 0], Math.PI / 2), [0, 1]));

// The same file holds services/mechanics/rig_geometry.cpp: tests/unit/services/mechanics/conversion_cases_test.cpp.
interface ConversionCase {
  name: string;
  kind: "two_link" | "cartesian" | "one_axis";
  link_lengths_m: number[];
  encoder_counts_per_unit: number[];
  encoder_zero_count: number[];
  encoder_sign: number[];
  force_calibration_N_per_V: number[];
  force_offset_V: number[];
  force_sensor_angle_rad: number;
  shoulder_origin_m: [number, number];
  shoulder_angle_rad: number;
  encoder_count: [number, number];
  force_V: [number, number];
  expected_position: number[];
  expected_force: number[];
}

const kinds = { two_link: RigKind.RIG_TWO_LINK, cartesian: RigKind.RIG_CARTESIAN, one_axis: RigKind.RIG_ONE_AXIS };
const casesFile = process.env["TONUS_CONVERSION_CASES"];
assert.ok(casesFile, "TONUS_CONVERSION_CASES is the path of conversion_cases.json");
const cases = JSON.parse(readFileSync(casesFile, "utf8")) as ConversionCase[];
assert.ok(cases.length > 0);

for (const one of cases) {
  test(`the services' conversion and the pages' agree: ${one.name}`, () => {
    const description = { ...one, kind: kinds[one.kind] } as unknown as RigDescription;
    const pose = { origin: one.shoulder_origin_m, angle: one.shoulder_angle_rad };
    const hand = handOf(description, pose, sample(one.encoder_count, one.force_V));
    close(hand.position, one.expected_position);
    close(hand.force, one.expected_force);
  });
}
