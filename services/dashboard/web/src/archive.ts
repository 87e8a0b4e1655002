// The archive's page: past sessions, their results, and reports.

import { get, getJson, token } from "./access";
import { filtered, newestOf, sorted, type SessionEntry, type SortKey } from "./archive_lists";
import { ComparisonView } from "./comparison_view";
import { Connection } from "./connection";
import type { Estimate, SessionNote, SessionPlan, SessionState, TrialOutcome, TrialReview, TrialVerdict } from "./contract";
import { el, panel, setText } from "./dom";
import { ExportPanel } from "./export_panel";
import { fitFor } from "./fit_choice";
import { groupReports, type Report, type ReportFile } from "./reports";
import { archivedMessages } from "./framed_messages";
import { endNames, hex, nameOf, sessionPhaseNames } from "./names";
import { noteRow } from "./remarks";
import { MOST_COMPARED, type ComparedSession } from "./overlay";
import { ResultsView } from "./results_view";
import { buildShell } from "./shell";
import { courseNote, TrialChart } from "./trial_chart";
import type { Course } from "./trial_recorder";
import { isRejected, keepNewest, limitsIn, verdictWhy, verdictWord } from "./trial_words";

interface Certificate {
  expected: number;
  received: number;
  resent: number;
  duplicated: number;
  missing: number;
}

interface SessionDetail extends SessionEntry {
  certificate: Certificate;
  trials: { trial_id: string; attempt: number; posture: string; end: number; is_certified: boolean; certificate: Certificate }[];
}

/// As services/dashboard/gateway/trial_course.hpp gives them.
interface Courses {
  displacement_unit: string;
  force_unit: string;
  courses: { attempt: number; posture: string; missing: number; times_s: number[]; displacement: [number[], number[]]; force: [number[], number[]] }[];
}

const connection = new Connection();
const { main, say } = buildShell(connection, "/archive");
const view = new ResultsView({ say });

const columns: readonly [SortKey, string][] = [
  ["started_at", "Started (UTC)"], ["subject", "Subject"], ["protocol", "Protocol"], ["planned_trials", "Trials"], ["state", "State"], ["session_id", "Session"],
];
const order = { key: "started_at" as SortKey, isDescending: true };
let entries: SessionEntry[] = [];
let shown: { id: string; estimates: Estimate[]; outcomes: TrialOutcome[] } | undefined;
let chosen: string[] = []; // sessions to compare with the one that is shown

const sessionBody = el("tbody", { id: "sessions" });
const filter = el("input", { type: "search", id: "filter", placeholder: "subject, protocol, date, version…" });
filter.addEventListener("input", () => showList());
const sortHeads = columns.map(([key, name]) => sortHead(key, name));
const sessionTable = el("table", {}, el("thead", {}, el("tr", {}, ...sortHeads, el("th", { scope: "col" }, "Compare"))), sessionBody);
const sessions = panel(
  "Sessions",
  "session-list",
  el("div", { class: "row" }, el("label", {}, "Filter", filter)),
  el("div", { class: "scroll steady", tabindex: 0, role: "group", "aria-label": "Sessions" }, sessionTable),
);
const reportList = el("div", { id: "reports" });
const reports = panel("Reports", "report-list", reportList);
const facts = el("p", { id: "session-facts" }, "Choose a session above.");
const trialBody = el("tbody", { id: "trials" });
const trialFilter = el(
  "select",
  { id: "trial-filter" },
  ...[["all", "all trials"], ["valid", "valid ones"], ["rejected", "rejected ones"], ["by-hand", "rejected by hand"], ["none", "without verdict"]].map(([value, name]) => el("option", { value: value! }, name!)),
);
trialFilter.addEventListener("change", () => showTrials());
const noteBody = el("tbody", { id: "notes" });
const noteTable = listTable(["Time (UTC)", "Trial", "Note", "By"], noteBody);
noteTable.hidden = true;
const exports = new ExportPanel({ say, changed: () => void loadReports() });
const comparison = new ComparisonView();
const ofSubject = el("button", { type: "button", id: "compare-subject" }, "Compare with this subject's others");
ofSubject.addEventListener("click", () => compareSubject());
const compareNone = el("button", { type: "button", id: "compare-none" }, "Compare with none");
compareNone.addEventListener("click", () => choose([]));
const detail = panel(
  "Session",
  "session-detail",
  facts,
  el("div", { class: "row" }, el("label", {}, "Trials", trialFilter), ofSubject, compareNone),
  noteTable,
  listTable(["Trial", "Posture", "End", "Verdict", "Samples", "Certified"], trialBody),
);
let chart = new TrialChart("Trial", "archived-trial");
chart.root.hidden = true;
const again = el("button", { type: "button", id: "reload" }, "Read again");
again.addEventListener("click", () => void load());
main.append(el("div", { class: "row" }, again), sessions.root, el("div", { class: "columns wide" }, exports.root, reports.root), detail.root, chart.root, comparison.root, view.root);
view.root.hidden = true;

