// Which services are present: the newest health report of each, and for how long a needed one has been silent.

import type { Connection } from "./connection";
import { ServiceRole, type ServiceHealth } from "./contract";
import { Fresh } from "./freshness";
import { hex, roleNames } from "./names";

export const SILENCE_S = 2; // as the services themselves count: four missed reports
export const neededRoles: readonly ServiceRole[] = [
  ServiceRole.ROLE_RIG,
  ServiceRole.ROLE_SCHEDULER,
  ServiceRole.ROLE_IDENTIFICATION,
  ServiceRole.ROLE_ARCHIVE,
];

export class Presence {
  #entries = new Map<string, Fresh<ServiceHealth>>();

  constructor(connection: Connection) {
    connection.subscribe<ServiceHealth>("service/health", (arrival) => {
      const id = hex(arrival.value.instance_id);
      const entry = this.#entries.get(id) ?? new Fresh<ServiceHealth>();
      if (arrival.value.is_leaving && entry.value?.process_id !== arrival.value.process_id) return;
      entry.set(arrival);
      this.#entries.set(id, entry);
    });
  }

  /// Services that have not left, in the order of their roles.
  entries(): { health: ServiceHealth; age: number }[] {
    return [...this.#entries.values()]
      .filter(({ value }) => !value!.is_leaving)
      .map((entry) => ({ health: entry.value!, age: entry.age! }))
      .sort((a, b) => a.health.role - b.health.role);
  }

  /// s since a service of this role was heard; undefined where none ever was, or the last one left.
  silence(role: ServiceRole): number | undefined {
    const ages = this.entries().filter(({ health }) => health.role === role).map(({ age }) => age);
    return ages.length > 0 ? Math.min(...ages) : undefined;
  }

  /// Why a session cannot start, a line for each service; none where it can.
  missing(): string[] {
    return neededRoles.flatMap((role) => {
      const found = this.entries().find(({ health, age }) => health.role === role && age < SILENCE_S);
      if (!found) return [`${roleNames[role]} is missing`];
      return found.health.is_ready ? [] : [`${roleNames[role]} is not ready: ${found.health.state}`];
    });
  }
}
