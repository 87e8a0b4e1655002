// The protocols' page: looks at a protocol, edits it in a form, and checks it as the scheduler will.

import { getJson } from "./access";
import { Connection } from "./connection";
import { el, panel, setText } from "./dom";
import { keepEditedProtocol } from "./edited_protocol";
import { LatestCheck } from "./protocol_check";
import { ProtocolEditor } from "./protocol_editor";
import { textIn, type ProtocolKey, type Table } from "./protocol_form";
import { checkLine, extremeLine, type ProtocolCheck } from "./protocol_words";
import { buildShell } from "./shell";

const CHECK_AFTER_MS = 300;
const SEED = 1; // a plan's trials and minutes depend on it little

const connection = new Connection();
const { main, say } = buildShell(connection, "/protocols");
const editor = new ProtocolEditor(() => changed());
const check = new LatestCheck();
let protocols = new Map<string, string>();
let keys: Record<string, ProtocolKey[]> = {};
let timer = 0;
let accepted: ProtocolCheck | undefined;
let shownKind = "";

const list = el("select", { id: "protocol" });
const file = el("input", { id: "protocol-file", type: "file", accept: ".toml" });
const download = el("button", { type: "button", id: "download-protocol" }, "Download TOML");
const use = el("button", { type: "button", id: "use-protocol" }, "Use for a session");
const verdict = el("p", { id: "preview", class: "line", role: "status" });
const extremes = el("ul", { id: "extremes", class: "plain" });
const text = el("pre", { id: "protocol-text", tabindex: 0, role: "region", "aria-label": "The protocol's text" });
const source = panel("Protocol", "protocol-source", el("div", { class: "row" }, el("label", {}, "From the list", list), el("label", {}, "Or a file", file), download, use), verdict, extremes);
const form = panel("Form", "protocol-panel", el("p", { class: "caption" }, "Keys, ranges and messages are the checker's. * needed. Comments of the text are not kept once a field is changed."), editor.root);
const textPanel = panel("Text", "protocol-text-panel", text);
main.append(source.root, el("div", { class: "columns wide" }, form.root, textPanel.root));

list.addEventListener("change", () => {
  file.value = "";
  void open(protocols.get(list.value) ?? "");
});
file.addEventListener("change", () => void file.files?.[0]?.text().then(open));
download.addEventListener("click", () => {
  const url = URL.createObjectURL(new Blob([text.textContent ?? ""], { type: "application/toml" }));
  el("a", { href: url, download: `${editor.name || "protocol"}.toml` }).click();
  setTimeout(() => URL.revokeObjectURL(url), 1000);
});
use.addEventListener("click", () => {
  if (!accepted) return say("This protocol is not accepted yet: see the message at its field.", true);
  if (accepted.kind === "study") return say("A study is many sessions: start them from the studies' page.", true);
  keepEditedProtocol({ name: accepted.name, text: text.textContent ?? "" });
  location.assign("/");
});

async function load(): Promise<void> {
  try {
    [protocols, keys] = [new Map((await getJson<{ name: string; text: string }[]>("/api/protocols")).map(({ name, text: one }) => [name, one])), await getJson<Record<string, ProtocolKey[]>>("/api/protocols/keys")];
    const chosen = list.value;
    list.replaceChildren(...[...protocols.keys()].map((name) => el("option", { value: name }, name)));
    if (protocols.has(chosen)) list.value = chosen;
    if (text.textContent === "") await open(protocols.get(list.value) ?? "");
  } catch (error) {
    say(`The protocols cannot be read: ${(error as Error).message}`, true);
  }
}

/// Shows a protocol as it stands; the form is of what the checker could read of it.
async function open(written: string): Promise<void> {
  setText(text, written);
  try {
    const found = await check.of(written, SEED);
    if (!found) return;
    showForm((found.document ?? {}) as Table);
    show(found);
  } catch (error) {
    say(`Not checked: ${(error as Error).message}`, true);
  }
}

function showForm(document: Table): void {
  const kind = textIn(document, "kind");
  shownKind = kind;
  editor.show(document, keys[kind] ?? keys["unloaded"] ?? []);
}

function changed(): void {
  if (editor.kind !== shownKind && keys[editor.kind]) {
    shownKind = editor.kind;
    editor.rekey(keys[editor.kind]!);
  }
  setText(text, editor.text);
  check.forget();
  clearTimeout(timer);
  timer = window.setTimeout(() => void checkNow(), CHECK_AFTER_MS);
}

async function checkNow(): Promise<void> {
  try {
    const found = await check.of(text.textContent ?? "", SEED);
    if (found) show(found);
  } catch (error) {
    say(`Not checked: ${(error as Error).message}`, true);
  }
}

function show(found: ProtocolCheck): void {
  accepted = found.is_accepted ? found : undefined;
  editor.showProblem(found.problem);
  setText(verdict, found.is_accepted ? `Accepted: ${checkLine(found)}` : `Not accepted: ${checkLine(found)}`);
  verdict.className = found.is_accepted ? "line good" : "line bad";
  extremes.replaceChildren(...(found.preview?.extremes ?? []).map((extreme) => el("li", {}, extremeLine(extreme))));
}

connection.onState((state) => {
  if (state === "connected") void load();
});
document.addEventListener("tonus-token", () => void load());