function sortHead(key: SortKey, name: string): HTMLElement {
  const sort = el("button", { type: "button", class: "sort" }, name);
  const head = el("th", { scope: "col", "data-key": key }, sort);
  sort.addEventListener("click", () => {
    order.isDescending = order.key === key && !order.isDescending;
    order.key = key;
    showList();
  });
  return head;
}

/// "completed, pilot".
const stateText = ({ state, is_pilot }: SessionEntry): string => [state ?? "not known", ...(is_pilot ? ["pilot"] : [])].join(", ");

/// To the minute.
const timeText = (iso: string): string => iso.slice(0, 16).replace("T", " ");

function listTable(heads: string[], body: HTMLElement): HTMLElement {
  const head = el("tr", {}, ...heads.map((name) => el("th", { scope: "col" }, name)));
  return el("div", { class: "scroll", tabindex: 0, role: "group", "aria-label": heads[0]! }, el("table", {}, el("thead", {}, head), body));
}

async function load(): Promise<void> {
  await Promise.all([loadSessions(), loadReports()]);
}

async function loadSessions(): Promise<void> {
  try {
    const list = await getJson<SessionEntry[]>("/api/sessions");
    entries = list;
    showList();
    const wanted = location.hash.slice(1);
    if (wanted && list.some((entry) => entry.session_id === wanted)) await show(wanted);
  } catch (error) {
    setText(sessions.age, (error as Error).message);
  }
}

const nameOfEntry = (entry: SessionEntry): string => `${entry.subject}, ${entry.protocol}, ${timeText(entry.started_at)} (${entry.session_id.slice(0, 8)})`;

function showList(): void {
  const list = sorted(filtered(entries, filter.value), order.key, order.isDescending);
  for (const head of sortHeads) {
    const isKey = head.dataset["key"] === order.key;
    head.setAttribute("aria-sort", isKey ? (order.isDescending ? "descending" : "ascending") : "none");
  }
  const of = list.length === entries.length ? "" : `${list.length} of `;
  setText(sessions.age, `${of}${entries.length} in the archive, read ${new Date().toLocaleTimeString()}`);
  sessionBody.replaceChildren(...list.map(sessionRow));
}

function sessionRow(entry: SessionEntry): HTMLElement {
  const open = el("button", { type: "button", "data-session": entry.session_id }, entry.session_id.slice(0, 8));
  const row = el(
    "tr",
    { class: "open", "aria-current": shown?.id === entry.session_id ? "true" : undefined },
    el("td", { class: "time" }, timeText(entry.started_at)),
    el("td", {}, entry.subject),
    el("td", {}, entry.protocol),
    el("td", { class: "number" }, String(entry.planned_trials)),
    el("td", {}, stateText(entry)),
    el("td", {}, open),
    el("td", {}, chooser(entry)),
  );
  // The whole row opens it; the keyboard has the button.
  row.addEventListener("click", () => {
    location.hash = entry.session_id;
    void show(entry.session_id);
  });
  return row;
}

