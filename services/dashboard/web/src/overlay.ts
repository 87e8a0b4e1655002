// Several sessions drawn over each other: which estimates, where, and how sessions are told apart. Pure.

import { EstimateStatus, type Estimate } from "./contract";
import { conditionOf, inOrder, isWhole, methodOf, postureOf, unitOf } from "./matrices";

/// Colours, markers and dashes that differ in every pair, in grey too.
export const MOST_COMPARED = 6;

export interface ComparedSession {
  id: string;
  name: string;
  started_at: string; // ISO 8601
  estimates: readonly Estimate[]; // of each the newest
}

/// How one estimate is drawn: as those of its session.
export interface Look {
  letter: string;
  place: number; // of posture_style.ts
}

export interface Overlay {
  estimates: Estimate[];
  looks: ReadonlyMap<Estimate, Look>;
  otherUnits: number; // estimates that are left out, because their unit is not that of the first one
}

export const letterOf = (index: number): string => String.fromCharCode("A".charCodeAt(0) + index);

/// Determined estimates by this method, of all sets of a condition together. A posture is drawn where the first session that
/// has it measured it: subjects of different size are compared by the posture's name.
export function overlaid(sessions: readonly ComparedSession[], method: string): Overlay {
  const places = new Map<string, Float64Array>();
  const looks = new Map<Estimate, Look>();
  let unit: string | undefined;
  let otherUnits = 0;
  sessions.forEach(({ estimates }, index) => {
    for (const estimate of determined(estimates, method)) {
      unit ??= unitOf(estimate, "K");
      if (unitOf(estimate, "K") !== unit) {
        ++otherUnits;
        continue;
      }
      const posture = postureOf(estimate);
      const posture_m = places.get(posture) ?? estimate.posture_m;
      places.set(posture, posture_m);
      looks.set({ ...estimate, posture_m }, { letter: letterOf(index), place: index });
    }
  });
  return { estimates: [...looks.keys()], looks, otherUnits };
}

/// One condition by one method in each session that has determined it, in the order in which the sessions were started.
export function overTime(sessions: readonly ComparedSession[], method: string, condition: string): { letter: string; name: string; estimate: Estimate }[] {
  return sessions
    .flatMap((session, index) => {
      const estimate = determined(session.estimates, method).find((one) => conditionOf(one) === condition);
      return estimate ? [{ letter: letterOf(index), name: session.name, started_at: session.started_at, estimate }] : [];
    })
    .sort((a, b) => a.started_at.localeCompare(b.started_at))
    .filter(({ estimate }, _, all) => unitOf(estimate, "K") === unitOf(all[0]!.estimate, "K"));
}

const determined = (estimates: readonly Estimate[], method: string): Estimate[] =>
  estimates.filter((one) => isWhole(one) && methodOf(one) === method && one.status !== EstimateStatus.ESTIMATE_UNDETERMINED).sort(inOrder);
