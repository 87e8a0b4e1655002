// The ellipses of one matrix at the postures where they were measured; new ones grow into their place. Where several
// conditions were measured at a posture, those of single sets are drawn faint, and the chosen one stands out. The scale is that
// of the estimates: a wide interval is cut off at the edge of its posture's place. A posture whose estimate is not determined
// yet has an empty circle and the number of its trials. Of several sessions drawn over each other, colour and dash are the
// session's, and intervals are left out.

import { EstimateStatus, type Estimate } from "./contract";
import { el, svg } from "./dom";
import {
  bandOf,
  conditionOf,
  ellipseOf,
  isWhole,
  matrixOf,
  matrixTitles,
  postureOf,
  toneClass,
  unitOf,
  type Ellipse,
  type MatrixName,
} from "./matrices";
import type { Look } from "./overlay";
import { colourOf, dashOf, markerAt, postureTones } from "./posture_style";

const SIZE = 330; // of the drawing, user units
const MARGIN = 24; // below, for the scale
const LABEL = 24; // height of a posture's name
const SAME_PLACE_M = 0.01;
const GROWTH_MS = 600;
const FILL = 0.85; // of a place, by the largest ellipse; the rest is for intervals

interface Drawn {
  x: number;
  y: number;
  label: string;
  posture: string;
  place: number; // of posture_style.ts
  isMarked: boolean; // with the posture's marker at its place
  isFaint: boolean;
  isChosen: boolean;
  ellipse?: Ellipse; // none: not determined
  note: string; // below the posture's name
  outer?: Ellipse;
  inner?: Ellipse;
}

export class EllipseChart {
  readonly root: HTMLElement;
  #name: MatrixName;
  #drawing = svg("svg", { viewBox: `0 0 ${SIZE} ${SIZE}`, role: "img", width: "100%" });
  #shown = new Map<string, Ellipse>(); // as drawn now
  #animation = 0;

  constructor(name: MatrixName) {
    this.#name = name;
    this.root = el("figure", { class: "ellipses" });
    this.root.append(el("h3", {}, matrixTitles[name]), this.#drawing);
  }

  /// `chosen`: the condition that stands out. `planned`: trials of each posture, where the plan is known. `looks`: of which
  /// session each estimate is, where there are several.
  update(estimates: Estimate[], chosen: string, planned: ReadonlyMap<string, number>, looks?: ReadonlyMap<Estimate, Look>): void {
    const places = postureTones(estimates);
    const items = estimates
      .flatMap((estimate) => {
        const item = this.#item(estimate, places.get(postureOf(estimate)) ?? 0, chosen, planned);
        const look = looks?.get(estimate);
        return look ? item.filter(({ ellipse }) => ellipse).map((one) => ofSession(one, look)) : item;
      })
      .sort((a, b) => Number(a.isChosen) - Number(b.isChosen));
    this.#drawing.setAttribute(
      "aria-label",
      `${matrixTitles[this.#name]}: ellipses of ${items.map((item) => item.label).join(", ") || "no posture yet"}`,
    );
    cancelAnimationFrame(this.#animation);
    const begin = performance.now();
    const from = new Map(this.#shown);
    const isCalm = matchMedia("(prefers-reduced-motion: reduce)").matches;
    const step = (): void => {
      const share = isCalm ? 1 : Math.min(1, (performance.now() - begin) / GROWTH_MS);
      const eased = 1 - (1 - share) ** 3;
      this.#draw(items, estimates, (item) => item.ellipse && grown(from.get(item.label), item.ellipse, eased), share === 1);
      if (share < 1) this.#animation = requestAnimationFrame(step);
    };
    step();
  }

  #item(estimate: Estimate, place: number, chosen: string, planned: ReadonlyMap<string, number>): Drawn[] {
    const matrix = matrixOf(estimate, this.#name);
    const isDetermined = estimate.status !== EstimateStatus.ESTIMATE_UNDETERMINED;
    const ellipse = isDetermined ? ellipseOf(matrix) : undefined;
    if (!ellipse && !isWhole(estimate)) return [];
    const label = conditionOf(estimate);
    const isChosen = label === chosen;
    const band = isWhole(estimate) || isChosen ? bandOf(matrix) : undefined;
    const of = planned.get(postureOf(estimate));
    const trials = `${estimate.trials_used}${of === undefined ? "" : ` of ${of}`} trials`;
    return [
      {
        x: estimate.posture_m[0]!,
        y: estimate.posture_m[1]!,
        label,
        posture: postureOf(estimate),
        place,
        isMarked: true,
        isFaint: !isWhole(estimate) && !isChosen,
        isChosen,
        ellipse,
        note: ellipse ? "" : isDetermined ? "no ellipse" : trials,
        outer: ellipse && band?.outer,
        inner: ellipse && band?.inner,
      },
    ];
  }

  #draw(items: Drawn[], estimates: Estimate[], now: (item: Drawn) => Ellipse | undefined, isWithBands: boolean): void {
    this.#drawing.replaceChildren();
    if (items.length === 0 || !estimates[0]) {
      this.#drawing.append(svg("text", { x: SIZE / 2, y: SIZE / 2, "text-anchor": "middle" }, "nothing yet"));
      return;
    }
    const places = layout(items);
    const largest = Math.max(0, ...items.map((item) => item.ellipse?.major ?? 0));
    const scale = largest > 0 ? (FILL * places.radius) / largest : 0;
    const named = new Set<string>();
    for (const item of items) {
      const [x, y] = places.at(item);
      const ellipse = now(item);
      if (ellipse) this.#append(item, ellipse, [x, y], scale, isWithBands ? places.radius : 0);
      if (named.has(item.posture)) continue;
      named.add(item.posture);
      const tone = toneClass(colourOf(item.place));
      const mark = svg("g", { class: tone });
      if (item.isMarked) mark.append(markerAt(item.place, x, y, ellipse ? 0.6 : 1));
      if (!ellipse) mark.append(svg("circle", { cx: x, cy: y, r: 0.4 * places.radius, class: "undetermined" }));
      const name = [item.posture.slice(0, 24), item.note].filter((part) => part !== "").join(": ");
      this.#drawing.append(mark, svg("text", { x, y: y + places.radius + 13, "text-anchor": "middle", class: "small" }, name));
    }
    if (largest > 0) this.#appendScale(roundDown(largest), scale, unitOf(estimates[0], this.#name));
  }

  /// `room`: where its interval is cut off; 0: without one.
  #append(item: Drawn, ellipse: Ellipse, [x, y]: [number, number], scale: number, room: number): void {
    const tone = toneClass(colourOf(item.place));
    const shape = (one: Ellipse, attributes: Record<string, string>): SVGElement =>
      svg("ellipse", {
        ...attributes,
        cx: x,
        cy: y,
        rx: Math.max(0.1, scale * one.major),
        ry: Math.max(0.1, scale * one.minor),
        transform: `rotate(${(-one.angle * 180) / Math.PI} ${x} ${y})`, // the drawing's y goes down
      });
    if (room > 0 && item.outer && item.inner) {
      const cut = svg("svg", { x: x - room, y: y - room, width: 2 * room, height: 2 * room, viewBox: `${x - room} ${y - room} ${2 * room} ${2 * room}` });
      cut.append(shape(item.outer, { class: `band ${tone}` }), shape(item.inner, { class: `band hole ${tone}` }));
      this.#drawing.append(cut);
    }
    this.#shown.set(item.label, ellipse);
    const weight = item.isFaint ? " faint" : item.isChosen ? " chosen" : "";
    const drawn = shape(ellipse, { class: `ellipse ${tone}${weight}`, "data-condition": item.label, "stroke-dasharray": dashOf(item.place) });
    drawn.append(svg("title", {}, item.label));
    this.#drawing.append(drawn);
  }

