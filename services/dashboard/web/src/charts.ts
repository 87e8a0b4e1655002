// Small drawings of estimates: dots with intervals, spring centres, convergence.

import { EstimateStatus, type Estimate } from "./contract";
import { svg } from "./dom";
import {
  conditionOf,
  elementNames,
  elementsOf,
  ellipseOf,
  matrixNames,
  matrixOf,
  isWhole,
  methodOf,
  postureOf,
  toneClass,
  unitOf,
  type MatrixName,
} from "./matrices";
import { colourOf, dashOf, markerAt, postureTones } from "./posture_style";

const WIDTH = 340;
const HEIGHT = 240;
const LETTER = 6; // width of one on an axis, about
const BOX = { left: 56, right: 10, top: 24, bottom: 40 };

interface Scale {
  at: (value: number) => number;
  ticks: number[];
}

function scale(low: number, high: number, from: number, to: number): Scale {
  if (!(high > low)) [low, high] = [low - 1, high + 1];
  const step = niceStep((high - low) / 5);
  const [first, last] = [Math.floor(low / step) * step, Math.ceil(high / step) * step];
  const ticks: number[] = [];
  for (let tick = first; tick <= last + step / 2; tick += step) ticks.push(Number(tick.toPrecision(12)));
  return { at: (value) => from + ((value - first) / (last - first)) * (to - from), ticks };
}

function niceStep(rough: number): number {
  const power = 10 ** Math.floor(Math.log10(rough));
  const lead = rough / power;
  return (lead > 5 ? 10 : lead > 2 ? 5 : lead > 1 ? 2 : 1) * power;
}

function frame(label: string, unit: string, y: Scale): SVGSVGElement {
  const drawing = svg("svg", { viewBox: `0 0 ${WIDTH} ${HEIGHT}`, role: "img", width: "100%", "aria-label": label });
  for (const tick of y.ticks) {
    const at = y.at(tick);
    drawing.append(
      svg("path", { class: "axis", d: `M ${BOX.left} ${at} H ${WIDTH - BOX.right}` }),
      svg("text", { x: BOX.left - 6, y: at + 4, "text-anchor": "end", class: "small" }, String(tick)),
    );
  }
  drawing.append(svg("text", { x: 4, y: 10, class: "small" }, unit));
  return drawing;
}

const empty = (label: string): SVGSVGElement => {
  const drawing = svg("svg", { viewBox: `0 0 ${WIDTH} ${HEIGHT}`, role: "img", width: "100%", "aria-label": label });
  drawing.append(svg("text", { x: WIDTH / 2, y: HEIGHT / 2, "text-anchor": "middle" }, "nothing yet"));
  return drawing;
};

const shortened = (text: string, letters: number): string =>
  text.length > letters ? `${text.slice(0, letters - 1)}…` : text;

interface Dot {
  value: number;
  low: number;
  high: number;
  tone: number;
  title: string;
}

/// Groups of dots side by side, each with its interval.
function dots(label: string, unit: string, groups: { name: string; dots: Dot[] }[], isWithZero: boolean): SVGSVGElement {
  const all = groups.flatMap((group) => group.dots).filter((dot) => Number.isFinite(dot.value));
  if (all.length === 0) return empty(label);
  const finite = (value: number, other: number): number => (Number.isFinite(value) ? value : other);
  const low = Math.min(...all.map((dot) => finite(dot.low, dot.value)), isWithZero ? 0 : Infinity);
  const high = Math.max(...all.map((dot) => finite(dot.high, dot.value)), isWithZero ? 0 : -Infinity);
  const y = scale(low, high, HEIGHT - BOX.bottom, BOX.top);
  const drawing = frame(label, unit, y);
  const pitch = (WIDTH - BOX.left - BOX.right) / groups.length;
  const letters = Math.max(3, Math.floor(pitch / LETTER));
  groups.forEach((group, g) => {
    const middle = BOX.left + pitch * (g + 0.5);
    group.dots.forEach((dot, d) => {
      const x = middle + (d - (group.dots.length - 1) / 2) * Math.min(12, (0.8 * pitch) / group.dots.length);
      const mark = svg("g", { class: toneClass(dot.tone) });
      if (Number.isFinite(dot.low) && Number.isFinite(dot.high))
        mark.append(svg("path", { d: `M ${x} ${y.at(dot.low)} V ${y.at(dot.high)}`, "stroke-width": 2 }));
      if (Number.isFinite(dot.value))
        mark.append(svg("circle", { cx: x, cy: y.at(dot.value), r: 3.5, fill: "currentColor" }));
      mark.append(svg("title", {}, dot.title));
      drawing.append(mark);
    });
    drawing.append(
      svg("text", { x: middle, y: HEIGHT - BOX.bottom + 16, "text-anchor": "middle", class: "small" }, shortened(group.name, letters)),
    );
  });
  return drawing;
}

