// What every page knows of the experiment: the newest session, the rig, the services; as a view for desk_state.ts.

import type { Connection } from "./connection";
import { RigKind, ServiceRole, type RigDescription, type RigState, type SampleBlock, type SessionCue, type SessionPlan, type SessionState, type TrialProgram } from "./contract";
import type { DeskView } from "./desk_state";
import { Fresh } from "./freshness";
import { handOf, poseOf, type ShoulderPose } from "./geometry";
import { hex } from "./names";
import { Presence } from "./presence";

const OLD_HAND_S = 1;

export class Desk {
  readonly session = new Fresh<SessionState>();
  readonly rig = new Fresh<RigState>();
  readonly plans = new Map<string, SessionPlan>();
  readonly presence: Presence;
  description?: RigDescription;
  /// Set where a page receives samples: then the strip tells how far the hand is from its target.
  samples?: Fresh<SampleBlock>;
  #connection: Connection;
  #cue?: SessionCue;
  #pose?: ShoulderPose;
  #sessionWritten = 0n;
  #link = { reason: "", since: performance.now() };

  constructor(connection: Connection) {
    this.#connection = connection;
    this.presence = new Presence(connection);
    connection.onState((state, reason) => {
      if (state === "connected" || reason !== this.#link.reason) this.#link = { reason, since: performance.now() };
    });
    // A late joiner also receives the last states of older sessions: the newest stays.
    connection.subscribe<SessionState>("session/state", (arrival) => {
      if (arrival.writtenNs < this.#sessionWritten) return;
      this.#sessionWritten = arrival.writtenNs;
      this.session.set(arrival);
    });
    connection.subscribe<SessionPlan>("session/plan", ({ value }) => this.plans.set(hex(value.session_id), value));
    connection.subscribe<SessionCue>("session/cue", ({ value }) => (this.#cue = value));
    connection.subscribe<RigState>("rig/state", (arrival) => this.rig.set(arrival));
    connection.subscribe<RigDescription>("rig/description", ({ value }) => (this.description = value));
    connection.subscribe<{ program: TrialProgram }>("trial/command", ({ value }) => (this.#pose = poseOf(value.program)));
  }

  /// Where the subject sits, once a trial has told it.
  get pose(): ShoulderPose | undefined {
    return this.#pose;
  }

  get plan(): SessionPlan | undefined {
    return this.session.value && this.plans.get(hex(this.session.value.session_id));
  }

  view(): DeskView {
    const plan = this.plan;
    return {
      link: this.#connection.state,
      linkReason: this.#link.reason,
      linkLostFor: (performance.now() - this.#link.since) / 1000,
      role: this.#connection.role,
      session: this.session.value,
      subject: plan?.subject ?? "",
      rig: this.rig.value,
      rigSilence: this.#rigSilence(),
      schedulerSilence: this.presence.silence(ServiceRole.ROLE_SCHEDULER),
      missing: this.#connection.state === "connected" ? this.presence.missing() : ["not connected"],
      handOffset: this.#handOffset(),
    };
  }

  /// The rig's state and its health come from one process: the newer one counts.
  #rigSilence(): number | undefined {
    const health = this.presence.silence(ServiceRole.ROLE_RIG);
    return health === undefined ? undefined : Math.min(health, this.rig.age ?? Infinity);
  }

  #handOffset(): DeskView["handOffset"] {
    const sample = this.samples?.value?.samples.at(-1);
    const isKnown = sample && this.description?.kind === RigKind.RIG_TWO_LINK && this.#pose && this.#cue;
    if (!isKnown || (this.samples?.age ?? Infinity) > OLD_HAND_S) return undefined;
    const { position } = handOf(this.description!, this.#pose!, sample);
    const x = this.#cue!.target_m[0]! - position[0];
    const y = this.#cue!.target_m[1]! - position[1];
    return { distance_m: Math.hypot(x, y), direction_deg: (Math.atan2(y, x) * 180) / Math.PI };
  }
}
