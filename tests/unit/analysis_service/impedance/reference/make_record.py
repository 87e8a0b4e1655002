"""Writes record.txt: four trials of a two-axis mass-damper-spring, 20 samples of rest and 100 of motion at 200 Hz.

Columns: trial, x1, x2 (m), f1, f2 (N). The numbers are rounded, so that every program reads the same ones.
"""
import numpy as np

rng = np.random.default_rng(20)
M = np.array([[1.4, -0.8], [-0.8, 1.3]])
B = np.array([[11.0, -8.0], [-7.0, 21.0]])
K = np.array([[180.0, -100.0], [-95.0, 340.0]])
dt, rest, moving, steps = 0.005, 20, 100, 50
rows = []
for trial, direction in enumerate(np.deg2rad([0.0, 90.0, 180.0, 225.0]), start=1):
    x, v = np.zeros(2), np.zeros(2)
    goal = 0.005 * np.array([np.cos(direction), np.sin(direction)])
    for k in range(rest + moving):
        command = goal if k >= rest else np.zeros(2)
        push = 2200.0 * (command - x) - 20.0 * v
        a = np.linalg.solve(M + 8.0 * np.eye(2), push - B @ v - K @ x)
        f = M @ a + B @ v + K @ x + 0.05 * rng.normal(size=2)
        rows.append([trial, *np.round(x + 5e-5 * rng.normal(size=2), 7), *np.round(f, 5)])
        for _ in range(steps):
            push = 2200.0 * (command - x) - 20.0 * v
            a = np.linalg.solve(M + 8.0 * np.eye(2), push - B @ v - K @ x)
            v = v + a * dt / steps
            x = x + v * dt / steps
np.savetxt("record.txt", rows, fmt=["%d", "%.7f", "%.7f", "%.5f", "%.5f"])
