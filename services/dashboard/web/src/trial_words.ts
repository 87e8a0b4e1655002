// What is said of a trial: its verdict, and an operator's word on it; and the limits that the verdict names. Pure.

import type { TrialReview, TrialVerdict } from "./contract";

/// The reason of a trial that is rejected only to be run again.
export const REPEAT = "repeat";

type Verdict = Pick<TrialVerdict, "is_valid" | "detail">;
type Review = Pick<TrialReview, "is_rejected" | "reason" | "reviewed_by">;

/// Whether the trial is left out of every estimate, by its verdict or by hand.
export const isRejected = (verdict: Verdict, review?: Review): boolean => !verdict.is_valid || (review?.is_rejected ?? false);

/// "valid", "rejected" or "rejected by hand".
export function verdictWord(verdict: Verdict, review?: Review): string {
  if (review?.is_rejected) return "rejected by hand";
  return verdict.is_valid ? "valid" : "rejected";
}

/// Why: of a rejection by hand the operator's reason and who gave it, else the verdict's own line.
export function verdictWhy(verdict: Verdict, review?: Review): string {
  if (review?.is_rejected) return `${review.reason} (${review.reviewed_by})`;
  return verdict.detail.replace(/^valid: /, "");
}

/// The newest review of each trial.
export function keepNewest<T extends { reviewed_ns: bigint }>(reviews: Map<string, T>, id: string, review: T): void {
  const known = reviews.get(id);
  if (!known || review.reviewed_ns >= known.reviewed_ns) reviews.set(id, review);
}

/// From the mean of the rest; undefined where the verdict does not name it.
export interface VerdictLimits {
  excursion_m?: number; // after the onset
  rest_force_N?: number; // before the onset, of an unloaded trial
}

/// The first group that matched, as a number.
function limitOf(pattern: RegExp, detail: string): number | undefined {
  const found = pattern.exec(detail)?.slice(1).find((group) => group !== undefined);
  return found === undefined ? undefined : Number(found);
}

/// As the judge's line has them: "and 0.10 N (1.00), moved 6.1 mm (15.0)" of a valid trial, "1.20 N before the onset, allowed
/// 1.00 N" and "hand moved 17.0 mm, allowed 15.0 mm" of another.
export function limitsIn(detail: string): VerdictLimits {
  const millimetres = limitOf(/moved [\d.]+ mm(?: \(([\d.]+)\)|, allowed ([\d.]+) mm)/, detail);
  const newtons = limitOf(/and [\d.]+ N \(([\d.]+)\)|[\d.]+ N before the onset, allowed ([\d.]+) N/, detail);
  return {
    ...(millimetres === undefined ? {} : { excursion_m: millimetres / 1000 }),
    ...(newtons === undefined ? {} : { rest_force_N: newtons }),
  };
}