/// Curl of M, B and K at each posture, in each condition there; 0 is a symmetric matrix.
export function curlChart(estimates: Estimate[]): SVGSVGElement {
  const plane = estimates.filter((estimate) => estimate.axes !== 1);
  return dots(
    "Curl of M, B and K",
    "curl (dimensionless)",
    [...postureTones(plane).keys()].map((posture) => ({
      name: posture,
      dots: matrixNames.flatMap((name, tone) =>
        plane
          .filter((estimate) => postureOf(estimate) === posture)
          .map((estimate) => {
            const { curl } = matrixOf(estimate, name);
            return { value: curl, low: NaN, high: NaN, tone, title: `${conditionOf(estimate)}: ${name} ${curl.toFixed(3)}` };
          }),
      ),
    })),
    true,
  );
}

/// One condition's matrix by every method that was used.
export function methodChart(estimates: Estimate[], name: MatrixName): SVGSVGElement {
  const first = estimates[0];
  if (!first) return empty("Methods");
  return dots(
    `${name} by method`,
    unitOf(first, name),
    elementsOf(first).map((i) => ({
      name: `${name}${elementNames[i]!}`,
      dots: estimates.map((estimate, tone) => {
        const matrix = matrixOf(estimate, name);
        return {
          value: matrix.value[i]!,
          low: matrix.low95[i]!,
          high: matrix.high95[i]!,
          tone,
          title: `${methodOf(estimate)}: ${matrix.value[i]!.toPrecision(4)}`,
        };
      }),
    })),
    true,
  );
}

/// A matrix's elements in each session, in the order given; the letters name the sessions.
export function sessionsChart(sessions: readonly { letter: string; name: string; estimate: Estimate }[], name: MatrixName): SVGSVGElement {
  const first = sessions[0]?.estimate;
  if (!first) return empty(`${name} by session`);
  const elements = elementsOf(first);
  const groups = sessions.map(({ letter, name: session, estimate }) => {
    const matrix = matrixOf(estimate, name);
    const dotOf = (i: number, tone: number): Dot => ({
      value: matrix.value[i]!,
      low: matrix.low95[i]!,
      high: matrix.high95[i]!,
      tone,
      title: `${session}: ${name}${elementNames[i]!} ${matrix.value[i]!.toPrecision(4)}`,
    });
    return { name: letter, dots: elements.map(dotOf) };
  });
  return dots(`${name} by session`, unitOf(first, name), groups, true);
}

interface SpringPoint {
  name: string;
  posture: string;
  isWhole: boolean;
  at: [number, number];
  low: [number, number];
  high: [number, number];
}

function springPoint(estimate: Estimate): SpringPoint {
  const { value, low95, high95 } = estimate.spring_centre_m;
  const mm = (numbers: Float64Array): [number, number] => [1000 * numbers[0]!, 1000 * numbers[1]!];
  return {
    name: conditionOf(estimate),
    posture: postureOf(estimate),
    isWhole: isWhole(estimate),
    at: mm(value),
    low: mm(low95),
    high: mm(high95),
  };
}