/// Whether a session is compared with the open one.
function chooser(entry: SessionEntry): HTMLElement {
  const isChosen = chosen.includes(entry.session_id);
  const isFull = !isChosen && chosen.length >= MOST_COMPARED - 1;
  const isShown = shown?.id === entry.session_id;
  const why = isShown ? "it is open" : isFull ? `${MOST_COMPARED} sessions are compared at most` : undefined;
  const box = el("input", { type: "checkbox", "data-compare": entry.session_id, "aria-label": `compare ${nameOfEntry(entry)}`, disabled: why !== undefined, title: why });
  box.checked = isChosen && !isShown;
  box.addEventListener("click", (event) => event.stopPropagation()); // the row opens
  box.addEventListener("change", () => {
    choose(box.checked ? [...chosen, entry.session_id] : chosen.filter((id) => id !== entry.session_id));
    sessionBody.querySelector<HTMLElement>(`[data-compare="${entry.session_id}"]`)?.focus();
  });
  return box;
}

function choose(ids: string[]): void {
  chosen = ids;
  showList();
  void compare();
}

/// The newest other sessions of the subject of the open one.
function compareSubject(): void {
  const open = entries.find(({ session_id }) => session_id === shown?.id);
  const others = entries.filter(({ session_id, subject }) => open && subject === open.subject && session_id !== open.session_id);
  choose(sorted(others, "started_at", true).slice(0, MOST_COMPARED - 1).map(({ session_id }) => session_id));
  if (!open) say("Open a session first.", true);
  else if (others.length === 0) say(`The archive has no other session of ${open.subject}.`);
  else if (others.length >= MOST_COMPARED) say(`Compared with the newest ${MOST_COMPARED - 1} of ${others.length} others.`);
}

async function loadReports(): Promise<void> {
  try {
    const found = groupReports(await getJson<ReportFile[]>("/api/reports"));
    setText(reports.age, found.length === 0 ? "none yet" : `${found.length} in the data folder`);
    const none = el("p", { class: "faint" }, "tonus report --out DATA/reports/NAME makes one.");
    reportList.replaceChildren(...(found.length > 0 ? found.map(reportEntry) : [none]));
  } catch (error) {
    setText(reports.age, (error as Error).message);
  }
}

function reportEntry(report: Report): HTMLElement {
  const link = (path: string, text: string): HTMLElement =>
    el("a", { href: reportAddress(path), target: "_blank", rel: "noopener" }, text);
  const made = el("span", { class: "faint" }, `made ${timeText(report.modified)} UTC`);
  const head = el("p", {}, el("strong", {}, report.page ? link(report.page, report.name) : report.name), " ", made);
  const files = report.files.map((path) => el("li", {}, link(path, path.slice(path.lastIndexOf("/") + 1))));
  return el("div", { class: "report" }, head, el("details", {}, el("summary", {}, `${files.length} files`), el("ul", { class: "files" }, ...files)));
}

function reportAddress(path: string): string {
  const secret = token();
  const encoded = path.split("/").map(encodeURIComponent).join("/");
  return `/reports/${encoded}${secret ? `?token=${encodeURIComponent(secret)}` : ""}`;
}

