// The archive's page: past sessions, their results, and reports.

import { get, getJson, token } from "./access";
import { differences, filtered, newestOf, sorted, type Difference, type SessionEntry, type SortKey } from "./archive_lists";
import { Connection } from "./connection";
import type { Estimate, SessionPlan, SessionState, TrialVerdict } from "./contract";
import { el, panel, setText } from "./dom";
import { groupReports, type Report, type ReportFile } from "./reports";
import { archivedMessages } from "./framed_messages";
import { withError } from "./matrices";
import { endNames, hex, nameOf, sessionPhaseNames } from "./names";
import { ResultsView } from "./results_view";
import { buildShell } from "./shell";

interface Certificate {
  expected: number;
  received: number;
  resent: number;
  duplicated: number;
  missing: number;
}

interface SessionDetail extends SessionEntry {
  certificate: Certificate;
  trials: { attempt: number; posture: string; end: number; is_certified: boolean; certificate: Certificate }[];
}

const connection = new Connection();
const { main, say } = buildShell(connection, "/archive");
const view = new ResultsView({ say });

const columns: readonly [SortKey, string][] = [
  ["started_at", "Started (UTC)"], ["subject", "Subject"], ["protocol", "Protocol"], ["planned_trials", "Trials"], ["session_id", "Session"],
];
const order = { key: "started_at" as SortKey, isDescending: true };
let entries: SessionEntry[] = [];
let shown: { id: string; estimates: Estimate[] } | undefined;

const sessionBody = el("tbody", { id: "sessions" });
const filter = el("input", { type: "search", id: "filter", placeholder: "subject, protocol, date, version…" });
filter.addEventListener("input", () => showList());
const sortHeads = columns.map(([key, name]) => sortHead(key, name));
const sessionTable = el("table", {}, el("thead", {}, el("tr", {}, ...sortHeads)), sessionBody);
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
  ...[["all", "all trials"], ["valid", "valid ones"], ["rejected", "rejected ones"], ["none", "without verdict"]].map(([value, name]) => el("option", { value: value! }, name!)),
);
trialFilter.addEventListener("change", () => showTrials());
const compared = el("select", { id: "compare" }, el("option", { value: "" }, "no other session"));
compared.addEventListener("change", () => void compare());
const differenceBody = el("tbody", { id: "differences" });
const differencePanel = panel("Difference to the other session, ± half of the 95 % interval", "difference", listTable(["Condition, method", "Element", "Here", "There", "Difference", "Unit"], differenceBody));
const detail = panel(
  "Session",
  "session-detail",
  facts,
  el("div", { class: "row" }, el("label", {}, "Trials", trialFilter), el("label", {}, "Compare with", compared)),
  listTable(["Trial", "Posture", "End", "Verdict", "Samples", "Certified"], trialBody),
);
const again = el("button", { type: "button", id: "reload" }, "Read again");
again.addEventListener("click", () => void load());
main.append(el("div", { class: "row" }, again), el("div", { class: "columns wide" }, sessions.root, reports.root), detail.root, differencePanel.root, view.root);
view.root.hidden = true;
differencePanel.root.hidden = true;

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
    compared.replaceChildren(el("option", { value: "" }, "no other session"), ...list.map((entry) => el("option", { value: entry.session_id }, nameOfEntry(entry))));
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
    el("td", {}, open),
  );
  // The whole row opens it; the keyboard has the button.
  row.addEventListener("click", () => {
    location.hash = entry.session_id;
    void show(entry.session_id);
  });
  return row;
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
    const byAttempt = new Map(verdicts.map((verdict) => [verdict.attempt, verdict]));
    const c = found.certificate;
    setText(
      facts,
      `${found.subject}, ${found.protocol}, seed ${found.seed}, started ${found.started_at}, version ${found.software_version}. ` +
        `${state ? `${nameOf(sessionPhaseNames, state.phase)}: ${state.counted} of ${state.planned} trials counted, ${state.rejected} rejected` : "its state is not in the archive"}. ` +
        `${found.trials.length} trials; samples: ${c.expected} expected, ${c.received} received, ${c.resent} resent, ${c.missing} missing.`,
    );
    facts.dataset["session"] = id;
    trials = found.trials.map((trial) => ({ trial, verdict: byAttempt.get(trial.attempt) }));
    showTrials();
    shown = { id, estimates };
    showList();
    void compare();
    const [plan] = await messages<SessionPlan>(base, "session/plan", "session/plan", "SessionPlan");
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

let trials: { trial: SessionDetail["trials"][number]; verdict?: TrialVerdict }[] = [];

function showTrials(): void {
  const kindOf = (verdict?: TrialVerdict): string => (!verdict ? "none" : verdict.is_valid ? "valid" : "rejected");
  const wanted = trials.filter(({ verdict }) => trialFilter.value === "all" || kindOf(verdict) === trialFilter.value);
  trialBody.replaceChildren(...wanted.map(({ trial, verdict }) => trialRow(trial, verdict)));
}

/// The newest estimates of the session on display and of the other one, element by element.
async function compare(): Promise<void> {
  const id = compared.value;
  differencePanel.root.hidden = !shown || id === "";
  if (!shown || id === "") return;
  setText(differencePanel.age, "reading…");
  try {
    const other = await messages<Estimate>(`/api/sessions/${id}`, "estimate/history", "estimate/condition", "Estimate");
    if (compared.value !== id) return;
    const idOf = (estimate: Estimate): string => hex(estimate.estimate_id);
    const rows = differences(newestOf(shown.estimates, idOf), newestOf(other, idOf));
    differenceBody.replaceChildren(...rows.map(differenceRow));
    setText(differencePanel.age, rows.length > 0 ? `${rows.length} elements in common` : "no condition in common");
  } catch (error) {
    setText(differencePanel.age, (error as Error).message);
  }
}

function differenceRow(row: Difference): HTMLElement {
  const isApart = Math.abs(row.difference) > row.half95;
  return el(
    "tr",
    {},
    el("td", {}, `${row.condition}, ${row.method}`),
    el("td", {}, `${row.matrix}${row.element}`),
    el("td", { class: "number" }, row.here.toPrecision(4)),
    el("td", { class: "number" }, row.other.toPrecision(4)),
    el("td", { class: "number", title: isApart ? "the interval does not hold zero" : "the interval holds zero" }, withError(row.difference, row.half95) + (isApart ? " *" : "")),
    el("td", {}, row.unit),
  );
}

function trialRow(trial: SessionDetail["trials"][number], verdict?: TrialVerdict): HTMLElement {
  const c = trial.certificate;
  return el(
    "tr",
    {},
    el("td", {}, String(trial.attempt)),
    el("td", {}, trial.posture),
    el("td", {}, nameOf(endNames, trial.end)),
    el("td", { class: verdict?.is_valid ? "good" : "bad", title: verdict?.detail }, verdict ? (verdict.is_valid ? "valid" : `rejected: ${verdict.detail}`) : "none"),
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