/// The spring centre's place from the posture, with its interval; a line leads there from the centre of the whole
/// posture, which is how far a bias force has moved it.
export function springChart(estimates: Estimate[]): SVGSVGElement {
  const label = "Spring centres from the posture";
  const points = estimates
    .filter((estimate) => estimate.axes !== 1 && Array.from(estimate.spring_centre_m.value).every(Number.isFinite))
    .map(springPoint);
  if (points.length === 0) return empty(label);
  const tones = postureTones(estimates);
  const ends = points.flatMap(({ at, low, high }) => [...at, ...low, ...high]).filter(Number.isFinite);
  const reach = 1.1 * Math.max(1, ...ends.map(Math.abs));
  const side = HEIGHT - BOX.top - BOX.bottom;
  const left = BOX.left + (WIDTH - BOX.left - BOX.right - side) / 2;
  const y = scale(-reach, reach, HEIGHT - BOX.bottom, BOX.top);
  const x = scale(-reach, reach, left, left + side);
  const drawing = frame(label, "y (mm)", y);
  for (const tick of x.ticks) {
    drawing.append(
      svg("path", { class: "axis", d: `M ${x.at(tick)} ${BOX.top} V ${HEIGHT - BOX.bottom}` }),
      svg("text", { x: x.at(tick), y: HEIGHT - BOX.bottom + 14, "text-anchor": "middle", class: "small" }, String(tick)),
    );
  }
  drawing.append(svg("text", { x: left + side / 2, y: HEIGHT - 6, "text-anchor": "middle", class: "small" }, "x (mm)"));
  for (const point of points) {
    const [px, py] = [x.at(point.at[0]), y.at(point.at[1])];
    const place = tones.get(point.posture) ?? 0;
    const mark = svg("g", { class: toneClass(colourOf(place)) });
    const whole = points.find((other) => other.isWhole && other.posture === point.posture);
    if (whole && whole !== point)
      mark.append(svg("path", { d: `M ${x.at(whole.at[0])} ${y.at(whole.at[1])} L ${px} ${py}`, class: "lead" }));
    if ([...point.low, ...point.high].every(Number.isFinite)) {
      const across = `M ${x.at(point.low[0])} ${py} H ${x.at(point.high[0])}`;
      const along = `M ${px} ${y.at(point.low[1])} V ${y.at(point.high[1])}`;
      mark.append(svg("path", { d: `${across} ${along}`, "stroke-width": 2 }));
    }
    mark.append(
      markerAt(place, px, py, point.isWhole ? 0.9 : 0.6),
      svg("title", {}, `${point.name}: ${point.at[0].toFixed(2)}, ${point.at[1].toFixed(2)} mm`),
    );
    drawing.append(mark);
  }
  return drawing;
}

/// A matrix's elements as trials came in.
export function convergenceChart(history: Estimate[], name: MatrixName): SVGSVGElement {
  const first = history[0];
  if (!first) return empty("Convergence");
  const elements = elementsOf(first);
  const values = history.flatMap((estimate) => elements.map((i) => matrixOf(estimate, name).value[i]!)).filter(Number.isFinite);
  // The first estimates of few trials may be anywhere: the axis is that of the later half, and a margin.
  const later = history.slice(Math.floor(history.length / 2));
  const ends = later.flatMap((estimate) =>
    elements.flatMap((i) => [matrixOf(estimate, name).low95[i]!, matrixOf(estimate, name).high95[i]!]),
  ).filter(Number.isFinite);
  const shown = ends.length > 0 ? ends : values;
  if (shown.length === 0) return empty("Convergence");
  const y = scale(Math.min(...shown), Math.max(...shown), HEIGHT - BOX.bottom, BOX.top);
  const lastTrial = Math.max(2, ...history.map((estimate) => estimate.trials_used));
  const x = (estimate: Estimate): number =>
    BOX.left + ((estimate.trials_used - 1) / (lastTrial - 1)) * (WIDTH - BOX.left - BOX.right);
  const drawing = frame(`Convergence of ${name}`, unitOf(first, name), y);
  const clip = (value: number): number => Math.max(BOX.top - 6, Math.min(HEIGHT - BOX.bottom + 6, value));
  elements.forEach((i, tone) => {
    const points = history.filter((estimate) => Number.isFinite(matrixOf(estimate, name).value[i]!));
    const line = points.map((estimate) => `${x(estimate)},${clip(y.at(matrixOf(estimate, name).value[i]!))}`).join(" ");
    const bounds = points.filter((estimate) => Number.isFinite(matrixOf(estimate, name).low95[i]!));
    const up = bounds.map((estimate) => `${x(estimate)},${clip(y.at(matrixOf(estimate, name).high95[i]!))}`);
    const down = bounds.map((estimate) => `${x(estimate)},${clip(y.at(matrixOf(estimate, name).low95[i]!))}`).reverse();
    drawing.append(
      svg("polygon", { points: [...up, ...down].join(" "), class: `${toneClass(tone)} area` }),
      svg("polyline", { points: line, class: toneClass(tone), fill: "none", "stroke-width": 2 }),
    );
  });
  drawing.append(
    svg("text", { x: BOX.left, y: HEIGHT - BOX.bottom + 16, class: "small" }, "1"),
    svg("text", { x: WIDTH - BOX.right, y: HEIGHT - BOX.bottom + 16, "text-anchor": "end", class: "small" }, String(lastTrial)),
    svg("text", { x: WIDTH / 2, y: HEIGHT - 8, "text-anchor": "middle", class: "small" }, "trials used"),
  );
  return drawing;
}

