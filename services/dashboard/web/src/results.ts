// The results' page: what has been identified so far, growing.

import { Connection } from "./connection";
import type { Estimate, SessionPlan, SessionState } from "./contract";
import { el, setText } from "./dom";
import { archivedMessages } from "./framed_messages";
import { Fresh, ageText } from "./freshness";
import { hex, isActive, nameOf, sessionPhaseNames } from "./names";
import { ResultsView } from "./results_view";
import { buildShell } from "./shell";

const connection = new Connection();
const { main, say, desk } = buildShell(connection, "/results");
const view = new ResultsView({ say });
const title = el("p", { class: "faint", id: "which" }, "No session yet.");
main.append(title, view.root);

const newest = new Fresh<Estimate>();
const held: Estimate[] = [];
let shown = "";

connection.subscribe<SessionState>("session/state", () => {
  const id = desk.session.value ? hex(desk.session.value.session_id) : "";
  if (id === shown) return;
  shown = id;
  view.clear();
  view.setPlan(desk.plan);
  for (const estimate of held) if (hex(estimate.session_id) === shown) view.add(estimate);
  void loadHistory(id);
});

connection.subscribe<Estimate>("estimate/condition", (arrival) => {
  newest.set(arrival);
  held.push(arrival.value);
  if (held.length > 4000) held.shift();
  if (hex(arrival.value.session_id) === shown) view.add(arrival.value);
});

/// What was published before this page was opened: for the convergence.
async function loadHistory(id: string): Promise<void> {
  const schema = connection.schemaOf("estimate/condition");
  if (!schema) return;
  try {
    const path = `/api/sessions/${id}/messages?topic=estimate/history`;
    const history = await archivedMessages<Estimate>(path, "tonus::v1::Estimate", schema);
    if (id === shown) for (const estimate of history) view.add(estimate);
  } catch (error) {
    // A session that has just begun is not in the archive yet; then there is no history either.
    console.info("no history:", (error as Error).message);
  }
}

connection.subscribe<SessionPlan>("session/plan", () => view.setPlan(desk.plan));

setInterval(() => {
  const state = desk.session.value;
  if (!state) return;
  setText(
    title,
    `Session ${shown.slice(0, 8)}, ${nameOf(sessionPhaseNames, state.phase)}: ${state.counted} of ${state.planned} trials counted, ${view.count} estimates.`,
  );
  const isGoing = isActive(state.phase);
  setText(view.age, `newest: ${ageText(newest.age)}`);
  view.age.className = isGoing && (newest.age ?? 0) > 60 ? "age old" : "age";
}, 250);
