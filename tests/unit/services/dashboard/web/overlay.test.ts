import assert from "node:assert/strict";
import { test } from "node:test";
import { EstimateStatus, type Estimate } from "../../../../../services/dashboard/web/src/contract";
import { MOST_COMPARED, overlaid, overTime, type ComparedSession } from "../../../../../services/dashboard/web/src/overlay";
import { isToldApartInGrey } from "../../../../../services/dashboard/web/src/posture_style";
import { estimate } from "./estimate";

const session = (started_at: string, estimates: Estimate[]): ComparedSession => ({ id: started_at, name: started_at, started_at, estimates });
const at = (x: number, y: number): Float64Array => new Float64Array([x, y]);

test("sessions are drawn over each other where the first one measured the posture", () => {
  const small = session("2026-03-02", [estimate({ posture_m: at(0, 0.5) })]);
  const tall = session("2026-03-03", [estimate({ posture_m: at(0.02, 0.6) }), estimate({ posture: "left", posture_m: at(-0.2, 0.4) })]);
  const { estimates, looks } = overlaid([small, tall], "state_variable");
  assert.deepEqual(estimates.map((one) => [looks.get(one)!.letter, one.posture, ...one.posture_m]), [["A", "distal", 0, 0.5], ["B", "distal", 0, 0.5], ["B", "left", -0.2, 0.4]]);
  assert.deepEqual([...tall.estimates[0]!.posture_m], [0.02, 0.6], "the session's own estimate stays as it is");
});

test("single sets, other methods and what is not determined are not drawn over each other", () => {
  const others = [estimate({ set_number: 1 }), estimate({ method: "lowpass" }), estimate({ status: EstimateStatus.ESTIMATE_UNDETERMINED })];
  assert.deepEqual(overlaid([session("2026-03-02", others)], "state_variable").estimates, []);
});

test("estimates in another unit than the first one are left out and counted", () => {
  const ankle = estimate({ force_unit: "N m", displacement_unit: "rad" });
  const { estimates, otherUnits } = overlaid([session("2026-03-02", [estimate()]), session("2026-03-03", [ankle, ankle])], "state_variable");
  assert.equal(estimates.length, 1);
  assert.equal(otherUnits, 2);
  assert.equal(overTime([session("2026-03-02", [estimate()]), session("2026-03-03", [ankle])], "state_variable", "distal").length, 1);
});

test("over time sessions come in the order of their start, whichever is open", () => {
  const of = (day: string, posture = "distal"): ComparedSession => session(`2026-03-${day}`, [estimate({ posture })]);
  const course = overTime([of("09"), of("02"), of("05", "left"), of("04")], "state_variable", "distal");
  assert.deepEqual(course.map(({ letter, name }) => `${letter} ${name}`), ["B 2026-03-02", "D 2026-03-04", "A 2026-03-09"]);
});

test("any two of the sessions that can be compared differ in grey too", () => {
  for (let a = 0; a < MOST_COMPARED; ++a) for (let b = 0; b < a; ++b) assert.ok(isToldApartInGrey(a, b), `${a}, ${b}`);
});
