#!/usr/bin/env python3
"""Compares the results in a folder of the benchmark, number by number, and prints the times side by side."""
import json
import sys
from pathlib import Path

import numpy as np

# Both compute the same thing; the roots of the cross-validation are found to 1e-14 of ln mu by either.
ALLOWED = 1e-6
KEYS = ("M_kg", "B_Ns_per_m", "K_N_per_m", "X0_m")


def conditions(file):
    """Those of the published methods: SciPy's side has no other."""
    return {(c["participant"], c["session"], c["run"], c["method"], c["model"]): c
            for c in json.load(open(file))["conditions"] if c["method"] != "refined"}


def difference(a, b, scale):
    return float(np.abs(np.subtract(a, b)).max() / scale) if np.size(b) else 0.0


def without_bias(one, key):
    """The 95 % interval of a matrix's elements as it is before it carries the method's known bias."""
    bias = one["known_bias"].get(key)
    ends = np.array(one["ci95"][key], dtype=float)
    if bias is None:
        return ends
    ends[..., 0] += np.maximum(0.0, bias)
    ends[..., 1] += np.minimum(0.0, bias)
    return ends


def worst_difference(ours, theirs):
    """Largest difference of a number, as a share of the largest element of its matrix. SciPy's side simulates no bias."""
    worst = 0.0
    for name, one in ours.items():
        other = theirs[name]
        if (one["status"], one["reasons"], one["trials_used"]) != (other["status"], other["reasons"], other["trials_used"]):
            sys.exit(f"compare: {name}: {one['status']} {one['reasons']} against {other['status']} {other['reasons']}")
        for key in KEYS:
            if np.shape(one[key]) != np.shape(other[key]):
                continue  # models (13), (14): a velocity term of another shape than 2 x 2 is not in the file
            scale = np.abs(other[key]).max()
            worst = max(worst, difference(one[key], other[key], scale))
            worst = max(worst, difference(one["std"][key], other["std"][key], scale))
            worst = max(worst, difference(without_bias(one, key), other["ci95"][key], scale))
        worst = max(worst, difference(one["sigma_N"], other["sigma_N"], max(other["sigma_N"])))
        worst = max(worst, difference(one["condition_number"], other["condition_number"], other["condition_number"]))
        for matrix, shape in other["ellipses"].items():
            if "size" in shape:
                worst = max(worst, *(difference(one["ellipses"][matrix][k], v, abs(v)) for k, v in shape.items()))
    return worst


def best(file):
    return min(tuple(map(float, line.split())) for line in open(file))


folder = Path(sys.argv[1])
agrees = True
print(f"\n{'':24}{'wall s':>9}{'CPU s':>9}{'times slower than tonus: wall':>32}{'CPU':>8}{'largest difference':>21}")
for method in ("state_variable", "all"):
    ours = conditions(folder / f"{method}.tonus.json")
    wall, user, system = best(folder / f"{method}.tonus.times")
    print(f"--method {method:15}{wall:9.3f}{user + system:9.3f}   tonus identify, {len(ours)} results")
    for style in ("plain", "tuned"):
        theirs = conditions(folder / f"{method}.{style}.json")
        if ours.keys() != theirs.keys():
            sys.exit(f"compare: {method}: not the same conditions in both")
        worst = worst_difference(ours, theirs)
        agrees &= worst <= ALLOWED
        w, u, s = best(folder / f"{method}.{style}.times")
        print(f"  SciPy, {style:15}{w:9.3f}{u + s:9.3f}{w / wall:32.1f}{(u + s) / (user + system):8.1f}{worst:21.1e}")
print("plain: each step by the library's own function; tuned: rearranged for speed by hand (identify_scipy.py)")
if not agrees:
    sys.exit(f"compare: the numbers differ by more than {ALLOWED}")
