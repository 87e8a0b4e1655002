import assert from "node:assert/strict";
import { test } from "node:test";
import { EstimateStatus, type Estimate } from "../../../../../services/dashboard/web/src/contract";
import { differences, filtered, newestOf, sorted, type SessionEntry } from "../../../../../services/dashboard/web/src/archive_lists";
import { estimate, matrix } from "./estimate";

const entry = (more: Partial<SessionEntry>): SessionEntry => ({
  session_id: "aa", subject: "sub-01", protocol: "unloaded", seed: 7, planned_trials: 24, started_at: "2026-03-02T11:00:00Z", software_version: "0.9.0", study: "", is_pilot: false, state: "completed", ...more,
});

test("the filter's words may be in any field, and all of them have to be there", () => {
  const list = [entry({}), entry({ subject: "sub-02", protocol: "loaded" })];
  assert.equal(filtered(list, "").length, 2);
  assert.deepEqual(filtered(list, "SUB-02 loaded").map((one) => one.subject), ["sub-02"]);
  assert.equal(filtered(list, "sub-01 2026-04").length, 0);
});

test("sessions are sorted by numbers as numbers, and equal ones by their start", () => {
  const list = [entry({ subject: "sub-10" }), entry({ subject: "sub-9", started_at: "2026-03-04" }), entry({ subject: "sub-9", started_at: "2026-03-03" })];
  assert.deepEqual(sorted(list, "subject", false).map((one) => one.started_at.slice(8, 10)), ["03", "04", "02"]);
  assert.deepEqual(sorted([entry({ planned_trials: 8 }), entry({ planned_trials: 24 })], "planned_trials", true).map((one) => one.planned_trials), [24, 8]);
});

test("two sessions differ by their difference, whose variance is the sum of both", () => {
  const other = estimate({ stiffness_N_per_m: matrix({ value: new Float64Array([1, 0, 0, 1]) }) });
  const rows = differences([estimate({ stiffness_N_per_m: matrix() })], [other]);
  assert.equal(rows.length, 12);
  const kxx = rows.find((row) => row.matrix === "K" && row.element === "xx")!;
  assert.equal(kxx.difference, 1);
  assert.ok(Math.abs(kxx.half95 - 2 * 0.1 * Math.SQRT2) < 1e-9); // the quantile of the elements is 2
});

test("what only one session has, or has not determined, is not compared", () => {
  const undetermined = estimate({ status: EstimateStatus.ESTIMATE_UNDETERMINED });
  assert.deepEqual(differences([estimate()], [undetermined]), []);
  assert.deepEqual(differences([undetermined], [estimate()]), []);
  assert.deepEqual(differences([estimate()], [estimate({ posture: "left" })]), []);
  assert.deepEqual(differences([estimate()], [estimate({ displacement_unit: "rad", force_unit: "N m" })]), []);
});

test("of an estimate's history the one of most trials is compared", () => {
  const history: Estimate[] = [estimate({ trials_used: 2 }), estimate({ trials_used: 8 }), estimate({ trials_used: 4 })];
  assert.deepEqual(newestOf(history, () => "one").map((one) => one.trials_used), [8]);
});
