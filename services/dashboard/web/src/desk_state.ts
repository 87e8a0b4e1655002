// What the desk says about the experiment, from what is known: the state strip of every page, and which controls may be
// pressed. Pure, and in one place, so that no two pages can disagree.

import type { LinkState } from "./connection";
import { RigMode, SessionPhase, type RigState, type SessionState } from "./contract";
import { isActive } from "./names";

/// A rig or a scheduler that was silent for so long is gone, s.
export const GONE_S = 2;

export interface DeskView {
  link: LinkState;
  linkReason: string;
  linkLostFor: number; // s
  role: string; // of this page at the gateway
  session?: SessionState;
  subject: string;
  rig?: RigState;
  /// s since each was heard; undefined: never, or it has left.
  rigSilence?: number;
  schedulerSilence?: number;
  /// Why a session cannot start; empty where it can.
  missing: readonly string[];
  /// From the hand to the target; undefined where it is not known.
  handOffset?: { distance_m: number; direction_deg: number };
}

export type Tone = "good" | "turn" | "wait" | "bad" | "idle";
export type Icon = "run" | "hand" | "wait" | "stop" | "cross" | "tick" | "dot";
export type Action = "start" | "resume" | "clear-fault" | "";

export interface Strip {
  key: string; // names the state; changes of it are announced
  tone: Tone;
  icon: Icon;
  head: string; // in capitals: what
  text: string; // the rest of the sentence
  next: Action; // what the operator does next, if it is theirs to do
}

export const isGone = (silence: number | undefined): boolean => silence === undefined || silence > GONE_S;
const seconds = (s: number): string => `${Math.max(0, Math.floor(s))} s`;
const trials = (n: number): string => `${n} ${n === 1 ? "trial" : "trials"}`;

export function aboutMinutes(s: number): string {
  if (!Number.isFinite(s) || s < 0) return "unknown time";
  if (s < 45) return "under 1 min";
  return `about ${Math.round(s / 60)} min`;
}

export function stripOf(view: DeskView): Strip {
  return stripOfLink(view) ?? stripOfRig(view) ?? stripOfSession(view);
}

function stripOfLink({ link, linkReason, linkLostFor }: DeskView): Strip | undefined {
  switch (link) {
    case "connected":
      return undefined;
    case "refused":
      return { key: "token", tone: "bad", icon: "cross", head: "TOKEN NEEDED", text: linkReason, next: "" };
    case "connecting":
      return { key: "connecting", tone: "wait", icon: "wait", head: "CONNECTING", text: "to the gateway", next: "" };
    case "disconnected":
      return {
        key: "disconnected", tone: "bad", icon: "cross", head: `DISCONNECTED for ${seconds(linkLostFor)}`,
        text: `${linkReason}. Values below are old. To stop, use the button at the rig. Reconnecting…`, next: "",
      };
  }
}

function stripOfRig(view: DeskView): Strip | undefined {
  const { rig, rigSilence, schedulerSilence, session } = view;
  const isGoing = session !== undefined && isActive(session.phase);
  if (rig && isGone(rigSilence)) {
    const since = rigSilence === undefined ? "" : ` for ${seconds(rigSilence)}`;
    const before = rig.held_because ? ` It was held: ${rig.held_because}.` : "";
    return {
      key: "rig-gone", tone: "bad", icon: "cross", head: `RIG GONE${since}`,
      text: `The rig agent does not report. What the rig does is not known; use the button at the rig.${before}`, next: "",
    };
  }
  if (rig?.mode === RigMode.RIG_HELD) return stripOfHold(rig, isGoing);
  if (isGoing && isGone(schedulerSilence)) {
    const since = schedulerSilence === undefined ? "" : ` for ${seconds(schedulerSilence)}`;
    return {
      key: "scheduler-gone", tone: "bad", icon: "cross", head: `SCHEDULER GONE${since}`,
      text: "No new trial begins, and the rig is held soon. The session resumes when the scheduler is back.", next: "",
    };
  }
  return undefined;
}

function stripOfHold(rig: RigState, isGoing: boolean): Strip {
  const then = isGoing ? "When it is safe: Clear fault, then Resume." : "When it is safe: Clear fault.";
  const stop = stopOf(rig.held_because);
  if (stop) {
    return {
      key: "stopped", tone: "bad", icon: "stop", head: "EMERGENCY STOP",
      text: `${stop}; the rig is released. ${then}`, next: "clear-fault",
    };
  }
  const why = rig.held_because || rig.fault || "the reason is not known";
  return { key: "held", tone: "bad", icon: "stop", head: "RIG HELD", text: `${why}. ${then}`, next: "clear-fault" };
}

/// Who stopped, of the rig's line, "stop by dashboard 127.0.0.1:5000 on results at 11:19:32 UTC; fault: ...".
export function stopOf(heldBecause: string): string | undefined {
  const by = /(?:^|; )stop by ([^;]+)/.exec(heldBecause)?.[1];
  if (by === undefined) return /emergency stop/.test(heldBecause) ? "at the rig" : undefined;
  const [, who, page, time] = /^(.*?)(?: on ([a-z-]+))?(?: at (\d\d:\d\d:\d\d UTC))?$/.exec(by.trim())!;
  return `pressed${time ? ` ${time}` : ""}${page ? ` on ${page}` : ""} by ${who}`;
}

