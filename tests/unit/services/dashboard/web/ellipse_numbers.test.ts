import assert from "node:assert/strict";
import { test } from "node:test";
import { EstimateStatus } from "../../../../../services/dashboard/web/src/contract";
import { intervalOf, relativeHalfWidth, withInterval } from "../../../../../services/dashboard/web/src/ellipse_numbers";
import { progressText } from "../../../../../services/dashboard/web/src/ellipse_table";
import { colourOf, dashOf, isToldApartInGrey, placesOf } from "../../../../../services/dashboard/web/src/posture_style";
import { estimate, matrix } from "./estimate";

const near = (found: number, wanted: number, within = 1e-6): void => assert.ok(Math.abs(found - wanted) <= within * Math.max(1, Math.abs(wanted)), `${found} is not ${wanted}`);

test("a number is shown with its interval, to two digits of what is known of it", () => {
  assert.deepEqual(intervalOf(matrix(), "shape"), [0.47, 0.53]);
  assert.equal(withInterval(0.5, [0.47, 0.53]), "0.500 [0.470, 0.530]");
  assert.equal(withInterval(31.4159, [28, 35]), "31.4 [28.0, 35.0]");
  assert.equal(withInterval(88, [71, 105]), "88 [71, 105]");
});

test("an interval that is not known is not shown", () => {
  for (const low of [NaN, -Infinity]) assert.equal(intervalOf(matrix({ size_low95: low }), "size"), undefined);
  assert.equal(withInterval(2, undefined), "2.000");
  assert.equal(withInterval(NaN, undefined), "–");
});

test("how well a posture is known is the widest interval over the largest element, after its trials of the plan", () => {
  near(relativeHalfWidth(matrix(), [0, 1, 2, 3]), 0.1);
  const known = estimate({ trials_used: 6, trials_rejected: 1 });
  assert.equal(progressText(known, "K", 8), "K ±10.0 % of its largest element after 6 of 8 trials, 1 rejected");
  assert.equal(progressText({ ...known, status: EstimateStatus.ESTIMATE_UNDETERMINED }, "K", undefined), "undetermined after 6 trials, 1 rejected");
});

test("a posture looks the same in every session", () => {
  const alone = placesOf(["distal"]).get("distal");
  assert.equal(placesOf(["left", "reference", "proximal", "distal", "right"]).get("distal"), alone);
  assert.equal(placesOf(["elsewhere"]).get("elsewhere"), placesOf(["distal", "elsewhere"]).get("elsewhere"));
});

test("any two of many postures differ in colour, or in marker and dash, and in grey while there are six", () => {
  const names = ["distal", "left", "proximal", "reference", "right", "high", "p7", "p8", "p9", "p10", "p11", "p12"];
  const places = [...placesOf(names).values()];
  assert.equal(new Set(places).size, names.length);
  for (const [i, a] of places.entries())
    for (const b of places.slice(i + 1)) assert.ok(isToldApartInGrey(a, b) ? dashOf(a) !== dashOf(b) : colourOf(a) !== colourOf(b), `${a}, ${b}`);
  const first = [...placesOf(names.slice(0, 6)).values()];
  for (const [i, a] of first.entries()) for (const b of first.slice(i + 1)) assert.ok(isToldApartInGrey(a, b), `${a}, ${b}`);
});
