// What the blocks with and without clients say.

const { pairedDifference, pairedRatio, quantile, lateness } = require("./paired.cjs");

const OVER_1_MS = 11; // classes of the histogram from 2^10 us

const sum = (numbers) => numbers.reduce((total, number) => total + number, 0);

/// Blocks of {isWithClients, loop, bare: histograms, cycles, missed, bareCycles, bareMissed, waited: ns a cycle,
/// latencies: ms, cpu: share}, each two neighbours a pair.
function report(blocks) {
  const of = (isWithClients) => blocks.filter((block) => block.isWithClients === isWithClients);
  const pairs = [];
  for (let i = 0; i < blocks.length; i += 2)
    pairs.push([blocks[i], blocks[i + 1]].sort((a, b) => a.isWithClients - b.isWithClients));

  const line = (name, value, unit) => {
    const median = (isWithClients) => quantile(of(isWithClients).map(value), 0.5).toFixed(2).padStart(9);
    const { ratio, low, high, pairs: n } = pairedRatio(pairs.map((pair) => pair.map(value)));
    const missing = n < pairs.length ? `, ${n} pairs` : "";
    console.log(
      `${name.padEnd(42)}${median(false)}${median(true)} ${unit.padEnd(3)}` +
        `${ratio.toFixed(2)} (${low.toFixed(2)} to ${high.toFixed(2)})${missing}`,
    );
  };
  console.log(`${"median of the blocks".padEnd(42)}  without     with    with / without (95 % interval)`);
  for (const share of [0.5, 0.9, 0.99, 0.999]) {
    line(`loop: ${100 * share} % of the cycles late by less`, (block) => lateness(block.loop, share), "us");
    line("bare timer: the same", (block) => lateness(block.bare, share), "us");
    line("loop / bare timer", (block) => lateness(block.loop, share) / lateness(block.bare, share), "");
  }
  line("loop: ready, but another ran, a cycle", (block) => block.waited / 1000, "us");
  line("verdict after a trial's outcome, median", (block) => quantile(block.latencies, 0.5), "ms");

  const counts = [
    ["loop", (block) => block.missed, (block) => block.loop, (block) => block.cycles],
    ["bare timer", (block) => block.bareMissed, (block) => block.bare, (block) => block.bareCycles],
  ];
  for (const [name, missed, histogram, cycles] of counts) {
    const over = (isWithClients) => sum(of(isWithClients).map((block) => sum(histogram(block).slice(OVER_1_MS))));
    const total = (isWithClients, value) => sum(of(isWithClients).map(value));
    const { middle, low, high } = pairedDifference(pairs.map((pair) => pair.map(missed)));
    console.log(
      `${name}: ${total(false, missed)} periods missed without, ${total(true, missed)} with clients, ` +
        `difference a block ${middle.toFixed(1)} (${low.toFixed(1)} to ${high.toFixed(1)}); ` +
        `over 1 ms late: ${over(false)} of ${total(false, cycles)} and ${over(true)} of ${total(true, cycles)} cycles`,
    );
  }
  const each = (isWithClients) => of(isWithClients).map((block) => `${block.missed}/${block.bareMissed}`).join(" ");
  console.log(`missed in each block, loop/bare timer: without ${each(false)}; with ${each(true)}`);
  const cpu = (isWithClients) => ((100 * sum(of(isWithClients).map((block) => block.cpu))) / of(isWithClients).length).toFixed(1);
  console.log(`gateway: ${cpu(false)} % of a processor without, ${cpu(true)} % with clients`);
}

module.exports = { report };
