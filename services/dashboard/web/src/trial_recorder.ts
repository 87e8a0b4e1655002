// The course of trials from before their onset, out of the live samples. Pure. The time counts from the onset; displacement
// counts from where the hand was then.

import { TrialPhase, type RigDescription, type SampleBlock } from "./contract";
import { handOf, type ShoulderPose } from "./geometry";
import { hex } from "./names";

export const BEFORE_S = 0.2;
export const AFTER_S = 1.2;
const POINTS_PER_S = 250;
const MOST_TRIALS = 64;

export interface Course {
  times: number[]; // s from the onset
  /// x, y of the displacement and of the force, in the rig's units.
  displacement: [number[], number[]];
  force: [number[], number[]];
}

interface Raw {
  times: number[];
  values: [number, number, number, number][];
  isBefore: boolean; // a sample before the onset was seen
  onset?: number;
}

export class TrialRecorder {
  #trials = new Map<string, Raw>();

  add(block: SampleBlock, rig: RigDescription, pose: ShoulderPose): void {
    if (block.is_resent || block.trial_id.every((byte) => byte === 0)) return;
    const id = hex(block.trial_id);
    const trial = this.#trials.get(id) ?? { times: [], values: [], isBefore: false };
    if (!this.#trials.has(id)) this.#keep(id, trial);
    for (const sample of block.samples) {
      const time = Number(sample.acquisition_ns) / 1e9;
      const isPush = sample.phase === TrialPhase.PHASE_PERTURBING;
      // An onset is a change into the perturbation that was seen, not the first sample of a page opened in its midst.
      trial.isBefore ||= !isPush;
      if (isPush && trial.isBefore) trial.onset ??= time;
      if (trial.onset !== undefined && time > trial.onset + AFTER_S) continue;
      const isDue = time - (trial.times.at(-1) ?? -Infinity) >= 1 / POINTS_PER_S - 1e-9;
      if (!isDue) continue;
      const { position, force } = handOf(rig, pose, sample);
      trial.times.push(time);
      trial.values.push([...position, ...force]);
      if (trial.onset === undefined) forgetBefore(trial, time - BEFORE_S);
    }
  }

  #keep(id: string, trial: Raw): void {
    this.#trials.set(id, trial);
    if (this.#trials.size > MOST_TRIALS) this.#trials.delete(this.#trials.keys().next().value!);
  }

  /// Undefined where this page has not seen the trial's onset.
  course(id: string): Course | undefined {
    const trial = this.#trials.get(id);
    const onset = trial?.onset;
    if (!trial || onset === undefined) return undefined;
    const begin = trial.values[trial.times.findIndex((time) => time >= onset)] ?? trial.values.at(-1)!;
    const column = (i: 0 | 1 | 2 | 3, from: number): number[] => trial.values.map((value) => value[i] - from);
    return {
      times: trial.times.map((time) => time - onset),
      displacement: [column(0, begin[0]), column(1, begin[1])],
      force: [column(2, 0), column(3, 0)],
    };
  }
}

function forgetBefore(trial: Raw, time: number): void {
  const first = trial.times.findIndex((one) => one >= time);
  if (first > 50) {
    trial.times.splice(0, first);
    trial.values.splice(0, first);
  }
}
