// The connection to the gateway: the Foxglove WebSocket protocol, which reconnects by itself. Subscriptions are by
// topic and survive a lost connection; handlers are told of every change of state.

import { parse as parseSchema } from "./schemas";
import { FoxgloveClient, type Channel } from "@foxglove/ws-protocol";
import { forgetToken, token } from "./access";
import type { OperatorReply } from "./gateway_messages";
import { hex } from "./names";
import { operatorName } from "./operator_name";

const FIRST_PAUSE_MS = 250;
const LONGEST_PAUSE_MS = 3000;
const SILENCE_MS = 5000; // the gateway's status comes every second
const REQUEST_TOPIC = "operator/request";
const STATUS_TOPIC = "gateway/status";
const REPLY_TOPIC = "operator/reply";

export type LinkState = "connecting" | "connected" | "disconnected" | "refused";

export interface Arrival<T> {
  value: T;
  writtenNs: bigint; // UTC, by the writer
}

type Handler = (arrival: Arrival<never>) => void;

interface Wanted {
  handlers: Set<Handler>;
  subscription?: number;
  channel?: Channel;
  decode?: (data: DataView) => unknown;
}

export class Connection {
  #client?: FoxgloveClient;
  #socket?: WebSocket;
  #channels = new Map<string, Channel>();
  #wanted = new Map<string, Wanted>();
  #bySubscription = new Map<number, Wanted>();
  #stateHandlers = new Set<(state: LinkState, reason: string) => void>();
  #replies = new Map<string, (reply: OperatorReply) => void>();
  #requestChannel?: number;
  #pause = FIRST_PAUSE_MS;
  #state: LinkState = "connecting";
  #reason = "";
  #heardAt = { steady: 0, utc: 0 };
  #undecoded = 0;

  role = "";

  constructor() {
    this.subscribe<unknown>(STATUS_TOPIC, () => undefined);
    this.subscribe<OperatorReply>(REPLY_TOPIC, ({ value }) => {
      this.#replies.get(value.request_id)?.(value);
    });
    setInterval(() => this.#checkSilence(), 1000);
    this.#connect();
  }

  get state(): LinkState {
    return this.#state;
  }

  /// Messages that could not be decoded; the page shows any number but 0.
  get undecoded(): number {
    return this.#undecoded;
  }

  onState(handler: (state: LinkState, reason: string) => void): void {
    this.#stateHandlers.add(handler);
    handler(this.#state, this.#reason);
  }

  subscribe<T>(topic: string, handler: (arrival: Arrival<T>) => void): void {
    const wanted = this.#wanted.get(topic) ?? { handlers: new Set<Handler>() };
    wanted.handlers.add(handler);
    this.#wanted.set(topic, wanted);
    this.#subscribeIfPossible(topic, wanted);
  }

  /// The IDL text of a topic's type, once the gateway has advertised it.
  schemaOf(topic: string): string | undefined {
    return this.#channels.get(topic)?.schema;
  }

  /// As schemaOf, but waits for the connection.
  async schema(topic: string): Promise<string> {
    for (;;) {
      const text = this.schemaOf(topic);
      if (text !== undefined) return text;
      await new Promise((resolve) => setTimeout(resolve, 100));
    }
  }

  /// Sends a request to the scheduler or the rig and resolves with their reply. It is repeated with the same id until
  /// then, so that it is done once.
  request(name: string, fields: Record<string, unknown> = {}): Promise<OperatorReply> {
    const id = randomId();
    const body = { request_id: id, request: name, page: pageName(), by: operatorName(), ...fields };
    return new Promise((resolve) => {
      const send = (): void => this.#publish(body);
      const again = setInterval(send, 1000);
      this.#replies.set(id, (reply) => {
        clearInterval(again);
        this.#replies.delete(id);
        resolve(reply);
      });
      send();
    });
  }