async function show(id: string): Promise<void> {
  setText(detail.age, "reading…");
  try {
    const base = `/api/sessions/${id}`;
    const found = await getJson<SessionDetail>(base);
    const verdicts = await messages<TrialVerdict>(base, "trial/verdict", "trial/verdict", "TrialVerdict");
    const estimates = await messages<Estimate>(base, "estimate/history", "estimate/condition", "Estimate");
    const [state] = await messages<SessionState>(base, "session/state", "session/state", "SessionState");
    const outcomes = await messages<TrialOutcome>(base, "trial/outcome", "trial/outcome", "TrialOutcome");
    const reviews = new Map<string, TrialReview>();
    for (const review of await messages<TrialReview>(base, "trial/review", "trial/review", "TrialReview")) keepNewest(reviews, hex(review.trial_id), review);
    const notes = await messages<SessionNote>(base, "session/note", "session/note", "SessionNote");
    const [plan] = await messages<SessionPlan>(base, "session/plan", "session/plan", "SessionPlan");
    const byAttempt = new Map(verdicts.map((verdict) => [verdict.attempt, verdict]));
    const c = found.certificate;
    setText(
      facts,
      `${found.subject}, ${found.protocol}, seed ${found.seed}, started ${found.started_at}, version ${found.software_version}. ` +
        `${state ? `${nameOf(sessionPhaseNames, state.phase)}: ${state.counted} of ${state.planned} trials counted, ${state.rejected} rejected` : "its state is not in the archive"}. ` +
        `${plan ? originOf(plan) : ""}${found.trials.length} trials; samples: ${c.expected} expected, ${c.received} received, ${c.resent} resent, ${c.missing} missing.`,
    );
    facts.dataset["session"] = id;
    trials = found.trials.map((trial) => ({ trial, verdict: byAttempt.get(trial.attempt), review: reviews.get(trial.trial_id) }));
    showNotes(notes);
    exports.showSession(id);
    shownTrial = 0;
    chart.root.hidden = true;
    showTrials();
    shown = { id, estimates, outcomes };
    chosen = chosen.filter((other) => other !== id);
    showList();
    void compare();
    view.clear();
    view.setPlan(plan);
    view.root.hidden = false;
    for (const estimate of estimates) view.add(estimate);
    setText(view.age, "from the archive");
    setText(detail.age, `${id}, read ${new Date().toLocaleTimeString()}`);
  } catch (error) {
    setText(detail.age, (error as Error).message);
  }
}

/// Operator, study and pilot mode, as far as the plan has them.
function originOf({ operator_name, study, is_pilot }: SessionPlan): string {
  const parts = [operator_name && `operator ${operator_name}`, study && `study ${study}`, is_pilot && "a pilot, no part of a study's results"].filter((part) => part);
  return parts.length > 0 ? `${parts.join(", ")}. ` : "";
}

let shownTrial = 0; // attempt; 0: none
interface ShownTrial {
  trial: SessionDetail["trials"][number];
  verdict?: TrialVerdict;
  review?: TrialReview;
}
let trials: ShownTrial[] = [];

function showNotes(notes: readonly SessionNote[]): void {
  const attempts = new Map(trials.map(({ trial }) => [trial.trial_id, trial.attempt]));
  noteTable.hidden = notes.length === 0;
  noteBody.replaceChildren(...notes.map((note) => noteRow(note, attempts.get(hex(note.trial_id)))));
}

function showTrials(): void {
  const kindOf = ({ verdict, review }: ShownTrial): string => (!verdict ? "none" : review?.is_rejected ? "by-hand rejected" : isRejected(verdict, review) ? "rejected" : "valid");
  const wanted = trials.filter((trial) => trialFilter.value === "all" || kindOf(trial).split(" ").includes(trialFilter.value));
  trialBody.replaceChildren(...wanted.map(trialRow));
}

/// The newest estimates of the open session and of the chosen ones.
async function compare(): Promise<void> {
  const [open, others] = [shown, chosen];
  if (!open || others.length === 0) return comparison.show([]);
  setText(comparison.age, "reading…");
  try {
    const found = await Promise.all([open.id, ...others].map((id) => (id === open.id ? session(id, open.estimates) : session(id))));
    if (shown !== open || chosen !== others) return; // another choice was made meanwhile
    comparison.show(found);
    setText(comparison.age, `${found.length} sessions, from the archive`);
  } catch (error) {
    comparison.show([]);
    say(`Not compared: ${(error as Error).message}`, true);
  }
}

