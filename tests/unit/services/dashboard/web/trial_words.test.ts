import assert from "node:assert/strict";
import { test } from "node:test";
import { factsOf, enteredOf } from "../../../../../services/dashboard/web/src/subject_facts";
import { fitOf, rootMeanSquare } from "../../../../../services/dashboard/web/src/fit_overlay";
import { checkLine, extremeLine } from "../../../../../services/dashboard/web/src/protocol_words";
import { isRejected, keepNewest, limitsIn, verdictWhy, verdictWord } from "../../../../../services/dashboard/web/src/trial_words";

const valid = { is_valid: true, detail: "valid: start 1.2 mm (limit 5.0), rest 3.0 mm/s (20.0) and 0.10 N (1.00), moved 6.1 mm (15.0), end 2.0 mm/s (25.0)" };
const invalid = { is_valid: false, detail: "off target: hand 6.1 mm from its place, allowed 5.0 mm; excursion: hand moved 17.0 mm, allowed 15.0 mm" };
const byHand = { is_rejected: true, reason: "coughed", reviewed_by: "Anna" };

test("a rejection by hand comes before the verdict, and names reason and person", () => {
  assert.equal(verdictWord(valid), "valid");
  assert.equal(verdictWord(invalid), "rejected");
  assert.equal(verdictWord(valid, byHand), "rejected by hand");
  assert.equal(verdictWhy(valid, byHand), "coughed (Anna)");
  assert.equal(isRejected(valid, byHand), true);
  assert.equal(isRejected(valid, { ...byHand, is_rejected: false }), false);
});

test("of several reviews of a trial the newest holds, whichever comes last", () => {
  const reviews = new Map<string, { reviewed_ns: bigint; name: string }>();
  keepNewest(reviews, "a", { reviewed_ns: 2n, name: "newer" });
  keepNewest(reviews, "a", { reviewed_ns: 1n, name: "older" });
  assert.equal(reviews.get("a")!.name, "newer");
});

test("the limits of excursion and force at rest are those that the verdict names", () => {
  assert.deepEqual(limitsIn(valid.detail), { excursion_m: 0.015, rest_force_N: 1 });
  assert.deepEqual(limitsIn(invalid.detail), { excursion_m: 0.015 });
  assert.deepEqual(limitsIn("early reaction: 1.20 N before the onset, allowed 1.00 N"), { rest_force_N: 1 });
  assert.deepEqual(limitsIn("valid: place not known, rest 3.0 mm/s (20.0) and 0.10 N, moved 6.1 mm (15.0), end 2.0 mm/s (25.0)"), { excursion_m: 0.015 });
  assert.deepEqual(limitsIn("gap: 12 samples are missing"), {});
});

test("a fit of the matrices that made the force leaves no residual", () => {
  // x = a t^2 on both axes: v = 2 a t, acceleration 2 a, and the parabola through it is exact.
  const [M, B, K] = [[2, 0.3, 0.2, 1], [10, 2, 1, 8], [200, 30, 40, 150]] as const;
  const times = Array.from({ length: 141 }, (_, i) => (i - 20) / 100);
  const a = [0.02, -0.01] as const;
  const displacement = a.map((one) => times.map((t) => one * t * t)) as [number[], number[]];
  const rest = (t: number): number => (t < 0 ? 0 : 1);
  const force = [0, 1].map((row) =>
    times.map((t) => [0, 1].reduce((sum, column) => {
      const at = 2 * row + column;
      return sum + M[at]! * 2 * a[column]! + B[at]! * 2 * a[column]! * t + K[at]! * a[column]! * t * t;
    }, 0)),
  ) as [number[], number[]];
  const f0 = force.map((series) => { const before = series.filter((_, i) => rest(times[i]!) === 0); return before.reduce((sum, one) => sum + one, 0) / before.length; });
  const fit = fitOf({ times, displacement, force }, { M, B, K });
  fit.residual.forEach((series, row) => series.forEach((value, i) => {
    if (i > 3 && i < times.length - 4) assert.ok(Math.abs(value + f0[row]!) < 1e-6, `${row} ${i}: ${value}`);
  }));
  assert.ok(Number.isFinite(rootMeanSquare(fit.residual)));
  assert.ok(Number.isNaN(rootMeanSquare([[], []])));
});

test("a subject's facts are entered in cm and sent in m; what is not entered is not known", () => {
  const { facts, problem } = factsOf({ age: "31", sex: "female", "upper-arm": "31.5", forearm: "", "shoulder-x": "-2,5", "shoulder-y": "12" });
  assert.equal(problem, "");
  assert.deepEqual(facts, {
    age_years: 31, sex: "female", handedness: "", measured_arm: "", height_m: null, weight_kg: null,
    link_lengths_m: [0.315, null], circumferences_m: [null, null], shoulder_m: [-0.025, 0.12],
  });
  const shown = enteredOf(facts);
  assert.equal(shown["upper-arm"], "31.5");
  assert.equal(shown["forearm"], "");
  assert.equal(shown["age"], "31");
  assert.match(factsOf({ weight: "heavy" }).problem, /^Weight \(kg\): "heavy" is not allowed/);
});

test("a preview is one line, and extremes stand beside their limits", () => {
  const found = { is_accepted: true, kind: "unloaded", name: "short", problem: null, document: null, preview: { trials: 12, duration_s: 61, postures: [], extremes: [] } };
  assert.equal(checkLine(found), "12 trials, about 1 min 01 s if none is repeated");
  assert.equal(checkLine({ ...found, is_accepted: false, problem: { key: "kind", line: 2, message: "kind: no" } }), "line 2: kind: no");
  assert.equal(extremeLine({ what: "bias force", value: 1, low: null, high: 22.25, unit: "N" }), "bias force: 1 N (allowed: at most 22.3 N)");
  assert.equal(extremeLine({ what: "nearest", value: 0.31, low: 0.1, high: 0.63, unit: "m" }), "nearest: 0.31 m (allowed: at least 0.1, at most 0.63 m)");
});
