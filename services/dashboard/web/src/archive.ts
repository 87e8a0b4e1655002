// The archive's page: past sessions, their results, and reports.

import { get, getJson, token } from "./access";
import { Connection } from "./connection";
import type { Estimate, TrialVerdict } from "./contract";
import { el, panel, setText } from "./dom";
import { groupReports, type Report, type ReportFile } from "./reports";
import { archivedMessages } from "./framed_messages";
import { endNames, nameOf } from "./names";
import { ResultsView } from "./results_view";
import { buildShell } from "./shell";

interface Certificate {
  expected: number;
  received: number;
  resent: number;
  duplicated: number;
  missing: number;
}

interface SessionEntry {
  session_id: string;
  subject: string;
  protocol: string;
  seed: number;
  planned_trials: number;
  started_at: string;
  software_version: string;
}

interface SessionDetail extends SessionEntry {
  certificate: Certificate;
  trials: { attempt: number; posture: string; end: number; is_certified: boolean; certificate: Certificate }[];
}

const connection = new Connection();
const { main, say } = buildShell(connection, "/archive");
const view = new ResultsView({ say });

const sessionBody = el("tbody", { id: "sessions" });
const sessions = panel("Sessions", "session-list", listTable(["Started (UTC)", "Subject", "Protocol", "Trials", "Session"], sessionBody));
const reportList = el("div", { id: "reports" });
const reports = panel("Reports", "report-list", reportList);
const facts = el("p", { id: "session-facts" }, "Choose a session above.");
const trialBody = el("tbody", { id: "trials" });
const detail = panel("Session", "session-detail", facts, listTable(["Trial", "Posture", "End", "Verdict", "Samples", "Certified"], trialBody));
const again = el("button", { type: "button", id: "reload" }, "Read again");
again.addEventListener("click", () => void load());
main.append(el("div", { class: "row" }, again), el("div", { class: "columns wide" }, sessions.root, reports.root), detail.root, view.root);
view.root.hidden = true;

/// To the minute.
const timeText = (iso: string): string => iso.slice(0, 16).replace("T", " ");

function listTable(heads: string[], body: HTMLElement): HTMLElement {
  const head = el("tr", {}, ...heads.map((name) => el("th", { scope: "col" }, name)));
  return el("div", { class: "scroll", tabindex: 0 }, el("table", {}, el("thead", {}, head), body));
}

async function load(): Promise<void> {
  await Promise.all([loadSessions(), loadReports()]);
}

async function loadSessions(): Promise<void> {
  try {
    const list = await getJson<SessionEntry[]>("/api/sessions");
    setText(sessions.age, `${list.length} in the archive, read ${new Date().toLocaleTimeString()}`);
    sessionBody.replaceChildren(...list.map(sessionRow));
    const wanted = location.hash.slice(1);
    if (wanted && list.some((entry) => entry.session_id === wanted)) await show(wanted);
  } catch (error) {
    setText(sessions.age, (error as Error).message);
  }
}

function sessionRow(entry: SessionEntry): HTMLElement {
  const open = el("button", { type: "button", "data-session": entry.session_id }, entry.session_id.slice(0, 8));
  open.addEventListener("click", () => {
    location.hash = entry.session_id;
    void show(entry.session_id);
  });
  return el(
    "tr",
    {},
    el("td", { class: "time" }, timeText(entry.started_at)),
    el("td", {}, entry.subject),
    el("td", {}, entry.protocol),
    el("td", { class: "number" }, String(entry.planned_trials)),
    el("td", {}, open),
  );
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
    const byAttempt = new Map(verdicts.map((verdict) => [verdict.attempt, verdict]));
    const c = found.certificate;
    setText(
      facts,
      `${found.subject}, ${found.protocol}, seed ${found.seed}, started ${found.started_at}, version ${found.software_version}. ` +
        `${found.trials.length} trials; samples: ${c.expected} expected, ${c.received} received, ${c.resent} resent, ${c.missing} missing.`,
    );
    facts.dataset["session"] = id;
    trialBody.replaceChildren(...found.trials.map((trial) => trialRow(trial, byAttempt.get(trial.attempt))));
    view.clear();
    view.root.hidden = false;
    for (const estimate of estimates) view.add(estimate);
    setText(view.age, "from the archive");
    setText(detail.age, `${id}, read ${new Date().toLocaleTimeString()}`);
  } catch (error) {
    setText(detail.age, (error as Error).message);
  }
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