async function session(id: string, known?: Estimate[]): Promise<ComparedSession> {
  const history = known ?? (await messages<Estimate>(`/api/sessions/${id}`, "estimate/history", "estimate/condition", "Estimate"));
  const entry = entries.find(({ session_id }) => session_id === id);
  return { id, name: entry ? nameOfEntry(entry) : id.slice(0, 8), started_at: entry?.started_at ?? "", estimates: newestOf(history, (estimate) => hex(estimate.estimate_id)) };
}

/// One trial's displacement and force about its onset, over those of the trials before it.
async function showTrial({ trial, verdict, review }: ShownTrial): Promise<void> {
  const id = shown?.id;
  shownTrial = trial.attempt;
  showTrials();
  trialBody.querySelector<HTMLElement>(`[data-trial="${trial.attempt}"]`)?.focus();
  const text = [trial.posture, verdict ? wordAndWhy(verdict, review) : "without verdict"].filter((part) => part !== "").join(", ");
  const drawn = new TrialChart("Trial", "archived-trial"); // with ranges of its own
  chart.root.replaceWith(drawn.root);
  chart = drawn;
  const units = { displacement: "m", force: "N" };
  drawn.show({ attempt: trial.attempt, text, note: "reading…" }, [], units);
  try {
    const found = await getJson<Courses>(`/api/sessions/${id}/courses/${trial.attempt}`);
    const [course, ...before] = found.courses.map((one): Course => ({ times: one.times_s, displacement: one.displacement, force: one.force }));
    const missing = found.courses[0]?.missing ?? 0;
    const lost = missing > 0 ? ` ${missing} samples of this trial are missing.` : "";
    const program = shown?.outcomes.find((outcome) => outcome.program.attempt === trial.attempt)?.program;
    const fit = course && program && fitFor(newestOf(shown?.estimates ?? [], (estimate) => hex(estimate.estimate_id)), program, course);
    const limits = found.displacement_unit === "m" ? limitsIn(verdict?.detail ?? "") : undefined;
    drawn.show({ attempt: trial.attempt, text, course, limits, fit, note: courseNote(before.length) + lost }, before, { displacement: found.displacement_unit, force: found.force_unit });
  } catch (error) {
    drawn.show({ attempt: trial.attempt, text, note: (error as Error).message }, [], units);
  }
}

const wordAndWhy = (verdict: TrialVerdict, review?: TrialReview): string =>
  isRejected(verdict, review) ? `${verdictWord(verdict, review)}: ${verdictWhy(verdict, review)}` : verdictWord(verdict, review);

function trialRow(one: ShownTrial): HTMLElement {
  const { trial, verdict, review } = one;
  const c = trial.certificate;
  const isShown = trial.attempt === shownTrial;
  const open = el("button", { type: "button", class: "sort", title: "Show this trial below", "data-trial": trial.attempt, "aria-pressed": String(isShown) }, String(trial.attempt));
  open.addEventListener("click", () => void showTrial(one));
  return el(
    "tr",
    { class: isShown ? "chosen" : undefined },
    el("td", {}, open),
    el("td", {}, trial.posture),
    el("td", {}, nameOf(endNames, trial.end)),
    el("td", { class: verdict && !isRejected(verdict, review) ? "good" : "bad", title: verdict?.detail }, verdict ? wordAndWhy(verdict, review) : "none"),
    el("td", { class: c.missing > 0 ? "number bad" : "number" }, `${c.received} of ${c.expected}`),
    el("td", {}, trial.is_certified ? "yes" : "no"),
  );
}

async function messages<T>(base: string, topic: string, channel: string, type: string): Promise<T[]> {
  const schema = await connection.schema(channel);
  return archivedMessages<T>(`${base}/messages?topic=${topic}`, `tonus::v1::${type}`, schema);
}

connection.onState((state) => {
  if (state === "connected") void load();
});
document.addEventListener("tonus-token", () => {
  void get("/api/role").then(() => load());
});
