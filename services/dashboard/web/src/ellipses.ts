// The ellipses of one matrix at the postures where they were measured; new ones grow into their place. Where several
// conditions were measured at a posture, those of single sets are drawn faint, and the chosen one stands out.

import type { Estimate } from "./contract";
import { el, svg } from "./dom";
import {
  bandOf,
  conditionOf,
  ellipseOf,
  isWhole,
  matrixOf,
  matrixTitles,
  postureOf,
  postureTones,
  toneClass,
  unitOf,
  type Ellipse,
  type MatrixName,
} from "./matrices";

const SIZE = 330; // of the drawing, user units
const MARGIN = 24; // below, for the scale
const LABEL = 20; // height of a posture's name
const SAME_PLACE_M = 0.01;
const GROWTH_MS = 600;

interface Drawn {
  x: number;
  y: number;
  label: string;
  posture: string;
  tone: string;
  isFaint: boolean;
  isChosen: boolean;
  ellipse: Ellipse;
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

  /// `chosen`: the condition that stands out.
  update(estimates: Estimate[], chosen: string): void {
    const tones = postureTones(estimates);
    const items = estimates
      .flatMap((estimate) => this.#item(estimate, toneClass(tones.get(postureOf(estimate)) ?? 0), chosen))
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
      this.#draw(items, estimates, (item) => grown(from.get(item.label), item.ellipse, eased), share === 1);
      if (share < 1) this.#animation = requestAnimationFrame(step);
    };
    step();
  }

  #item(estimate: Estimate, tone: string, chosen: string): Drawn[] {
    const matrix = matrixOf(estimate, this.#name);
    const ellipse = ellipseOf(matrix);
    if (!ellipse) return [];
    const label = conditionOf(estimate);
    const isChosen = label === chosen;
    const band = isWhole(estimate) || isChosen ? bandOf(matrix) : undefined;
    return [
      {
        x: estimate.posture_m[0]!,
        y: estimate.posture_m[1]!,
        label,
        posture: postureOf(estimate),
        tone,
        isFaint: !isWhole(estimate) && !isChosen,
        isChosen,
        ellipse,
        outer: band?.outer,
        inner: band?.inner,
      },
    ];
  }

  #draw(items: Drawn[], estimates: Estimate[], now: (item: Drawn) => Ellipse, isWithBands: boolean): void {
    this.#drawing.replaceChildren();
    if (items.length === 0 || !estimates[0]) {
      this.#drawing.append(svg("text", { x: SIZE / 2, y: SIZE / 2, "text-anchor": "middle" }, "nothing yet"));
      return;
    }
    const places = layout(items);
    const largest = Math.max(...items.map((item) => item.outer?.major ?? item.ellipse.major));
    const scale = places.radius / largest;
    const shape = (item: Drawn, ellipse: Ellipse, attributes: Record<string, string>): SVGElement => {
      const [x, y] = places.at(item);
      return svg("ellipse", {
        ...attributes,
        cx: x,
        cy: y,
        rx: Math.max(0.1, scale * ellipse.major),
        ry: Math.max(0.1, scale * ellipse.minor),
        transform: `rotate(${(-ellipse.angle * 180) / Math.PI} ${x} ${y})`, // the drawing's y goes down
      });
    };
    const named = new Set<string>();
    for (const item of items) {
      const { tone } = item;
      const ellipse = now(item);
      this.#shown.set(item.label, ellipse);
      const [x, y] = places.at(item);
      if (isWithBands && item.outer && item.inner) {
        this.#drawing.append(
          shape(item, item.outer, { class: `band ${tone}` }),
          shape(item, item.inner, { class: `band hole ${tone}` }),
        );
      }
      const weight = item.isFaint ? " faint" : item.isChosen ? " chosen" : "";
      const drawn = shape(item, ellipse, { class: `ellipse ${tone}${weight}`, "data-condition": item.label });
      drawn.append(svg("title", {}, item.label));
      this.#drawing.append(drawn);
      if (named.has(item.posture)) continue;
      named.add(item.posture);
      this.#drawing.append(
        svg("circle", { cx: x, cy: y, r: 2, class: tone, fill: "currentColor" }),
        svg("text", { x, y: y + places.radius + 12, "text-anchor": "middle", class: "small" }, item.posture.slice(0, 24)),
      );
    }
    const unit = unitOf(estimates[0], this.#name);
    const round = roundDown(largest);
    const length = scale * round;
    this.#drawing.append(
      svg("path", { class: "axis", d: `M 10 ${SIZE - 12} h ${length}`, "stroke-width": 2 }),
      svg("text", { x: 16 + length, y: SIZE - 8, class: "small" }, `${round} ${unit}`),
    );
  }
}

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
