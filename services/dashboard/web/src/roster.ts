// Which services are present, and their state.

import type { Connection } from "./connection";
import { ServiceRole, type ServiceHealth } from "./contract";
import { el, panel } from "./dom";
import { Fresh, ageText } from "./freshness";
import { hex, nameOf, roleNames } from "./names";

const SILENCE_S = 2; // as the services themselves count: four missed reports
const NEEDED: readonly ServiceRole[] = [
  ServiceRole.ROLE_RIG,
  ServiceRole.ROLE_SCHEDULER,
  ServiceRole.ROLE_IDENTIFICATION,
  ServiceRole.ROLE_ARCHIVE,
];

export class Roster {
  readonly root: HTMLElement;
  #age: HTMLElement;
  #body = el("tbody");
  #connection: Connection;
  #entries = new Map<string, Fresh<ServiceHealth>>();

  constructor(connection: Connection) {
    this.#connection = connection;
    const head = el(
      "tr",
      {},
      ...["Service", "State", "Lag", "Drops", "Heard"].map((name) => el("th", { scope: "col" }, name)),
    );
    const made = panel("Services", "roster", el("div", { class: "scroll" }, el("table", {}, el("thead", {}, head), this.#body)));
    this.root = made.root;
    this.#age = made.age;
    connection.subscribe<ServiceHealth>("service/health", (arrival) => {
      const id = hex(arrival.value.instance_id);
      const entry = this.#entries.get(id) ?? new Fresh<ServiceHealth>();
      if (arrival.value.is_leaving && entry.value?.process_id !== arrival.value.process_id) return;
      entry.set(arrival);
      this.#entries.set(id, entry);
    });
  }

  #find(role: ServiceRole): ServiceHealth | undefined {
    for (const { value, age } of this.#entries.values()) {
      if (value?.role === role && !value.is_leaving && age! < SILENCE_S) return value;
    }
    return undefined;
  }

  /// Why a session cannot start; empty where it can.
  missing(): string {
    if (this.#connection.state !== "connected") return "not connected";
    return NEEDED.flatMap((role) => {
      const health = this.#find(role);
      if (!health) return [`${roleNames[role]} is missing`];
      return health.is_ready ? [] : [`${roleNames[role]} is not ready: ${health.state}`];
    }).join("; ");
  }

  render(): void {
    const rows = [...this.#entries.values()]
      .filter(({ value }) => !value!.is_leaving)
      .sort((a, b) => a.value!.role - b.value!.role);
    const word = this.#connection.state === "connected" ? "missing" : "unknown";
    const absent = NEEDED.filter((role) => !rows.some(({ value }) => value!.role === role));
    this.#body.replaceChildren(
      ...rows.map(({ value, age }) => this.#row(value!, age!)),
      ...absent.map((role) =>
        el("tr", {}, el("td", {}, roleNames[role]), el("td", { class: "bad", colspan: 4 }, word)),
      ),
    );
    const missing = this.missing();
    this.#age.className = missing ? "age old" : "age";
    this.#age.textContent = missing === "not connected" ? missing : missing ? "incomplete" : "complete";
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
