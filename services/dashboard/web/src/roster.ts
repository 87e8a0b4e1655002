// The services that are present, and their state.

import type { ServiceHealth } from "./contract";
import { el, panel } from "./dom";
import { ageText } from "./freshness";
import { nameOf, roleNames } from "./names";
import { SILENCE_S, neededRoles, type Presence } from "./presence";

export class Roster {
  readonly root: HTMLElement;
  #age: HTMLElement;
  #body = el("tbody");
  #presence: Presence;

  constructor(presence: Presence) {
    this.#presence = presence;
    const head = el(
      "tr",
      {},
      ...["Service", "State", "Lag", "Drops", "Heard"].map((name) => el("th", { scope: "col" }, name)),
    );
    const table = el("table", {}, el("thead", {}, head), this.#body);
    const made = panel("Services", "roster", el("div", { class: "scroll steady", tabindex: 0, role: "group", "aria-label": "Services" }, table));
    this.root = made.root;
    this.#age = made.age;
  }

  render(isConnected: boolean): void {
    const entries = this.#presence.entries();
    const word = isConnected ? "missing" : "unknown";
    const absent = neededRoles.filter((role) => !entries.some(({ health }) => health.role === role));
    this.#body.replaceChildren(
      ...entries.map(({ health, age }) => this.#row(health, age)),
      ...absent.map((role) =>
        el("tr", {}, el("td", {}, roleNames[role]), el("td", { class: "bad", colspan: 4 }, word)),
      ),
    );
    const missing = this.#presence.missing();
    this.#age.className = !isConnected || missing.length > 0 ? "age old" : "age";
    this.#age.textContent = !isConnected ? "not connected" : missing.length > 0 ? "incomplete" : "complete";
  }

  #row(health: ServiceHealth, age: number): HTMLElement {
    const isGone = age > SILENCE_S;
    const state = isGone ? "gone" : health.is_ready ? health.state || "ready" : `not ready: ${health.state}`;
    const tone = isGone ? "bad" : health.is_ready ? "good" : "warn";
    return el(
      "tr",
      {},
      el("td", { title: `${health.name}, version ${health.software_version}, ${health.vendor}` }, nameOf(roleNames, health.role)),
      el("td", { class: `${tone} long` }, state),
      el("td", { class: "number" }, `${(1000 * health.lag_s).toFixed(0)} ms`),
      el("td", { class: health.dropped > 0n ? "number bad" : "number" }, String(health.dropped)),
      el("td", { class: isGone ? "bad" : "faint" }, ageText(age)),
    );
  }
}
