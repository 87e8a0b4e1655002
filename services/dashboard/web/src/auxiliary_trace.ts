// Auxiliary channels of the rig (EMG, grip force, triggers) against time, where the rig describes some: the newest seconds of
// each, of each bin of time the value farthest from zero.

import type { AuxiliaryBlock, AuxiliaryChannel, RigDescription } from "./contract";
import { el, panel, setText, svg } from "./dom";

const WINDOW_S = 10;
const BINS = 600;
const WIDTH = 640;
const HEIGHT = 46;

interface Channel {
  description: AuxiliaryChannel;
  bins: Map<number, number>; // by number of the bin; in the channel's unit
  line: SVGPolylineElement;
  newest: HTMLElement;
  range: number; // half height; grows only
}

export class AuxiliaryTrace {
  readonly root: HTMLElement;
  #body = el("div", { class: "auxiliary" });
  #channels: Channel[] = [];
  #key = "";
  #sampleRate = 0;
  #epoch = -1n;
  #end = 0; // s, of the newest sample

  constructor() {
    this.root = panel("Auxiliary channels", "auxiliary", this.#body).root;
    this.root.hidden = true;
  }

  setRig(rig: RigDescription): void {
    const key = rig.auxiliary_channels.map(({ name, unit, values_per_sample }) => `${name} ${unit} ${values_per_sample}`).join("\n");
    this.#sampleRate = rig.sample_rate_Hz;
    if (key === this.#key) return;
    this.#key = key;
    this.root.hidden = rig.auxiliary_channels.length === 0;
    this.#channels = rig.auxiliary_channels.map(channelOf);
    this.#body.replaceChildren(...this.#channels.map((channel) => row(channel)), el("p", { class: "caption" }, `The last ${WINDOW_S} s; of each ${((1000 * WINDOW_S) / BINS).toFixed(0)} ms the value farthest from zero.`));
  }

  add(block: AuxiliaryBlock): void {
    const perSample = this.#channels.reduce((sum, { description }) => sum + description.values_per_sample, 0);
    if (block.is_resent || perSample === 0 || !(this.#sampleRate > 0)) return;
    if (block.epoch !== this.#epoch) {
      this.#epoch = block.epoch;
      for (const { bins } of this.#channels) bins.clear();
    }
    for (let sample = 0; sample < block.sample_count; ++sample) {
      const time = (Number(block.first_sequence) + sample) / this.#sampleRate;
      this.#end = Math.max(this.#end, time);
      let at = sample * perSample;
      for (const channel of this.#channels) {
        const { values_per_sample, unit_per_value } = channel.description;
        for (let k = 0; k < values_per_sample; ++k, ++at) put(channel, time, block.values[at]! * unit_per_value);
      }
    }
  }

  render(): void {
    if (this.root.hidden) return;
    const last = binOf(this.#end);
    for (const channel of this.#channels) {
      for (const bin of channel.bins.keys()) if (bin <= last - BINS) channel.bins.delete(bin);
      const bins = [...channel.bins].sort(([a], [b]) => a - b);
      for (const [, value] of bins) channel.range = Math.max(channel.range, Math.abs(value));
      const y = (value: number): number => (HEIGHT / 2) * (1 - value / (1.05 * (channel.range || 1)));
      channel.line.setAttribute("points", bins.map(([bin, value]) => `${(((bin - last + BINS) / BINS) * WIDTH).toFixed(1)},${y(value).toFixed(1)}`).join(" "));
      setText(channel.newest, `${bins.length > 0 ? bins.at(-1)![1].toPrecision(3) : "–"} ${channel.description.unit}`);
    }
  }
}

const binOf = (time: number): number => Math.floor((time * BINS) / WINDOW_S);

/// What was not measured is left out.
function put({ bins }: Channel, time: number, value: number): void {
  if (!Number.isFinite(value)) return;
  const bin = binOf(time);
  const known = bins.get(bin);
  if (known === undefined || Math.abs(value) > Math.abs(known)) bins.set(bin, value);
}

const channelOf = (description: AuxiliaryChannel): Channel => ({
  description, bins: new Map(), range: 0, newest: el("output", {}, "–"),
  line: svg("polyline", { class: "course tone-0" }),
});

function row({ description, line, newest }: Channel): HTMLElement {
  const drawing = svg("svg", { viewBox: `0 0 ${WIDTH} ${HEIGHT}`, preserveAspectRatio: "none", role: "img", "aria-label": `${description.name} (${description.unit})` }, svg("path", { class: "axis", d: `M 0 ${HEIGHT / 2} H ${WIDTH}` }), line);
  return el("div", { class: "channel", "data-channel": description.name }, el("span", {}, el("strong", {}, description.name), ` ${description.type} `, newest), drawing);
}
