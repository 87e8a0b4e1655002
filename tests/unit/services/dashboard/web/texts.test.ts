import assert from "node:assert/strict";
import { test } from "node:test";
import { estimatesText } from "../../../../../services/dashboard/web/src/estimates_text";
import { Fresh, ageText, duration } from "../../../../../services/dashboard/web/src/freshness";
import { groupReports } from "../../../../../services/dashboard/web/src/reports";
import { estimate } from "./estimate";

test("the table has a head and a line for each estimate, every number in full", () => {
  const [heads, line, ...rest] = estimatesText([estimate({ sigma_N: new Float64Array([1 / 3, 0]) })], "\t").split("\n");
  assert.deepEqual(rest, [""]);
  const fields = new Map(heads!.split("\t").map((head, i) => [head, line!.split("\t")[i]]));
  assert.equal(fields.get("sigma_x_N"), String(1 / 3));
  assert.equal(fields.get("K_N_per_m_xx_high95"), "2.2");
  assert.equal(fields.get("spring_y_m"), "-0.002");
  assert.equal(fields.size, line!.split("\t").length);
});

test("the table carries session, subject, protocol, time, version and reasons, and the paper's own numbers", () => {
  const facts = { subject: "sub-07", protocol: "unloaded", seed: "7", started_at: "2026-03-02T11:00:00Z", software_version: "0.9.0", operator: "Anna", study: "cohort", is_pilot: "yes" };
  const [heads, line] = estimatesText([estimate({ reasons: ["wide", "few"] })], "\t", facts).split("\n");
  const fields = new Map(heads!.split("\t").map((head, i) => [head, line!.split("\t")[i]]));
  assert.equal(fields.get("session"), "0".repeat(32));
  assert.equal(fields.get("subject"), "sub-07");
  assert.equal(fields.get("started_at"), "2026-03-02T11:00:00Z");
  assert.equal(fields.get("software_version"), "0.9.0");
  assert.equal(fields.get("operator"), "Anna");
  assert.equal(fields.get("study"), "cohort");
  assert.equal(fields.get("is_pilot"), "yes");
  assert.equal(fields.get("reasons"), "wide; few");
  assert.equal(fields.get("K_shape"), "0.5");
  assert.equal(fields.size, heads!.split("\t").length, "no head comes twice");
});

test("text with the separator or quotes in it is quoted", () => {
  const text = estimatesText([estimate({ instruction: 'say "now", then relax' })], ",");
  assert.ok(text.includes('"say ""now"", then relax"'));
});

test("an age is told in the unit that can be read", () => {
  assert.equal(ageText(undefined), "no value yet");
  assert.equal(ageText(0.4), "now");
  assert.equal(ageText(119), "119 s old");
  assert.equal(ageText(600), "10 min old");
  assert.equal(ageText(36000), "10 h old");
});

test("a value that was written long before it arrived is as old as its writing", () => {
  const value = new Fresh<number>();
  assert.equal(value.age, undefined);
  value.set({ value: 1, writtenNs: BigInt(Date.now() - 60_000) * 1_000_000n });
  assert.ok(value.age! >= 60);
});

test("a value grows old while the machine sleeps, when only the clock on the wall goes on", () => {
  const now = Date.now;
  try {
    const value = new Fresh<number>();
    value.set({ value: 1, writtenNs: BigInt(now()) * 1_000_000n });
    Date.now = (): number => now() + 60_000;
    assert.ok(value.age! >= 60);
  } finally {
    Date.now = now;
  }
});

test("durations are whole seconds", () => {
  assert.equal(duration(59.6), "1 min 00 s");
  assert.equal(duration(-1), "0 s");
  assert.equal(duration(NaN), "–");
});

test("reports are folders, the newest first, with their page and their files in order", () => {
  const file = (path: string, modified: string) => ({ path, bytes: 1, modified });
  const [newest, oldest, ...rest] = groupReports([
    file("pilot.html", "2026-01-01T00:00:00Z"),
    file("study/figure10.svg", "2026-01-02T00:00:00Z"),
    file("study/figure9.svg", "2026-01-02T00:00:00Z"),
    file("study/figure9.gp", "2026-01-09T00:00:00Z"),
    file("study/index.html", "2026-01-03T00:00:00Z"),
  ]);
  assert.deepEqual(rest, []);
  assert.deepEqual(newest, {
    name: "study", page: "study/index.html", modified: "2026-01-03T00:00:00Z",
    files: ["study/figure9.svg", "study/figure10.svg", "study/index.html"],
  });
  assert.equal(oldest?.page, "pilot.html");
});