  #appendScale(round: number, scale: number, unit: string): void {
    const length = scale * round;
    this.#drawing.append(
      svg("path", { class: "axis", d: `M 10 ${SIZE - 12} h ${length}`, "stroke-width": 2 }),
      svg("text", { x: 16 + length, y: SIZE - 8, class: "small" }, `${round} ${unit}`),
    );
  }
}

const ofSession = (item: Drawn, { letter, place }: Look): Drawn =>
  ({ ...item, label: `${letter}: ${item.label}`, place, isMarked: false, inner: undefined, outer: undefined });

/// Where postures lie in the drawing: in columns and rows as they lie before the subject (x to the right, y ahead = up), but
/// evenly, so that each ellipse has the room that there is.
function layout(items: Drawn[]): { at: (item: Drawn) => [number, number]; radius: number } {
  const columns = places(items.map(({ x }) => x));
  const rows = places(items.map(({ y }) => y));
  const pitch = (SIZE - MARGIN) / Math.max(columns.length, rows.length);
  return {
    at: ({ x, y }) => [
      SIZE / 2 + pitch * (placeOf(columns, x) - (columns.length - 1) / 2),
      (SIZE - MARGIN) / 2 - pitch * (placeOf(rows, y) - (rows.length - 1) / 2),
    ],
    radius: (pitch - LABEL) / 2,
  };
}

/// Distinct coordinates in order; what lies closer together is one.
function places(coordinates: number[]): number[] {
  const distinct: number[] = [];
  for (const coordinate of [...coordinates].sort((a, b) => a - b))
    if (distinct.length === 0 || coordinate - distinct.at(-1)! > SAME_PLACE_M) distinct.push(coordinate);
  return distinct;
}

const placeOf = (places: number[], coordinate: number): number =>
  places.reduce((found, place, i) => (coordinate >= place - 1e-9 ? i : found), 0);

function grown(from: Ellipse | undefined, to: Ellipse, share: number): Ellipse {
  if (!from) return { major: share * to.major, minor: share * to.minor, angle: to.angle };
  let turn = to.angle - from.angle;
  turn -= Math.PI * Math.round(turn / Math.PI); // the short way round
  return {
    major: from.major + share * (to.major - from.major),
    minor: from.minor + share * (to.minor - from.minor),
    angle: to.angle - (1 - share) * turn,
  };
}

function roundDown(value: number): number {
  const power = 10 ** Math.floor(Math.log10(value));
  const lead = value / power;
  return (lead >= 5 ? 5 : lead >= 2 ? 2 : 1) * power;
}