function stripOfSession(view: DeskView): Strip {
  const { session } = view;
  if (!session) return stripWithoutSession(view);
  const { counted, planned, posture, remaining_s, rejected } = session;
  switch (session.phase) {
    case SessionPhase.SESSION_PREPARING:
    case SessionPhase.SESSION_READY:
    case SessionPhase.SESSION_WAITING:
      return stripOfWait(view, session);
    case SessionPhase.SESSION_RUNNING:
      return {
        key: "running", tone: "good", icon: "run",
        head: `RUNNING trial ${Math.min(counted + 1, planned)} of ${planned}`,
        text: [posture, aboutMinutes(remaining_s)].filter((part) => part !== "").join(", "), next: "",
      };
    case SessionPhase.SESSION_PAUSING:
      return { key: "pausing", tone: "wait", icon: "wait", head: "PAUSING", text: "after this trial", next: "" };
    case SessionPhase.SESSION_PAUSED:
      return {
        key: "paused", tone: "turn", icon: "hand", head: "YOUR TURN",
        text: `the session is paused after ${counted} of ${planned} trials. Resume when the subject is ready.`, next: "resume",
      };
    case SessionPhase.SESSION_COMPLETING:
      return {
        key: "completing", tone: "wait", icon: "wait", head: "COMPLETING",
        text: `every trial is done; ${session.waiting_for || "the archive is closed"}`, next: "",
      };
    case SessionPhase.SESSION_COMPLETED:
      return {
        key: "completed", tone: "good", icon: "tick", head: "COMPLETED",
        text: `${view.subject ? `${view.subject}, ` : ""}${trials(counted)} counted, ${rejected} rejected. Results and archive have them.`,
        next: "start",
      };
    case SessionPhase.SESSION_ABORTED:
      return {
        key: "aborted", tone: "idle", icon: "stop", head: "ABORTED",
        text: `after ${counted} of ${planned} trials${session.message ? `: ${session.message}` : ""}`, next: "start",
      };
    case SessionPhase.SESSION_FAILED:
      return { key: "failed", tone: "bad", icon: "cross", head: "FAILED", text: session.message || "the reason is not known", next: "start" };
  }
}

function stripWithoutSession({ missing }: DeskView): Strip {
  if (missing.length > 0)
    return { key: "not-ready", tone: "idle", icon: "wait", head: "NOT READY", text: missing.join("; "), next: "" };
  return { key: "ready", tone: "idle", icon: "dot", head: "READY", text: "no session runs; choose a subject and a protocol, then Start", next: "start" };
}

const OPERATOR = /^operator: /;

/// A wait for a person is that person's turn; one for a service is nobody's fault.
function stripOfWait(view: DeskView, session: SessionState): Strip {
  const { waiting_for } = session;
  const isPreparing = session.phase === SessionPhase.SESSION_PREPARING;
  if (!OPERATOR.test(waiting_for)) {
    const head = isPreparing ? "PREPARING" : "WAITING";
    const text = waiting_for.startsWith("nothing: ") ? waiting_for.slice(9) : waiting_for ? `for ${waiting_for}` : "";
    return { key: isPreparing ? "preparing" : "waiting", tone: "wait", icon: "wait", head, text, next: "" };
  }
  const told = waiting_for.replace(OPERATOR, "");
  const posture = /^bring the subject's hand to posture '(.*)', \((.*)\) m/.exec(told);
  if (!posture)
    return { key: "your-turn", tone: "turn", icon: "hand", head: "YOUR TURN", text: resumeSentence(told), next: "resume" };
  return {
    key: "posture", tone: "turn", icon: "hand", head: "YOUR TURN",
    text: `bring the hand to ${posture[1]} (${offsetText(view) ?? `${posture[2]} m from the shoulder`}), then Resume`, next: "resume",
  };
}

function offsetText({ handOffset }: DeskView): string | undefined {
  if (!handOffset) return undefined;
  const direction = ((Math.round(handOffset.direction_deg) % 360) + 360) % 360;
  return `${(1000 * handOffset.distance_m).toFixed(0)} mm away, towards ${direction}°`;
}

/// The scheduler's line, ending with what to press.
const resumeSentence = (told: string): string => (/resume/i.test(told) ? told : `${told}; then Resume`);

// Controls

export type Control = "start" | "pause" | "resume" | "abort-trial" | "abort" | "clear-fault";

const pausing: readonly SessionPhase[] = [SessionPhase.SESSION_PAUSING, SessionPhase.SESSION_PAUSED];
const resumable: readonly SessionPhase[] = [...pausing, SessionPhase.SESSION_WAITING];

/// Why each control cannot be pressed now, in two or three words; empty where it can.
export function reasonsAgainst(view: DeskView): Record<Control, string> {
  const { session, rig } = view;
  const isGoing = session !== undefined && isActive(session.phase);
  const denied = view.link !== "connected" ? "not connected" : view.role !== "operate" ? "viewer only" : "";
  const idle = denied || (isGoing ? "" : "no session");
  const isHeld = rig?.mode === RigMode.RIG_HELD;
  return {
    start: denied || (isGoing ? "a session runs" : isHeld ? "rig is held" : view.missing.join("; ")),
    pause: idle || (pausing.includes(session!.phase) ? "paused" : session!.phase === SessionPhase.SESSION_COMPLETING ? "all done" : ""),
    resume: idle || (!resumable.includes(session!.phase) ? "not paused" : isHeld ? "clear first" : ""),
    "abort-trial": denied || (isGone(view.rigSilence) ? "rig is gone" : rig?.mode === RigMode.RIG_IN_TRIAL ? "" : "no trial runs"),
    abort: idle,
    "clear-fault": denied || (isHeld ? "" : "no fault"),
  };
}
