import assert from "node:assert/strict";
import { test } from "node:test";
import { EstimateStatus } from "../../../../../services/dashboard/web/src/contract";
import { halfWidthsOf, numbersOfElements, relativeHalfWidth } from "../../../../../services/dashboard/web/src/ellipse_numbers";
import { progressText } from "../../../../../services/dashboard/web/src/ellipse_table";
import { colourOf, dashOf, isToldApartInGrey, placesOf } from "../../../../../services/dashboard/web/src/posture_style";
import { estimate, matrix } from "./estimate";

const near = (found: number, wanted: number, within = 1e-6): void => assert.ok(Math.abs(found - wanted) <= within * Math.max(1, Math.abs(wanted)), `${found} is not ${wanted}`);

test("size, shape, orientation and curl are those of the closed form", () => {
  const found = numbersOfElements([3, 1.2, 0.8, 3])!; // eigenvalues of the symmetric part 4 and 2, at 45 deg; za 0.2
  near(found.size, 8 * Math.PI);
  near(found.shape, 2);
  near(found.orientation_deg, 45);
  near(found.curl, 0.2 / Math.sqrt(8));
  assert.equal(numbersOfElements([1, 2, 2, 1]), undefined);
});

test("half widths are the first-order ones of a diagonal matrix", () => {
  // diag(2, 1), errors 0.1, quantile 2: d size = pi (dxx + 2 dyy), d shape = dxx - 2 dyy, d angle = (dxy + dyx)/2, curl has
  // a corner at zero, where the derivative is zero by symmetry.
  const half = halfWidthsOf(matrix());
  near(half.size, 0.2 * Math.PI * Math.sqrt(5), 1e-4);
  near(half.shape, 0.2 * Math.sqrt(5), 1e-4);
  near(half.orientation_deg, (0.2 * Math.SQRT1_2 * 180) / Math.PI, 1e-4);
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
