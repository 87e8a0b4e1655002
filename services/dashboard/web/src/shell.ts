// What the pages have in common: head line, links, state of the connection, emergency stop, token.

import "./style.css";
import { keepToken } from "./access";
import type { Connection, LinkState } from "./connection";
import { el, setText } from "./dom";

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

export interface Shell {
  main: HTMLElement;
  say: (text: string, isBad?: boolean) => void;
}

export function buildShell(connection: Connection, current: string): Shell {
  const say = (text: string, isBad = false): void => {
    notice.className = isBad ? "notice bad" : "notice";
    setText(notice, text);
  };
  const notice = el("p", { class: "notice", role: "status", "aria-live": "polite", id: "notice" });
  const link = el("span", { class: "link", id: "link", role: "status" });
  const stop = emergencyStop(connection, say);
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
  connection.onState((state, reason) => {
    document.body.dataset["link"] = state;
    const role = state === "connected" && connection.role ? ` (${connection.role})` : "";
    setText(link, stateTexts[state] + role);
    banner.hidden = state === "connected" || state === "connecting";
    const trouble = state === "refused" ? "This gateway wants a token" : "Disconnected";
    setText(
      banner,
      banner.hidden ? "" : `${trouble}: ${reason}. What is shown below is old. Trying again by itself.`,
    );
  });
  listenForKeys(stop);
  return { main, say };
}

function emergencyStop(connection: Connection, say: Shell["say"]): HTMLButtonElement {
  const stop = el(
    "button",
    { class: "stop", id: "emergency-stop", type: "button", title: "Takes the rig's torque away at once (Ctrl+Space)" },
    "EMERGENCY STOP",
  );
  stop.addEventListener("click", () => {
    if (connection.state !== "connected") {
      say("Emergency stop NOT sent: disconnected. Use the button at the rig.", true);
      return;
    }
    say("Emergency stop is being sent…", true);
    void connection.request("emergency_stop").then((reply) => {
      say(`Emergency stop ${reply.is_done ? "done" : "FAILED"}: ${reply.message}`, true);
    });
  });
  return stop;
}

function listenForKeys(stop: HTMLButtonElement): void {
  document.addEventListener("keydown", (event) => {
    if (event.ctrlKey && event.code === "Space") {
      event.preventDefault();
      stop.click();
    }
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
