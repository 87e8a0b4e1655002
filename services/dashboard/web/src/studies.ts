// The studies' page: subjects, sessions done and due, and who is next.

import { getJson } from "./access";
import { Connection } from "./connection";
import { el, panel, setText } from "./dom";
import { buildShell } from "./shell";
import { doneLine, nextLine, sessionWord, startAddress, type Study, type StudySession, type StudySubject } from "./study_words";

const connection = new Connection();
const { main, say, desk } = buildShell(connection, "/studies");
const again = el("button", { type: "button", id: "reload" }, "Read again");
const list = el("div", { id: "studies", class: "stack" });
again.addEventListener("click", () => void load());
main.append(el("div", { class: "row" }, again), list);
let lastSession = "";

async function load(): Promise<void> {
  try {
    const studies = await getJson<Study[]>("/api/studies");
    const none = el("p", { class: "faint" }, "There is no study: a protocol of the kind study in the folder of the protocols makes one.");
    list.replaceChildren(...(studies.length > 0 ? studies.map(studyPanel) : [none]));
  } catch (error) {
    say(`The studies cannot be read: ${(error as Error).message}`, true);
  }
}

function studyPanel(study: Study): HTMLElement {
  const head = ["Subject", "Sessions", "Done", "Due", "Others"].map((name) => el("th", { scope: "col", class: name === "Done" || name === "Due" ? "number" : undefined }, name));
  const table = el("table", {}, el("thead", {}, el("tr", {}, ...head)), el("tbody", {}, ...study.subjects.map((subject) => subjectRow(subject, study))));
  const next = el("p", { class: "next", "data-study": study.study }, nextLine(study), ...(study.next ? [" ", el("a", { href: startAddress(study, study.next), class: "button" }, "Prepare this session")] : []));
  const made = panel(study.study, `study-${study.study.replace(/[^a-zA-Z0-9]/g, "-")}`, next, el("div", { class: "scroll tall", tabindex: 0, role: "group", "aria-label": `Subjects of ${study.study}` }, table));
  setText(made.age, doneLine(study));
  return made.root;
}

function subjectRow(subject: StudySubject, { next }: Study): HTMLElement {
  return el(
    "tr",
    { class: next?.subject === subject.subject ? "chosen" : undefined, "data-subject": subject.subject },
    el("td", {}, subject.subject),
    el("td", {}, ...subject.sessions.map(sessionEntry)),
    el("td", { class: "number" }, String(subject.done)),
    el("td", { class: "number" }, subject.due === null ? "not known" : String(subject.due)),
    el("td", {}, ...subject.others.map(sessionEntry)),
  );
}

function sessionEntry(session: StudySession): HTMLElement {
  const word = sessionWord(session);
  const text = session.session_id ? el("a", { href: `/archive#${session.session_id}` }, word) : word;
  return el("div", { class: session.is_done ? "good" : undefined }, text);
}

connection.onState((state) => {
  if (state === "connected") void load();
});
// What is done changes when a session ends.
setInterval(() => {
  const state = desk.session.value;
  const key = state ? `${state.phase} ${state.session_id.join()}` : "";
  if (key !== lastSession) void load();
  lastSession = key;
}, 1000);
document.addEventListener("tonus-token", () => void load());