const REACH_MARGIN_M = 0.08;

/// The arm seen from above, at its true scale: the shoulder, the hand's places, and the ellipses there. The elbow is not
/// measured; a dotted line joins shoulder and hand.
export function armChart(estimates: Estimate[], name: MatrixName): SVGSVGElement {
  const label = `Postures before the shoulder, ellipses of ${name}`;
  const plane = estimates.filter((estimate) => estimate.axes !== 1 && isWhole(estimate));
  if (plane.length === 0) return empty(label);
  const places = postureTones(plane);
  const xs = [0, ...plane.map((estimate) => estimate.posture_m[0]!)];
  const ys = [0, ...plane.map((estimate) => estimate.posture_m[1]!)];
  const [left, right] = [Math.min(...xs) - REACH_MARGIN_M, Math.max(...xs) + REACH_MARGIN_M];
  const [near, far] = [Math.min(...ys) - REACH_MARGIN_M / 2, Math.max(...ys) + REACH_MARGIN_M];
  const pixels = Math.min((WIDTH - 20) / (right - left), (HEIGHT - 30) / (far - near));
  const x = (metres: number): number => WIDTH / 2 + pixels * (metres - (left + right) / 2);
  const y = (metres: number): number => HEIGHT - 24 - pixels * (metres - near);
  const drawing = svg("svg", { viewBox: `0 0 ${WIDTH} ${HEIGHT}`, role: "img", width: "100%", "aria-label": label });
  const ellipses = plane.map((estimate) => ({ estimate, ellipse: ellipseOf(matrixOf(estimate, name)) }));
  const largest = Math.max(0, ...ellipses.map(({ ellipse }) => ellipse?.major ?? 0));
  const scale = largest > 0 ? (pixels * 0.9 * REACH_MARGIN_M) / largest : 0;
  for (const { estimate, ellipse } of ellipses) {
    const place = places.get(postureOf(estimate)) ?? 0;
    const [px, py] = [x(estimate.posture_m[0]!), y(estimate.posture_m[1]!)];
    const mark = svg("g", { class: toneClass(colourOf(place)) });
    mark.append(svg("path", { d: `M ${x(0)} ${y(0)} L ${px} ${py}`, class: "limb" }), markerAt(place, px, py, 0.7));
    if (ellipse && estimate.status !== EstimateStatus.ESTIMATE_UNDETERMINED) {
      const turn = `rotate(${(-ellipse.angle * 180) / Math.PI} ${px} ${py})`;
      mark.append(svg("ellipse", { cx: px, cy: py, rx: scale * ellipse.major, ry: Math.max(0.1, scale * ellipse.minor), transform: turn, class: "ellipse", "stroke-dasharray": dashOf(place) }));
    }
    mark.append(svg("title", {}, conditionOf(estimate)));
    drawing.append(mark);
  }
  drawing.append(
    svg("circle", { cx: x(0), cy: y(0), r: 6, class: "shoulder" }),
    svg("text", { x: x(0) + 10, y: y(0) + 5, class: "small" }, "shoulder"),
    svg("path", { class: "axis", d: `M 10 ${HEIGHT - 8} h ${0.1 * pixels}`, "stroke-width": 2 }),
    svg("text", { x: 16 + 0.1 * pixels, y: HEIGHT - 4, class: "small" }, "0.1 m"),
  );
  return drawing;
}
