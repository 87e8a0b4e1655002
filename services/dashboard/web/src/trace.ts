// Live traces: hand position and force against time, drawn at the display's rate; the newest values as text.

import uPlot from "uplot";
import "uplot/dist/uPlot.min.css";
import { RigKind, TrialPhase, type RigDescription, type SampleBlock, type SessionNote, type TrialProgram } from "./contract";
import { el, setText } from "./dom";
import { handOf, poseOf, type ShoulderPose } from "./geometry";

const WINDOW_S = 10;
const HEIGHT = 176; // CSS pixels
// Half of the least height of a plot: noise at rest is not to look like motion. In mm and N; other units have none.
const LEAST_MM = 2;
const LEAST_N = 1;
const POINTS_PER_S = 250; // more than a screen has columns for
const CAPACITY = WINDOW_S * POINTS_PER_S * 2;
const MOST_MARKS = 64;
const LONGEST_MARK = 24; // letters
// Flags of notes shortly after each other stand below each other.
const FLAG_ROW = 14;
const FLAG_ROWS = 4;

/// A stretch of time in one phase of a trial, s.
interface Stretch {
  phase: number;
  begin: number;
  end: number;
}

/// What was noted, at the rig's time in s.
interface Mark {
  epoch: bigint; // of the rig's clock
  time: number;
  text: string;
}

/// The newest seconds of four series, in the order of acquisition, and the phases of that time.
class Ring {
  readonly times: number[] = [];
  readonly stretches: Stretch[] = [];
  readonly marks: Mark[] = [];
  readonly series: number[][] = [[], [], [], []];

  push(time: number, values: readonly number[]): void {
    this.times.push(time);
    values.forEach((value, i) => this.series[i]!.push(value));
    if (this.times.length <= CAPACITY) return;
    const surplus = this.times.length - CAPACITY / 2;
    this.times.splice(0, surplus);
    for (const one of this.series) one.splice(0, surplus);
  }

  /// The phase at a time, of every sample.
  mark(time: number, phase: number): void {
    const last = this.stretches.at(-1);
    if (last?.phase === phase && time - last.end < 0.5) last.end = time;
    else this.stretches.push({ phase, begin: time, end: time });
    while (this.stretches.length > 0 && this.stretches[0]!.end < time - WINDOW_S) this.stretches.shift();
  }

  clear(): void {
    this.stretches.length = 0;
    this.times.length = 0;
    for (const one of this.series) one.length = 0;
  }
}

/// Where the handle is at home, and along the robot's axes: before any trial.
const homeOf = (rig: RigDescription): ShoulderPose => ({ origin: [rig.home_m[0]!, rig.home_m[1]!], angle: 0 });

export class Trace {
  readonly root = el("div", { class: "trace" });
  frames = 0; // drawn since the page was loaded
  #ring = new Ring();
  #plots: uPlot[] = [];
  #values: HTMLElement[] = [];
  #ranges: [number, number][] = []; // of the plots' y axes; they grow only
  #rig?: RigDescription;
  #pose?: ShoulderPose; // unknown until a trial says where the subject sits
  #heading?: HTMLElement; // of the hand
  #posture: [number, number] = [0, 0]; // in S, m
  #epoch = -1n;
  #last = -Infinity; // s, of the newest sample
  #arrived = 0; // ms
  #lastKept = -Infinity;
  #hasNews = false;

