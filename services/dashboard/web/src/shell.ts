// What the pages share: header, links, emergency stop, state strip, token, messages.

import "./stop.css";
import "./style.css";
import "./unseen.css";
import { keepToken } from "./access";
import type { Connection, LinkState } from "./connection";
import { Desk } from "./desk";
import { el, setText } from "./dom";
import { emergencyStop } from "./emergency_stop";
import { stateStrip } from "./strip";

const pages = [
  ["/", "Operator", "1"],
  ["/results", "Results", "2"],
  ["/subject", "Subject", "3"],
  ["/archive", "Archive", "4"],
  ["/studies", "Studies", "5"],
  ["/protocols", "Protocols", "6"],
] as const;

const stateTexts: Record<LinkState, string> = {
  connecting: "Connecting…",
  connected: "Connected",
  disconnected: "DISCONNECTED",
  refused: "TOKEN NEEDED",
};

// How long a message stays; a bad one stays longer.
const SAID_MS = 20_000;
const SAID_BAD_MS = 60_000;

export interface Shell {
  main: HTMLElement;
  say: (text: string, isBad?: boolean) => void;
  desk: Desk;
}

export function buildShell(connection: Connection, current: string): Shell {
  const desk = new Desk(connection);
  let silence = 0;
  const say = (text: string, isBad = false): void => {
    notice.className = isBad ? "notice bad" : "notice";
    setText(notice, text);
    clearTimeout(silence);
    silence = window.setTimeout(() => setText(notice, ""), isBad ? SAID_BAD_MS : SAID_MS);
  };
  const notice = el("p", { class: "notice", role: "status", "aria-live": "polite", id: "notice" });
  const link = el("span", { class: "link", id: "link" });
  const nav = el("nav", { "aria-label": "Pages" });
  for (const [path, name, key] of pages) {
    nav.append(
      el("a", { href: path, "aria-current": path === current ? "page" : undefined, title: `${name} (Alt+${key})` }, name),
    );
  }
  const title = pages.find(([path]) => path === current)?.[1] ?? "";
  const main = el("main", { id: "main" }, el("h1", { class: "unseen" }, title));
  const bar = el("div", { class: "bar" }, el("strong", { class: "brand" }, "tonus"), nav, link, emergencyStop(connection, "EMERGENCY STOP", say));
  document.body.append(el("header", { class: "top" }, bar, stateStrip(desk)), tokenForm(connection), main, notice);
  const showLink = (): void => {
    const isConnected = connection.state === "connected";
    const role = isConnected && connection.role ? ` (${connection.role})` : "";
    const unread = connection.undecoded > 0 ? `, ${connection.undecoded} messages NOT understood` : "";
    setText(link, stateTexts[connection.state] + role + unread);
  };
  setInterval(showLink, 1000);
  connection.onState((state) => {
    document.body.dataset["link"] = state;
    showLink();
  });
  listenForPageKeys();
  return { main, say, desk };
}

function listenForPageKeys(): void {
  document.addEventListener("keydown", (event) => {
    const page = pages.find(([, , key]) => event.code === `Digit${key}`);
    if (event.altKey && page) {
      event.preventDefault();
      location.assign(page[0]);
    }
  });
}

function tokenForm(connection: Connection): HTMLElement {
  const input = el("input", { type: "password", id: "token", autocomplete: "off", required: true });
  const form = el(
    "form",
    { class: "token", hidden: true, "aria-label": "Token" },
    el("label", { for: "token" }, "Token"),
    input,
    el("button", { type: "submit" }, "Connect"),
  );
  form.addEventListener("submit", (event) => {
    event.preventDefault();
    keepToken(input.value);
    input.value = "";
    connection.retry();
    document.dispatchEvent(new Event("tonus-token"));
  });
  connection.onState((state) => {
    form.hidden = state !== "refused";
    if (state === "refused") input.focus();
  });
  return form;
}
