// A value and how old it is. The age counts from its writing as far as this machine's clock can tell, and at
// least from its arrival; while this machine sleeps, its clock on the wall counts.

import type { Arrival } from "./connection";

export class Fresh<T> {
  value?: T;
  #arrived = { steady: 0, utc: 0 };
  #ageAtArrival = 0;

  set({ value, writtenNs }: Arrival<T>): void {
    this.value = value;
    this.#arrived = { steady: performance.now(), utc: Date.now() };
    const age = (Date.now() - Number(writtenNs / 1_000_000n)) / 1000;
    this.#ageAtArrival = age > 1 ? age : 0; // below that it may be the clocks' difference
  }

  /// s; undefined where there is no value.
  get age(): number | undefined {
    if (this.value === undefined) return undefined;
    const sinceArrival = Math.max(performance.now() - this.#arrived.steady, Date.now() - this.#arrived.utc);
    return this.#ageAtArrival + sinceArrival / 1000;
  }
}

export function ageText(age: number | undefined): string {
  if (age === undefined) return "no value yet";
  if (age < 1) return "now";
  if (age < 120) return `${age.toFixed(0)} s old`;
  if (age < 7200) return `${(age / 60).toFixed(0)} min old`;
  return `${(age / 3600).toFixed(0)} h old`;
}

export function duration(seconds: number): string {
  if (!Number.isFinite(seconds)) return "–";
  const whole = Math.max(0, Math.round(seconds));
  const minutes = Math.floor(whole / 60);
  return minutes > 0 ? `${minutes} min ${String(whole % 60).padStart(2, "0")} s` : `${whole} s`;
}
