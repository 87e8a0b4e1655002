// The archive's lists: which sessions are shown in which order, which trials, and how two sessions differ. Pure.

import { EstimateStatus, type Estimate } from "./contract";
import { conditionOf, elementNames, elementsOf, inOrder, matrixNames, matrixOf, methodOf, quantileOf, unitOf, type MatrixName } from "./matrices";

export interface SessionEntry {
  session_id: string;
  subject: string;
  protocol: string;
  seed: number;
  planned_trials: number;
  started_at: string;
  software_version: string;
  study: string;
  is_pilot: boolean;
  state: string | null;
}

export type SortKey = "started_at" | "subject" | "protocol" | "planned_trials" | "state" | "session_id";

/// Sessions in which every word of the filter occurs, in any of their fields, whatever the case.
export function filtered(sessions: readonly SessionEntry[], filter: string): SessionEntry[] {
  const words = filter.toLowerCase().split(/\s+/).filter((word) => word !== "");
  return sessions.filter((session) => {
    const text = [session.session_id, session.subject, session.protocol, session.started_at, session.software_version, session.study, session.state ?? "", session.is_pilot ? "pilot" : "", `seed ${session.seed}`].join(" ").toLowerCase();
    return words.every((word) => text.includes(word));
  });
}

/// By one field, numbers by their value; equal ones by their start.
export function sorted(sessions: readonly SessionEntry[], key: SortKey, isDescending: boolean): SessionEntry[] {
  const compare = (a: SessionEntry, b: SessionEntry): number =>
    String(a[key]).localeCompare(String(b[key]), "en", { numeric: true }) || a.started_at.localeCompare(b.started_at);
  return [...sessions].sort((a, b) => (isDescending ? compare(b, a) : compare(a, b)));
}

/// One element of one matrix, as two sessions have it.
export interface Difference {
  condition: string;
  method: string;
  matrix: MatrixName;
  element: string;
  unit: string;
  here: number;
  other: number;
  difference: number; // here - other
  half95: number; // half width of its 95 % interval; the sessions are independent
}

/// Of conditions and methods that both have determined, in the units of both.
export function differences(here: readonly Estimate[], other: readonly Estimate[]): Difference[] {
  const keyOf = (estimate: Estimate): string => [conditionOf(estimate), methodOf(estimate), unitOf(estimate, "K")].join("\n");
  const isKnown = ({ status }: Estimate): boolean => status !== EstimateStatus.ESTIMATE_UNDETERMINED;
  const others = new Map(other.filter(isKnown).map((estimate) => [keyOf(estimate), estimate]));
  return [...here].filter(isKnown).sort(inOrder).flatMap((estimate) => {
    const match = others.get(keyOf(estimate));
    return match ? matrixNames.flatMap((name) => differencesOf(estimate, match, name)) : [];
  });
}

function differencesOf(here: Estimate, other: Estimate, name: MatrixName): Difference[] {
  const [a, b] = [matrixOf(here, name), matrixOf(other, name)];
  return elementsOf(here).map((i) => ({
    condition: conditionOf(here),
    method: methodOf(here),
    matrix: name,
    element: elementNames[i]!,
    unit: unitOf(here, name),
    here: a.value[i]!,
    other: b.value[i]!,
    difference: a.value[i]! - b.value[i]!,
    half95: Math.hypot(quantileOf(a) * a.standard_error[i]!, quantileOf(b) * b.standard_error[i]!),
  }));
}

/// Of each estimate the newest: the one of most trials.
export function newestOf(history: readonly Estimate[], idOf: (estimate: Estimate) => string): Estimate[] {
  const newest = new Map<string, Estimate>();
  for (const estimate of history) {
    const known = newest.get(idOf(estimate));
    if (!known || estimate.trials_used + estimate.trials_rejected >= known.trials_used + known.trials_rejected) newest.set(idOf(estimate), estimate);
  }
  return [...newest.values()];
}