  constructor() {
    const draw = (): void => {
      this.#draw();
      requestAnimationFrame(draw);
    };
    requestAnimationFrame(draw);
    new ResizeObserver(() => this.#resize()).observe(this.root);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.#build());
  }

  setRig(rig: RigDescription): void {
    const isSame =
      this.#rig?.displacement_unit === rig.displacement_unit && this.#rig?.force_unit === rig.force_unit;
    this.#rig = rig;
    if (!isSame) this.#build();
  }

  /// The trial says where the subject sits.
  setTrial(program: TrialProgram): void {
    const pose = poseOf(program);
    const posture: [number, number] = [program.posture_m[0]!, program.posture_m[1]!];
    const isSame =
      posture[0] === this.#posture[0] &&
      posture[1] === this.#posture[1] &&
      pose.angle === this.#pose?.angle &&
      pose.origin[0] === this.#pose.origin[0] &&
      pose.origin[1] === this.#pose.origin[1];
    if (isSame) return;
    this.#pose = pose;
    this.#posture = posture;
    if (this.#heading) setText(this.#heading, this.#handTitle());
    this.#ring.clear(); // what is there is in another frame
    this.#lastKept = -Infinity;
  }

  add(block: SampleBlock): void {
    if (!this.#rig || block.is_resent) return;
    if (block.epoch !== this.#epoch) {
      this.#epoch = block.epoch;
      this.#ring.clear();
      this.#last = this.#lastKept = -Infinity;
    }
    const scale = this.#rig.displacement_unit === "m" ? 1000 : 1;
    const pose = this.#pose ?? homeOf(this.#rig);
    for (const sample of block.samples) {
      const time = Number(sample.acquisition_ns) / 1e9;
      if (time < this.#last) continue;
      this.#last = time;
      this.#ring.mark(time, sample.phase);
      if (time - this.#lastKept < 1 / POINTS_PER_S - 1e-9) continue;
      this.#lastKept = time;
      const hand = handOf(this.#rig, pose, sample);
      this.#ring.push(time, [
        scale * (hand.position[0] - this.#posture[0]),
        scale * (hand.position[1] - this.#posture[1]),
        hand.force[0],
        hand.force[1],
      ]);
    }
    this.#arrived = performance.now();
    this.#hasNews = true;
  }

  /// A note is drawn where the rig's clock was when it was written; one of another start of the rig is not.
  addNote(note: SessionNote): void {
    if (!note.has_rig_clock) return;
    const time = Number(note.rig_clock_ns) / 1e9;
    if (this.#ring.marks.some((mark) => mark.epoch === note.epoch && mark.time === time && mark.text === note.text)) return;
    this.#ring.marks.push({ epoch: note.epoch, time, text: note.text });
    if (this.#ring.marks.length > MOST_MARKS) this.#ring.marks.shift();
    this.root.dataset["marks"] = String(this.#ring.marks.length);
    this.#hasNews = true;
  }

  /// The newest values; less often than the drawing, so that they can be read.
  renderValues(): void {
    this.#values.forEach((value, i) => {
      const newest = this.#ring.series[i]!.at(-1);
      setText(value, newest === undefined ? "–" : newest.toFixed(2));
    });
  }

  #draw(): void {
    if (this.#plots.length === 0 || document.hidden) return;
    const sinceArrival = (performance.now() - this.#arrived) / 1000;
    if (!this.#hasNews && sinceArrival > 0.5) return; // stands still
    this.#hasNews = false;
    // The time axis goes on between blocks, so that the picture glides.
    const end = this.#last + Math.min(sinceArrival, 0.2);
    const { times, series } = this.#ring;
    this.#plots.forEach((plot, i) => {
      plot.setData([times, series[2 * i]!, series[2 * i + 1]!], false);
      plot.setScale("x", { min: end - WINDOW_S, max: end });
      plot.root.dataset["range"] = this.#ranges[i]!.map((bound) => bound.toFixed(3)).join(" ");
    });
    this.frames += 1;
    this.root.dataset["frames"] = String(this.frames);
    this.root.dataset["points"] = String(times.length);
  }

  #build(): void {
    if (!this.#rig) return;
    for (const plot of this.#plots) plot.destroy();
    this.root.replaceChildren();
    const displacement = this.#rig.displacement_unit === "m" ? "mm" : this.#rig.displacement_unit;
    const force = this.#rig.force_unit;
    this.#values = [];
    this.#ranges = [];
    this.#plots = [];
    this.#plots.push(this.#plot(this.#handTitle(), displacement, ["x", "y"], displacement === "mm" ? LEAST_MM : 0));
    this.#plots.push(this.#plot("Force on the arm", force, ["Fx", "Fy"], force === "N" ? LEAST_N : 0));
    this.root.append(el("p", { class: "caption" }, "Shaded: a trial; darker: the perturbation, from its onset (line). Flags: notes."));
  }

  #handTitle(): string {
    if (this.#rig?.kind !== RigKind.RIG_TWO_LINK) return "Displacement";
    return this.#pose ? "Hand from the posture" : "Hand from home";
  }

  #plot(title: string, unit: string, names: [string, string], least: number): uPlot {
    const values = names.map(() => el("output", {}, "–"));
    this.#values.push(...values);
    const keys = names.map((name, i) => el("span", { class: `key key-${i}` }, name, values[i]!, unit));
    const heading = el("h3", {}, title);
    if (this.#plots.length === 0) this.#heading = heading;
    this.root.append(el("div", { class: "heading" }, heading, ...keys));
    const style = getComputedStyle(document.documentElement);
    const colour = (name: string): string => style.getPropertyValue(name).trim();
    const axis = { stroke: colour("--faint"), grid: { stroke: colour("--line"), width: 1 }, labelSize: 18, labelFont: "12px system-ui, sans-serif" };
    const grown: [number, number] = [-least, least];
    this.#ranges.push(grown);
    // Fixed, and wider only where a value would leave the plot: what looks twice as large is twice as large.
    const range = (_: uPlot, low: number | null, high: number | null): uPlot.Range.MinMax => {
      if (low !== null && low < grown[0]) grown[0] = 1.25 * low;
      if (high !== null && high > grown[1]) grown[1] = 1.25 * high;
      return grown[1] > grown[0] ? [grown[0], grown[1]] : [-1, 1];
    };
    const ago = (plot: uPlot): number[] => {
      const end = plot.scales["x"]!.max ?? 0;
      return Array.from({ length: WINDOW_S / 2 + 1 }, (_, i) => end - WINDOW_S + 2 * i);
    };
    const seconds = (plot: uPlot, ticks: number[]): string[] =>
      ticks.map((tick) => String(Math.round(tick - (plot.scales["x"]!.max ?? 0)) || "0"));
    return new uPlot(
      {
        width: Math.max(240, this.root.clientWidth),
        height: HEIGHT,
        legend: { show: false },
        cursor: { show: false },
        scales: { x: { time: false }, y: { range } },
        axes: [
          { ...axis, size: 28, splits: ago, values: seconds, label: "s from now" },
          { ...axis, size: 48, label: `${title.startsWith("Force") ? "force" : "position"} (${unit})` },
        ],
        hooks: { drawClear: [(plot): void => shade(plot, this.#ring.stretches, colour("--phase"), colour("--onset")), (plot): void => mark(plot, this.#ring.marks.filter(({ epoch }) => epoch === this.#epoch), colour("--ink"))] },
        series: [
          {},
          { stroke: colour("--x"), width: 1.5 },
          { stroke: colour("--y"), width: 1.5, dash: [6, 3] },
        ],
      },
      [[], [], []],
      this.root,
    );
  }

  #resize(): void {
    for (const plot of this.#plots) plot.setSize({ width: Math.max(240, this.root.clientWidth), height: HEIGHT });
  }
}

const shaded: readonly number[] = [TrialPhase.PHASE_CENTRING, TrialPhase.PHASE_WAITING, TrialPhase.PHASE_BIAS_RAMP, TrialPhase.PHASE_BIAS_HOLD, TrialPhase.PHASE_PERTURBING];

/// Trials are shaded, a perturbation more, and its onset is a line.
function shade(plot: uPlot, stretches: readonly Stretch[], tint: string, onset: string): void {
  const { left, top, width, height } = plot.bbox;
  const context = plot.ctx;
  const at = (time: number): number => Math.min(left + width, Math.max(left, plot.valToPos(time, "x", true)));
  context.save();
  for (const [i, { phase, begin, end }] of stretches.entries()) {
    if (!shaded.includes(phase)) continue;
    const isPush = phase === TrialPhase.PHASE_PERTURBING;
    context.fillStyle = tint;
    context.globalAlpha = isPush ? 0.3 : 0.12;
    context.fillRect(at(begin), top, at(end) - at(begin), height);
    // Of the first stretch the beginning was not seen.
    if (!isPush || i === 0 || plot.valToPos(begin, "x", true) < left) continue;
    context.globalAlpha = 1;
    context.fillStyle = onset;
    context.fillRect(at(begin), top, 2 * devicePixelRatio, height);
  }
  context.restore();
}

/// A line with a flag where something was noted.
function mark(plot: uPlot, marks: readonly Mark[], ink: string): void {
  const { left, top, width, height } = plot.bbox;
  const context = plot.ctx;
  context.save();
  context.fillStyle = ink;
  context.font = `${12 * devicePixelRatio}px system-ui, sans-serif`;
  context.textBaseline = "top";
  for (const [i, { time, text }] of marks.entries()) {
    const x = plot.valToPos(time, "x", true);
    if (x < left || x > left + width) continue;
    context.fillRect(x, top, devicePixelRatio, height);
    const flag = text.length > LONGEST_MARK ? `${text.slice(0, LONGEST_MARK - 1)}…` : text;
    const room = 3 * devicePixelRatio;
    const length = context.measureText(flag).width;
    // To the left of its line where it would leave the plot.
    const at = x + room + length > left + width ? x - room - length : x + room;
    context.fillText(flag, at, top + (1 + FLAG_ROW * (i % FLAG_ROWS)) * devicePixelRatio);
  }
  context.restore();
}
