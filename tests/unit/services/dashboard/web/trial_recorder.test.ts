import assert from "node:assert/strict";
import { test } from "node:test";
import { RigKind, TrialPhase, type RigDescription, type RigSample, type SampleBlock } from "../../../../../services/dashboard/web/src/contract";
import { robotFrame } from "../../../../../services/dashboard/web/src/geometry";
import { AFTER_S, BEFORE_S, TrialRecorder } from "../../../../../services/dashboard/web/src/trial_recorder";

// Channels are displacement in m and force in N, one count a unit.
const rig = {
  kind: RigKind.RIG_CARTESIAN, encoder_sign: new Float64Array([1, 1]), encoder_zero_count: new Float64Array(2), encoder_counts_per_unit: new Float64Array([1, 1]),
  force_offset_V: new Float64Array(2), force_calibration_N_per_V: new Float64Array([1, 0, 0, 1]),
} as unknown as RigDescription;

const sample = (ms: number, phase: number, x: number): RigSample => ({
  acquisition_ns: BigInt(ms) * 1_000_000n, encoder_count: new Float64Array([x, 0]), force_V: new Float64Array([2 * x, 0]), commanded_m: new Float64Array(2), phase, flags: 0,
});
const block = (trial: number, samples: RigSample[], more: Partial<SampleBlock> = {}): SampleBlock => ({
  rig_id: new Uint8Array(16), session_id: new Uint8Array(16), trial_id: new Uint8Array(16).fill(trial), epoch: 1n, first_sequence: 0n, is_resent: false, send_ns: 0n, samples, ...more,
});
const id = (trial: number): string => trial.toString(16).padStart(2, "0").repeat(16);

/// A long wait at 0.25 m, then a push of 1 m/s.
const trialOf = (onset: number): RigSample[] =>
  Array.from({ length: 4000 }, (_, ms) => (ms < onset ? sample(ms, TrialPhase.PHASE_WAITING, 0.25) : sample(ms, TrialPhase.PHASE_PERTURBING, 0.25 + (ms - onset) / 1000)));

test("a trial's course counts time and displacement from its onset", () => {
  const recorder = new TrialRecorder();
  recorder.add(block(1, trialOf(2000)), rig, robotFrame);
  const course = recorder.course(id(1))!;
  assert.ok(course.times[0]! <= -BEFORE_S + 0.06 && course.times[0]! >= -BEFORE_S - 0.21, `${course.times[0]}`);
  assert.ok(Math.abs(course.times.at(-1)! - AFTER_S) < 0.005);
  const half = course.times.findIndex((time) => time >= 0.5);
  assert.ok(Math.abs(course.displacement[0][half]! - course.times[half]!) < 0.005);
  assert.ok(Math.abs(course.force[0][half]! - 2 * (0.25 + course.times[half]!)) < 0.01);
  assert.ok(course.displacement[0].filter((_, i) => course.times[i]! < 0).every((value) => Math.abs(value) < 1e-9));
});

test("a trial whose onset this page has not seen has no course", () => {
  const recorder = new TrialRecorder();
  recorder.add(block(1, trialOf(2000).slice(2500)), rig, robotFrame);
  recorder.add(block(2, trialOf(2000).slice(0, 1500)), rig, robotFrame);
  recorder.add(block(3, trialOf(2000), { is_resent: true }), rig, robotFrame);
  for (const trial of [1, 2, 3, 4]) assert.equal(recorder.course(id(trial)), undefined, `trial ${trial}`);
});

test("only the newest trials are kept, and of each no more than is drawn", () => {
  const recorder = new TrialRecorder();
  for (let trial = 1; trial <= 70; ++trial) recorder.add(block(trial, trialOf(2000)), rig, robotFrame);
  assert.equal(recorder.course(id(1)), undefined);
  assert.ok(recorder.course(id(70))!.times.length <= 1.4 * 250 + 60);
});
