// What the gateway's checker says of a protocol, and what a session of it would do, in words. Pure.

import { duration } from "./freshness";

export interface Extreme {
  what: string;
  value: number | null;
  low: number | null;
  high: number | null;
  unit: string;
}

export interface ProtocolCheck {
  is_accepted: boolean;
  kind: string;
  name: string;
  problem: { key: string; line: number; message: string } | null;
  document: Record<string, unknown> | null;
  preview: { trials: number; duration_s: number; postures: { name: string; trials: number }[]; extremes: Extreme[] } | null;
}

/// One line: what it would do, or what is wrong with it.
export function checkLine({ is_accepted, kind, problem, preview }: ProtocolCheck): string {
  if (!is_accepted && problem) return `${problem.line > 0 ? `line ${problem.line}: ` : ""}${problem.message}`;
  if (!preview) return kind === "study" ? "a study: its sessions are started one by one" : "accepted; no rig to preview it on";
  return `${preview.trials} trials, about ${duration(preview.duration_s)} if none is repeated`;
}

const shown = (value: number): string => (Math.abs(value) >= 100 ? value.toFixed(0) : String(Number(value.toPrecision(3))));

/// "force to expect: 12.1 N of at most 22.3 N".
export function extremeLine({ what, value, low, high, unit }: Extreme): string {
  if (value === null) return `${what}: not known`;
  const limits = [low === null ? "" : `at least ${shown(low)}`, high === null ? "" : `at most ${shown(high)}`].filter((part) => part !== "");
  return `${what}: ${shown(value)} ${unit}${limits.length > 0 ? ` (allowed: ${limits.join(", ")} ${unit})` : ""}`;
}