  #publish(body: object): void {
    if (this.#state !== "connected" || !this.#client) return;
    this.#requestChannel ??= this.#client.advertise({
      topic: REQUEST_TOPIC,
      encoding: "json",
      schemaName: "tonus.OperatorRequest",
    });
    this.#client.sendMessage(this.#requestChannel, new TextEncoder().encode(JSON.stringify(body)));
  }

  #connect(): void {
    const scheme = location.protocol === "https:" ? "wss" : "ws";
    const secret = token();
    const query = secret ? `?token=${encodeURIComponent(secret)}` : "";
    const socket = new WebSocket(`${scheme}://${location.host}/${query}`, [
      FoxgloveClient.SUPPORTED_SUBPROTOCOL,
    ]);
    const client = new FoxgloveClient({ ws: socket });
    this.#socket = socket;
    this.#client = client;
    this.#heard();
    client.on("serverInfo", (info) => {
      this.role = info.metadata?.["role"] ?? "";
    });
    client.on("advertise", (channels) => {
      for (const channel of channels) this.#channels.set(channel.topic, channel);
      this.#pause = FIRST_PAUSE_MS;
      this.#setState("connected", "");
      for (const [topic, wanted] of this.#wanted) this.#subscribeIfPossible(topic, wanted);
    });
    client.on("message", ({ subscriptionId, timestamp, data }) => {
      this.#heard();
      const wanted = this.#bySubscription.get(subscriptionId);
      if (!wanted?.decode) return;
      let value: unknown;
      try {
        value = wanted.decode(data as DataView);
      } catch (error) {
        this.#undecoded += 1;
        console.error(`decoding a message of ${wanted.channel?.topic ?? "?"} failed`, error);
        return;
      }
      for (const handler of wanted.handlers) handler({ value: value as never, writtenNs: timestamp });
    });
    client.on("status", (status) => console.warn("gateway:", status.message));
    client.on("error", () => undefined); // the close follows
    client.on("close", (event) => this.#onClose(client, event));
  }

  #onClose(client: FoxgloveClient, event: CloseEvent): void {
    if (client !== this.#client) return;
    this.#client = undefined;
    this.#channels.clear();
    this.#bySubscription.clear();
    this.#requestChannel = undefined;
    for (const wanted of this.#wanted.values()) wanted.subscription = undefined;
    this.#setState("disconnected", event.reason || "the gateway does not answer");
    void this.#reconnectLater();
  }

  async #reconnectLater(): Promise<void> {
    await new Promise((resolve) => setTimeout(resolve, this.#pause));
    this.#pause = Math.min(2 * this.#pause, LONGEST_PAUSE_MS);
    if (await isTokenRefused()) {
      const why = token() ? "The gateway does not know this token." : "The gateway requires a token.";
      forgetToken();
      this.#setState("refused", why);
      return;
    }
    this.#connect();
  }

  /// After a new token has been given.
  retry(): void {
    if (this.#client) return;
    this.#pause = FIRST_PAUSE_MS;
    this.#setState("connecting", "");
    this.#connect();
  }

  #heard(): void {
    this.#heardAt = { steady: performance.now(), utc: Date.now() };
  }

  #checkSilence(): void {
    // While this machine sleeps, only the clock on the wall goes on.
    const silence = Math.max(performance.now() - this.#heardAt.steady, Date.now() - this.#heardAt.utc);
    if (!this.#client || silence < SILENCE_MS) return;
    const client = this.#client;
    this.#socket?.close();
    // The closing handshake takes long where nobody answers: treat the connection as closed now.
    this.#onClose(client, new CloseEvent("close", { reason: "the gateway has been silent" }));
  }

  #subscribeIfPossible(topic: string, wanted: Wanted): void {
    const channel = this.#channels.get(topic);
    if (!channel || !this.#client || wanted.subscription !== undefined) return;
    if (wanted.channel?.schema !== channel.schema) wanted.decode = decoderOf(channel);
    wanted.channel = channel;
    wanted.subscription = this.#client.subscribe(channel.id);
    this.#bySubscription.set(wanted.subscription, wanted);
  }

  #setState(state: LinkState, reason: string): void {
    this.#state = state;
    this.#reason = reason;
    for (const handler of this.#stateHandlers) handler(state, reason);
  }
}

function decoderOf(channel: Channel): (data: DataView) => unknown {
  if (channel.encoding === "json") {
    const text = new TextDecoder();
    return (data) => JSON.parse(text.decode(data)) as unknown;
  }
  const reader = parseSchema(channel.schemaName, channel.schema);
  return (data) => reader.readMessage(data);
}

/// For the record of who pressed what where: "results".
const pageName = (): string => location.pathname.replaceAll("/", "") || "operator";

async function isTokenRefused(): Promise<boolean> {
  try {
    const secret = token();
    const response = await fetch("/api/role", {
      headers: secret ? { Authorization: `Bearer ${secret}` } : {},
    });
    return response.status === 401;
  } catch {
    return false;
  }
}

export function randomId(): string {
  return hex(crypto.getRandomValues(new Uint8Array(16)));
}
