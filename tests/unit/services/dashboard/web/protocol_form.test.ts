import assert from "node:assert/strict";
import { test } from "node:test";
import { jobLine } from "../../../../../services/dashboard/web/src/job_words";
import { choicesOf, enteredText, placeOf, tomlOf, valueOf, widgetOf, type ProtocolKey, type Table } from "../../../../../services/dashboard/web/src/protocol_form";
import { doneLine, nextLine, sessionWord, startAddress, type Study, type StudySession } from "../../../../../services/dashboard/web/src/study_words";

const key = (expected: string): ProtocolKey => ({ name: "bias.force_N", expected, preset: "", is_needed: true, unit: "N" });

test("how a key is entered follows from what the checker expects", () => {
  for (const [expected, widget] of [
    ["true or false", "flag"], ["one of unloaded, loaded", "choice"], ["a list, each one of none, +major", "choices"], ["text of 1 to 80 characters", "text"],
    ["[x, y], each -1 to 1 m", "numbers"], ["[low, high] with low <= high, or one number, 0.05 to 20 N", "numbers"], ["0.0005 to 0.03 m", "number"], ["a whole number, 1 to 64", "number"],
  ] as const) assert.equal(widgetOf(key(expected)), widget, expected);
  assert.deepEqual(choicesOf(key("a list, each one of none, +major")), ["none", "+major"]);
  assert.deepEqual(placeOf("posture[].position_m"), { parent: "", table: "posture", isList: true, key: "position_m" });
  assert.deepEqual(placeOf("kind"), { parent: "", table: "", isList: false, key: "kind" });
  assert.deepEqual(placeOf("recording[].event[].set"), { parent: "recording", table: "event", isList: true, key: "set" });
});

test("what is entered becomes a value, and is shown as it was entered", () => {
  assert.equal(valueOf("", "number"), undefined);
  assert.equal(valueOf("0.005", "number"), 0.005);
  assert.equal(valueOf("five", "number"), "five"); // the checker refuses it
  assert.deepEqual(valueOf("0.7, 1", "numbers"), [0.7, 1]);
  assert.equal(valueOf("1.5", "numbers"), 1.5);
  assert.deepEqual(valueOf("none, +major", "choices"), ["none", "+major"]);
  assert.equal(valueOf("true", "flag"), true);
  assert.equal(enteredText([0.7, 1]), "0.7, 1");
  assert.equal(enteredText(undefined), "");
});

test("a document is written as TOML: keys, tables, lists of tables, texts escaped", () => {
  const text = tomlOf({ posture: [{ name: "distal", position_m: [0, 0.52] }], schema: 1, name: 'a "b"\\\n', cue: { shows_cursor: true } });
  assert.equal(text, 'schema = 1\nname = "a \\"b\\"\\\\\\n"\n\n[cue]\nshows_cursor = true\n\n[[posture]]\nname = "distal"\nposition_m = [0, 0.52]\n');
});

test("tables inside the tables of a list are written with their own", () => {
  const event = (set: number): Table => ({ set, bias_N: [0, 1] });
  const text = tomlOf({ recording: [{ name: "a", event: [event(1), event(2)] }, { name: "b" }], kind: "replay" });
  assert.equal(text, 'kind = "replay"\n\n[[recording]]\nname = "a"\n\n[[recording.event]]\nset = 1\nbias_N = [0, 1]\n\n[[recording.event]]\nset = 2\nbias_N = [0, 1]\n\n[[recording]]\nname = "b"\n');
});

const session = (more: Partial<StudySession>): StudySession => ({ protocol: "loaded", session_id: null, state: null, counted: 0, planned: 0, is_pilot: false, is_done: false, ...more });

test("a study says what is done and due, and who is next", () => {
  const study: Study = { study: "cohort", problem: null, next: { subject: "s04", protocol: "loaded", file: "loaded", seed: 4 }, subjects: [{ subject: "s04", seed: 4, done: 1, due: 1, sessions: [], others: [] }] };
  assert.equal(nextLine(study), "Next: s04, loaded.");
  assert.equal(nextLine({ ...study, next: null }), "Every session is done.");
  assert.equal(doneLine(study), "1 of 2 sessions done, 0 of 1 subjects");
  assert.equal(doneLine({ ...study, subjects: [{ ...study.subjects[0]!, due: null }] }), "1 sessions done");
  assert.equal(startAddress(study, study.next!), "/#subject=s04&study=cohort&protocol=loaded&seed=4");
  assert.equal(sessionWord(session({})), "loaded: due");
  assert.equal(sessionWord(session({ session_id: "5a", state: "aborted", counted: 5, planned: 40 })), "loaded: aborted after 5 of 40");
  assert.equal(sessionWord(session({ session_id: "5a", state: "completed", is_pilot: true })), "loaded: completed, pilot");
});

test("a job says how far it is, or why it failed", () => {
  const job = { number: 1, what: "export", subject: "5a5a5a5a bids", state: "running", done: 3, total: 40, message: "", path: "" } as const;
  assert.equal(jobLine(job), "Export 5a5a5a5a bids: 3 of 40");
  assert.equal(jobLine({ ...job, total: 0 }), "Export 5a5a5a5a bids: begun");
  assert.equal(jobLine({ ...job, state: "failed", message: "the disk is full" }), "Export 5a5a5a5a bids: failed: the disk is full");
});
