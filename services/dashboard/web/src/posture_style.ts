// How postures are told apart: each has a colour, a marker and a dash that stay the same in every session and drawing. The
// usual postures have fixed places; another name always tries the same place first.

import type { Estimate } from "./contract";
import { svg } from "./dom";
import { postureOf } from "./matrices";

const usual = ["distal", "left", "proximal", "reference", "right"];
const COLOURS = 6;
const PLACES = 36; // six colours, six markers

/// Places of the postures, by name.
export function postureTones(estimates: readonly Estimate[]): Map<string, number> {
  const named = new Map<string, number>();
  for (const estimate of estimates) named.set(postureOf(estimate), estimate.posture_index);
  return placesOf([...named].sort((a, b) => a[1] - b[1]).map(([name]) => name));
}

export function placesOf(names: readonly string[]): Map<string, number> {
  const places = new Map<string, number>();
  for (const name of names) if (usual.includes(name)) places.set(name, usual.indexOf(name));
  for (const name of names) {
    if (places.has(name)) continue;
    // A place of its own colour while there is one, then of its own marker.
    const start = hash(name);
    const all = Array.from({ length: PLACES }, (_, i) => i).sort((a, b) => order(a, start) - order(b, start));
    const taken = [...places.values()];
    places.set(name, all.find((place) => !taken.includes(place)) ?? start % PLACES);
  }
  return new Map(names.map((name) => [name, places.get(name)!]));
}

/// The first six places in the order from `start`, then the next six, and so on.
const order = (place: number, start: number): number =>
  Math.floor(place / COLOURS) * COLOURS + ((place - start) % COLOURS + COLOURS) % COLOURS;

function hash(text: string): number {
  let sum = 7;
  for (const letter of text) sum = (31 * sum + letter.codePointAt(0)!) % 1_000_003;
  return sum;
}

export const colourOf = (place: number): number => place % COLOURS;
/// A place of the second six has another marker and dash than the one of its colour in the first.
const shapeOf = (place: number): number => (place + Math.floor(place / COLOURS)) % COLOURS;

const dashes = ["none", "9 3", "2 3", "12 3 2 3", "5 4", "9 3 2 3 2 3"];
export const dashOf = (place: number): string => dashes[shapeOf(place)]!;

const markers = [
  "M 5 0 A 5 5 0 1 1 5 -0.01 Z", // disc
  "M -4.5 -4.5 H 4.5 V 4.5 H -4.5 Z",
  "M 0 -5.5 L 5.5 4.5 H -5.5 Z",
  "M 0 -6 L 6 0 L 0 6 L -6 0 Z",
  "M -1.7 -5.5 H 1.7 V -1.7 H 5.5 V 1.7 H 1.7 V 5.5 H -1.7 V 1.7 H -5.5 V -1.7 H -1.7 Z", // plus
  "M 0 5.5 L 5.5 -4.5 H -5.5 Z",
];

/// The marker about (x, y) in the current colour.
export function markerAt(place: number, x: number, y: number, scale = 1): SVGElement {
  return svg("path", { d: markers[shapeOf(place)]!, transform: `translate(${x} ${y}) scale(${scale})`, fill: "currentColor", stroke: "none" });
}

/// What a legend shows: marker on a dashed line.
export function keyOf(place: number): SVGElement {
  const line = svg("path", { d: "M 0 8 H 34", stroke: "currentColor", "stroke-width": 2, "stroke-dasharray": dashOf(place) });
  return svg("svg", { viewBox: "0 0 34 16", width: 34, height: 16, "aria-hidden": "true", class: `posture-key tone-${colourOf(place)}` }, line, markerAt(place, 17, 8));
}

/// Two places look different without colour too.
export const isToldApartInGrey = (a: number, b: number): boolean => shapeOf(a) !== shapeOf(b);
