// Is it an effect, or noise? Of values measured in pairs of neighbouring blocks, of which one has the clients.

/// How many of the 2^n ways to give n ranks a sign have each sum of the positive ones.
function signedRankCounts(n) {
  let counts = [1];
  for (let rank = 1; rank <= n; ++rank) {
    const next = new Array(counts.length + rank).fill(0);
    counts.forEach((count, sum) => ((next[sum] += count), (next[sum + rank] += count)));
    counts = next;
  }
  return counts;
}

/// Hodges and Lehmann's estimate of where the differences lie (median of all means of two of them), and the interval
/// that belongs to the exact signed rank test. No distribution is assumed but symmetry, which the balanced order of the
/// blocks gives where there is no effect. The level of 95 % is reached or passed; with fewer than 6 there is none.
function shift(differences) {
  const n = differences.length;
  const means = [];
  for (let i = 0; i < n; ++i) for (let j = i; j < n; ++j) means.push((differences[i] + differences[j]) / 2);
  means.sort((x, y) => x - y);
  const counts = signedRankCounts(n);
  let [outside, sum] = [0, counts[0]];
  while (2 * sum <= 0.05 * 2 ** n) sum += counts[++outside];
  const middle = (means[Math.floor((means.length - 1) / 2)] + means[Math.ceil((means.length - 1) / 2)]) / 2;
  const [low, high] = outside === 0 ? [-Infinity, Infinity] : [means[outside - 1], means[means.length - outside]];
  return { middle, low, high };
}

/// The same of the ratio b / a; pairs with a value that is not positive are left out and missing in `pairs`.
function pairedRatio(all) {
  const logs = all.filter(([a, b]) => a > 0 && b > 0).map(([a, b]) => Math.log(b / a));
  const { middle, low, high } = shift(logs);
  return { ratio: Math.exp(middle), low: Math.exp(low), high: Math.exp(high), pairs: logs.length };
}

/// The same of the difference b - a.
const pairedDifference = (all) => shift(all.map(([a, b]) => b - a));

const quantile = (values, share) => {
  const sorted = [...values].sort((a, b) => a - b);
  return sorted[Math.min(sorted.length - 1, Math.floor(share * sorted.length))] ?? NaN;
};

/// Lateness in us that a share of the cycles stayed under; within a class of the histogram by a straight line.
function lateness(counts, share) {
  const total = counts.reduce((sum, count) => sum + count, 0);
  let below = 0;
  for (let i = 0; i < counts.length; ++i) {
    if (counts[i] > 0 && below + counts[i] >= share * total) {
      const low = i === 0 ? 0 : 2 ** (i - 1);
      return low + ((2 ** i - low) * (share * total - below)) / counts[i];
    }
    below += counts[i];
  }
  return NaN;
}

module.exports = { pairedDifference, pairedRatio, quantile, lateness };
