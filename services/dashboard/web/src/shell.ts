// What the pages share: header, links, state of the connection, emergency stop, token.

import "./style.css";
import { keepToken } from "./access";
import type { Connection, LinkState } from "./connection";
import { el, setText } from "./dom";
import { emergencyStop } from "./emergency_stop";

const pages = [
  ["/", "Operator", "1"],
  ["/results", "Results", "2"],
  ["/subject", "Subject", "3"],
  ["/archive", "Archive", "4"],
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
}

export function buildShell(connection: Connection, current: string): Shell {
  let silence = 0;
  const say = (text: string, isBad = false): void => {
    notice.className = isBad ? "notice bad" : "notice";
    setText(notice, text);
    clearTimeout(silence);
    silence = window.setTimeout(() => setText(notice, ""), isBad ? SAID_BAD_MS : SAID_MS);
  };
  const notice = el("p", { class: "notice", role: "status", "aria-live": "polite", id: "notice" });
  const link = el("span", { class: "link", id: "link", role: "status" });
  const stop = emergencyStop(connection, "EMERGENCY STOP", say);
  const nav = el("nav", { "aria-label": "Pages" });
  for (const [path, name, key] of pages) {
    nav.append(
      el("a", { href: path, "aria-current": path === current ? "page" : undefined, title: `${name} (Alt+${key})` }, name),
    );
  }
  const banner = el("p", { class: "banner", id: "banner", role: "alert", hidden: true });
  const main = el("main", { id: "main" });
  document.body.append(
    el("header", { class: "top" }, el("strong", { class: "brand" }, "tonus"), nav, link, stop),
    banner,
    tokenForm(connection),
    main,
    notice,
  );
  const showLink = (): void => {
    const isConnected = connection.state === "connected";
    const role = isConnected && connection.role ? ` (${connection.role})` : "";
    const unread = connection.undecoded > 0 ? `, ${connection.undecoded} messages NOT understood` : "";
    setText(link, stateTexts[connection.state] + role + unread);
  };
  setInterval(showLink, 1000);
  connection.onState((state, reason) => {
    document.body.dataset["link"] = state;
    showLink();
    banner.hidden = state === "connected" || state === "connecting";
    const trouble =
      state === "refused" ? reason : `Disconnected: ${reason}. The values below are old. Reconnecting…`;
    setText(banner, banner.hidden ? "" : trouble);
  });
  listenForPageKeys();
  return { main, say };
}

function listenForPageKeys(): void {
  document.addEventListener("keydown", (event) => {
    const page = pages.find(([, , key]) => key === event.key);
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
    { class: "token", hidden: true },
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
