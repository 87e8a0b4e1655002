// The last trial, or any other that is chosen: displacement and force against time from the onset, the eight before it faint.

import { el, panel, setText, svg } from "./dom";
import { rootMeanSquare, type Fit } from "./fit_overlay";
import { AFTER_S, BEFORE_S, type Course } from "./trial_recorder";
import type { VerdictLimits } from "./trial_words";

// In units of about a pixel, so that a phone's letters are as large as a desk's.
const WIDTH = matchMedia("(max-width: 600px)").matches ? 340 : 640;
const HEIGHT = 166;
const BOX = { left: 52, right: 8, top: 34, bottom: 24 };

export interface ShownTrial {
  attempt: number;
  text: string; // posture, verdict
  course?: Course;
  note?: string; // in place of the usual one
  /// What the verdict allows; undefined where it does not say so, and of a rig that has no m and N.
  limits?: VerdictLimits;
  /// What an estimate gives, and which one that is.
  fit?: Fit & { of: string };
}

/// What is allowed, to both sides of zero, between two times from the onset.
interface Band {
  half: number | undefined;
  from: number;
  to: number;
}

const isInside = (time: number): boolean => time >= -BEFORE_S && time <= AFTER_S;
const x = (time: number): number => BOX.left + ((time + BEFORE_S) / (AFTER_S + BEFORE_S)) * (WIDTH - BOX.left - BOX.right);

export const courseNote = (before: number): string => `Solid: x; dashed: y. Faint: the ${before} before it.`;

/// What is drawn besides: the band and the fit.
function furtherNote(trial: ShownTrial, unit: string): string {
  const { limits, fit } = trial;
  const band = limits?.excursion_m === undefined && limits?.rest_force_N === undefined ? "" : " Bands: what the verdict allows.";
  return fit ? `${band} Thick and pale: ${fit.of}; its residual is ${rootMeanSquare(fit.residual).toFixed(3)} ${unit} (RMS).` : band;
}

export class TrialChart {
  readonly root: HTMLElement;
  #age: HTMLElement;
  #note = el("p", { class: "caption" });
  #drawings = [svg("svg"), svg("svg"), svg("svg")];
  #ranges: [number, number, number] = [0.1, 0.1, 0.1]; // half heights; they grow only

  /// `id` is the panel's.
  constructor(title = "Last trial", id = "last-trial") {
    for (const drawing of this.#drawings) {
      drawing.setAttribute("viewBox", `0 0 ${WIDTH} ${HEIGHT}`);
      drawing.setAttribute("role", "img");
      drawing.setAttribute("width", "100%");
      drawing.style.aspectRatio = `${WIDTH} / ${HEIGHT}`;
    }
    const made = panel(title, id, this.#note, ...this.#drawings);
    this.root = made.root;
    this.root.classList.add("trial-course");
    this.#age = made.age;
  }

  show(trial: ShownTrial | undefined, before: readonly Course[], units: { displacement: string; force: string }): void {
    setText(this.#age, trial ? `trial ${trial.attempt}: ${trial.text}` : "none yet");
    const isSeen = trial?.course !== undefined;
    const further = trial && isSeen ? furtherNote(trial, units.force) : "";
    setText(this.#note, !trial ? "" : trial.note !== undefined ? trial.note + further : isSeen ? courseNote(before.length) + further : "This page was not open at its onset; the archive has its samples.");
    const scale = units.displacement === "m" ? 1000 : 1;
    const displacement = units.displacement === "m" ? "mm" : units.displacement;
    const fit = trial?.course && trial.fit;
    this.#draw(0, `displacement (${displacement})`, before, trial?.course, (course) => course.displacement, scale, { band: { half: trial?.limits?.excursion_m, from: 0, to: AFTER_S } });
    this.#draw(1, `force (${units.force})`, before, trial?.course, (course) => course.force, 1, { band: { half: trial?.limits?.rest_force_N, from: -BEFORE_S, to: 0 }, fit: fit && { ...trial.course!, force: fit.force } });
    this.#draw(2, `residual (${units.force})`, [], fit && { ...trial.course!, force: fit.residual }, (course) => course.force, 1, {});
  }

  #draw(i: 0 | 1 | 2, title: string, before: readonly Course[], course: Course | undefined, of: (course: Course) => [number[], number[]], scale: number, { band, fit }: { band?: Band; fit?: Course }): void {
    const drawing = this.#drawings[i]!;
    drawing.setAttribute("aria-label", title);
    const all = [...before, ...(course ? [course] : [])];
    if (band?.half !== undefined) this.#ranges[i] = Math.max(this.#ranges[i], scale * band.half);
    for (const one of [...all, ...(fit ? [fit] : [])])
      for (const series of of(one)) series.forEach((value, k) => { if (isInside(one.times[k]!) && Number.isFinite(value)) this.#ranges[i] = Math.max(this.#ranges[i], Math.abs(scale * value)); });
    const half = 1.05 * this.#ranges[i];
    const middle = (HEIGHT + BOX.top - BOX.bottom) / 2;
    const y = (value: number): number => middle - (value / half) * (HEIGHT - BOX.top - BOX.bottom) * 0.5;
    drawing.replaceChildren(svg("text", { x: 4, y: 15, class: "small" }, title));
    if (band?.half !== undefined) {
      const top = y(scale * band.half);
      drawing.append(svg("rect", { class: "allowed", x: x(band.from), width: x(band.to) - x(band.from), y: top, height: y(-scale * band.half) - top }));
    }
    for (const value of [half, 0, -half]) {
      drawing.append(
        svg("path", { class: "axis", d: `M ${BOX.left} ${y(value)} H ${WIDTH - BOX.right}` }),
        svg("text", { x: BOX.left - 6, y: y(value) + 4, "text-anchor": "end", class: "small" }, value.toPrecision(2).replace(/^-?0\.0$/, "0")),
      );
    }
    for (const time of [0, 0.5, 1]) {
      drawing.append(
        svg("path", { class: time === 0 ? "onset" : "axis", d: `M ${x(time)} ${BOX.top} V ${HEIGHT - BOX.bottom}` }),
        svg("text", { x: x(time), y: HEIGHT - 8, "text-anchor": "middle", class: "small" }, time === 0 ? "onset" : `${time} s`),
      );
    }
    for (const one of [...(fit ? [fit] : []), ...all]) {
      of(one).forEach((series, axis) => {
        const points = series.flatMap((value, k) => (isInside(one.times[k]!) && Number.isFinite(value) ? [`${x(one.times[k]!).toFixed(1)},${y(scale * value).toFixed(1)}`] : []));
        drawing.append(svg("polyline", { points: points.join(" "), class: `course tone-${axis}${one === course ? "" : one === fit ? " fit" : " before"}`, "stroke-dasharray": axis === 0 ? "none" : "6 3" }));
      });
    }
  }
}
