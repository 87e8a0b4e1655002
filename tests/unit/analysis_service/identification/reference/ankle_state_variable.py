#!/usr/bin/env python3
"""Reference values of ankle_test.cpp: I, B, K of each ankle record, with nothing but the standard library.

T(s) = wn^2 / (s^2 + 2 zeta wn s + wn^2) at 30 Hz and 0.1 on angle and torque, discretised for a first-order hold by
the exponential of the augmented matrix, at rest at zero before the first sample; rows of the filter's transient,
5 / (zeta wn), left out; least squares of F = I x" + B x' + K x + c by the normal equations.

Usage: ankle_state_variable.py DATA_DIR
"""
import math
import pathlib
import sys

WN, ZETA, STEP = 2 * math.pi * 30, 0.1, 1e-3
SCALES = (1000.0, 10.0, 0.01, 1.0)  # of the regressors, so that the normal equations keep their digits


def product(a, b):
    return [[sum(x * y for x, y in zip(row, column)) for column in zip(*b)] for row in a]


def exponential(matrix):
    halvings = 12
    part = [[v / 2**halvings for v in row] for row in matrix]
    term = [[float(i == j) for j in range(len(matrix))] for i in range(len(matrix))]
    total = [row[:] for row in term]
    for k in range(1, 20):
        term = [[v / k for v in row] for row in product(term, part)]
        total = [[a + b for a, b in zip(x, y)] for x, y in zip(total, term)]
    for _ in range(halvings):
        total = product(total, total)
    return total


E = exponential([[0, STEP, 0, 0], [-WN * WN * STEP, -2 * ZETA * WN * STEP, WN * WN * STEP, 0], [0, 0, 0, 1], [0] * 4])


def filtered(signal):
    g1 = (E[0][3], E[1][3])
    g0 = (E[0][2] - g1[0], E[1][2] - g1[1])
    value = rate = before = 0.0
    for now in signal:
        value, rate = (E[0][0] * value + E[0][1] * rate + g0[0] * before + g1[0] * now,
                       E[1][0] * value + E[1][1] * rate + g0[1] * before + g1[1] * now)
        before = now
        yield WN * WN * (now - value) - 2 * ZETA * WN * rate, rate, value


def solved(a, b):
    rows = [row[:] + [v] for row, v in zip(a, b)]
    n = len(b)
    for i in range(n):
        pivot = max(range(i, n), key=lambda j: abs(rows[j][i]))
        rows[i], rows[pivot] = rows[pivot], rows[i]
        for j in range(i + 1, n):
            factor = rows[j][i] / rows[i][i]
            rows[j] = [x - factor * y for x, y in zip(rows[j], rows[i])]
    x = [0.0] * n
    for i in reversed(range(n)):
        x[i] = (rows[i][n] - sum(rows[i][c] * x[c] for c in range(i + 1, n))) / rows[i][i]
    return x


def fitted(path):
    data = [tuple(map(float, line.split())) for line in path.read_text().splitlines()]
    mean_x = math.fsum(x for x, _ in data) / len(data)
    mean_t = math.fsum(t for _, t in data) / len(data)
    transient = round(5 / (ZETA * WN) / STEP)
    x = list(filtered([x - mean_x for x, _ in data]))[transient:]
    force = [f for _, _, f in filtered([mean_t - t for _, t in data])][transient:]
    columns = [[row[i] / SCALES[i] for row in x] for i in range(3)] + [[1.0] * len(x)]
    normal = [[math.fsum(p * q for p, q in zip(a, b)) for b in columns] for a in columns]
    right = [math.fsum(p * f for p, f in zip(a, force)) for a in columns]
    return [v / s for v, s in zip(solved(normal, right), SCALES)][:3]


for motion in sorted(pathlib.Path(sys.argv[1]).glob("ankle/sub-01/motion/*_motion.tsv")):
    print(motion.name.split("run-")[1][:2], *(f"{v:.12g}" for v in fitted(motion)))
