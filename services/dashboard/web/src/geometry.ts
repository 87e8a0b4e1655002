// From raw samples to the hand in the shoulder's frame: the same conversion as services/mechanics/rig_geometry.cpp,
// with which it shares the cases of tests/unit/services/mechanics/conversion_cases.json.

import { RigKind, type RigDescription, type RigSample, type TrialProgram } from "./contract";

export interface ShoulderPose {
  origin: [number, number]; // of S, in R, m
  angle: number; // from R's x axis to S's, rad
}

export interface HandSample {
  position: [number, number]; // in S where a pose is known, else in R; displacement units of the rig
  force: [number, number];
}

export const poseOf = (program: TrialProgram): ShoulderPose => ({
  origin: [program.shoulder_origin_m[0]!, program.shoulder_origin_m[1]!],
  angle: program.shoulder_angle_rad,
});

export const robotFrame: ShoulderPose = { origin: [0, 0], angle: 0 };

export function handOf(rig: RigDescription, pose: ShoulderPose, sample: RigSample): HandSample {
  const joint = (i: number): number =>
    (rig.encoder_sign[i]! * (sample.encoder_count[i]! - rig.encoder_zero_count[i]!)) /
    rig.encoder_counts_per_unit[i]!;
  const q0 = joint(0);
  const q1 = joint(1);
  const v0 = sample.force_V[0]! - rig.force_offset_V[0]!;
  const v1 = sample.force_V[1]! - rig.force_offset_V[1]!;
  const c = rig.force_calibration_N_per_V;
  const sensed: [number, number] = [c[0]! * v0 + c[1]! * v1, c[2]! * v0 + c[3]! * v1];
  if (rig.kind !== RigKind.RIG_TWO_LINK) return { position: [q0, q1], force: sensed };
  const [l1, l2] = [rig.link_lengths_m[0]!, rig.link_lengths_m[1]!];
  const x = l1 * Math.cos(q0) + l2 * Math.cos(q0 + q1) - pose.origin[0];
  const y = l1 * Math.sin(q0) + l2 * Math.sin(q0 + q1) - pose.origin[1];
  return {
    position: rotate([x, y], -pose.angle),
    force: rotate(sensed, q0 + q1 + rig.force_sensor_angle_rad - pose.angle),
  };
}

export function rotate([x, y]: [number, number], angle: number): [number, number] {
  const c = Math.cos(angle);
  const s = Math.sin(angle);
  return [c * x - s * y, s * x + c * y];
}
