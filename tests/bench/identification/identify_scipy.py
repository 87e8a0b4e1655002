#!/usr/bin/env python3
"""The analysis of `tonus identify` with NumPy and SciPy: the yardstick of its speed, and a second opinion on its numbers.

    identify_scipy.py DATASET [--style plain|tuned] [--method all|NAME] [--model all|NAME] --json FILE

Two-axis datasets with raw channels. Same files, same rows, same methods, same keys in the result. It is written twice
where that makes a difference:

plain: each step by the function that these libraries have for it: signal.lsim for (8), linalg.lstsq for every fit,
       that is of the condition, without each of its trials, and of each window of the convergence trace.
tuned: rearranged for speed by hand: (8) as recursive filter by lfilter, the fits without a trial from the triangular
       factors of the trials, all windows of the trace in one batch from summed normal equations.
"""
import argparse
import csv
import json
from pathlib import Path

import numpy as np
from scipy import fft, optimize, signal, stats

METHODS = ("lowpass", "optimal", "state_variable")
MODELS = ("linear", "no_damping", "coriolis", "squared_velocity", "signed_squared_velocity")
WINDOW, REST_BEFORE, REST = 1.0, 1.0, 0.5  # s
CUTOFF, RATIO = 10.0, 0.1
RANK_MARGIN = 1e-6
STYLE = "tuned"
SETTLING_SHARE = 0.08


# Files and conversion


def read_table(file):
    with open(file, newline="") as f:
        return list(csv.DictReader(f, delimiter="\t"))


def read_runs(root):
    for motion in sorted(Path(root).glob("sub-*/**/motion/*_motion.tsv")):
        stem = str(motion)[: -len("_motion.tsv")]
        names = [row["name"] for row in read_table(stem + "_channels.tsv")]
        columns = [names.index(name) for name in ("q1", "q2", "f1", "f2", "xc", "yc")]
        try:
            rows = np.loadtxt(motion, delimiter="\t", usecols=columns)
        except ValueError:  # n/a somewhere
            rows = np.genfromtxt(motion, delimiter="\t", usecols=columns, missing_values="n/a")
        entities = dict(part.split("-", 1) for part in motion.name.split("_")[:-1])
        events = stem + "_events.tsv"
        if not Path(events).exists():
            events = stem.replace("_tracksys-" + entities["tracksys"], "") + "_events.tsv"
        yield {
            "participant": "sub-" + entities["sub"],
            "session": "ses-" + entities["ses"] if "ses" in entities else None,
            "run": int(entities.get("run", "1")),
            "rows": rows,
            "events": read_table(events),
            "rate": json.load(open(stem + "_motion.json"))["SamplingFrequency"],
            "channels": json.load(open(stem + "_channels.json")),
        }


def convert(rows, channels):
    """Counts and volts to position (m) and force (N) in the shoulder frame."""
    rig, pose = channels["Rig"], channels["ShoulderInRobot"]
    zero, sign, counts = (np.array(rig[k]) for k in ("EncoderZero_count", "EncoderSign", "EncoderCountsPerRevolution"))
    q = sign * (rows[:, :2] - zero) * 2 * np.pi / counts
    l1, l2 = rig["LinkLengths_m"]
    q12 = q.sum(axis=1)
    p = np.c_[l1 * np.cos(q[:, 0]) + l2 * np.cos(q12), l1 * np.sin(q[:, 0]) + l2 * np.sin(q12)]
    f = (rows[:, 2:4] - rig["ForceOffset_V"]) @ np.array(rig["ForceCalibration_N_per_V"]).T
    turn = q12 + rig["ForceSensorAngle_rad"] - pose["angle_rad"]
    c, s = np.cos(turn), np.sin(turn)
    f = np.c_[c * f[:, 0] - s * f[:, 1], s * f[:, 0] + c * f[:, 1]]
    c, s = np.cos(pose["angle_rad"]), np.sin(pose["angle_rad"])
    return (p - [pose["x_m"], pose["y_m"]]) @ np.array([[c, -s], [s, c]]), f


def trials_of(run):
    """Prepared trials by number, and those that are left out."""
    rig, rate, rows = run["channels"]["Rig"], run["rate"], run["rows"]
    position, force = convert(rows, run["channels"])
    trials, rejected = [], []
    for event in run["events"]:
        number, onset = int(event["trial"]), round(float(event["onset"]) * rate)
        first = max(0, round((float(event["onset"]) - REST_BEFORE) * rate))
        last = min(len(rows) - 1, round((float(event["onset"]) + float(event["duration"])) * rate))
        stretch = rows[first : last + 1]
        if event["valid"] != "true":
            rejected.append({"trial": number, "reason": event["reason"]})
        elif np.isnan(stretch).any():
            rejected.append({"trial": number, "reason": "gap"})
        elif (np.abs(stretch[:, 2:4]) >= rig.get("ForceSaturation_V", 10.0)).any():
            rejected.append({"trial": number, "reason": "saturated"})
        else:
            used = slice(max(first, onset - round(REST * rate)), last + 1)
            rest = onset - used.start
            x, f = position[used], force[used]
            trials.append({
                "number": number, "onset": rest, "commanded": rows[used, 4:6],
                "x": x - x[:rest].mean(axis=0), "f": f - f[:rest].mean(axis=0),
            })
    return trials, rejected


# Derivatives


def second_difference(x, dt):
    a = np.empty_like(x)
    a[1:-1] = (x[2:] - 2 * x[1:-1] + x[:-2]) / dt**2
    a[0], a[-1] = a[1], a[-2]
    return a


def smooth(x, dt):
    b, a = signal.butter(2, CUTOFF, fs=1 / dt)
    return signal.filtfilt(b, a, x, axis=0)


def lowpass(x, f, dt, _):
    y = smooth(x, dt)
    return second_difference(y, dt), np.gradient(y, dt, axis=0), y, f


def filter_step(frequency, ratio, dt):
    """Numerators of y and y' and the denominator of (8), exact for a first-order hold."""
    wn = 2 * np.pi * frequency
    A = np.array([[0, 1], [-(wn**2), -2 * ratio * wn]])
    discrete = signal.cont2discrete((A, np.array([[0], [wn**2]]), np.eye(2), np.zeros((2, 1))), dt, method="foh")
    numerators, denominator = signal.ss2tf(*discrete[:4])
    return numerators, denominator, wn


def states(u, frequency, ratio, dt):
    if STYLE == "plain":
        wn = 2 * np.pi * frequency
        A = np.array([[0, 1], [-(wn**2), -2 * ratio * wn]])
        system = (A, np.array([[0], [wn**2]]), np.eye(2), np.zeros((2, 1)))
        u0 = np.vstack([np.zeros((1, u.shape[1])), u])  # a zero sample stands before the first
        time = np.arange(len(u0)) * dt
        both = np.stack([signal.lsim(system, one, time, interp=True)[1][1:] for one in u0.T])
        y, rate = both[:, :, 0].T, both[:, :, 1].T
        return wn**2 * (u - y) - 2 * ratio * wn * rate, rate, y
    numerators, denominator, wn = filter_step(frequency, ratio, dt)
    y = signal.lfilter(numerators[0], denominator, u, axis=0)
    rate = signal.lfilter(numerators[1], denominator, u, axis=0)
    return wn**2 * (u - y) - 2 * ratio * wn * rate, rate, y


def state_variable(x, f, dt, frequency):
    return states(x, frequency, RATIO, dt) + (states(f, frequency, RATIO, dt)[2],)


def regularisation(b, duration, p, cost=2.0):
    """Generalised cross-validation: lowest of a grid, then the root of the slope beside it."""
    penalty = (np.arange(1, len(b) + 1) * np.pi / duration) ** (2 * p)
    n, b2 = len(b), b**2
    grid = np.linspace(-np.log(penalty[-1]) - 2 * p * np.log(4), -np.log(penalty[0]) + 2 * p * np.log(2), 30)
    w = np.exp(grid)[:, None] * penalty
    s = w / (1 + w)
    freedom = n - cost * (n - s.sum(axis=1))
    value = np.where(freedom > 0, (s**2 @ b2) / freedom**2, np.inf)

    def slope(log_mu):
        g = 1 / (1 + np.exp(log_mu) * penalty)
        s = 1 - g
        left = n - cost * g.sum()
        if left <= 0:
            return -1.0
        lost = s**2 * b2
        return (lost @ g) / lost.sum() - cost * (s @ g) / left

    best = int(np.argmin(value))
    low, high = grid[max(best - 1, 0)], grid[min(best + 1, len(grid) - 1)]
    if not (slope(low) < 0 < slope(high)):
        return np.exp(grid[best])
    return np.exp(optimize.brentq(slope, low, high, xtol=1e-14, rtol=1e-15))


def optimal(x, f, dt, _):
    m = len(x) - 1
    duration = m * dt
    line = x[0] + np.outer(np.arange(m + 1) / m, x[-1] - x[0])
    b = fft.dst((x - line)[1:-1], type=1, axis=0) / m
    q = (np.arange(1, m) * np.pi / duration)[:, None]
    mu = [np.array([regularisation(b[:, i], duration, p) for i in range(x.shape[1])]) for p in (2, 3)]
    c2, c3 = b / (1 + mu[0] * q**4), b / (1 + mu[1] * q**6)
    ends = np.zeros((1, x.shape[1]))
    sines = lambda c: np.r_[ends, fft.dst(c, type=1, axis=0) / 2, ends]
    cosines = lambda c: fft.dct(np.r_[ends, c, ends], type=1, axis=0) / 2
    return -sines(q**2 * c3), cosines(q * c2) + (x[-1] - x[0]) / duration, line + sines(c2), f


def velocity_terms(v, model):
    if model == "linear":
        return v
    if model == "no_damping":
        return v[:, :0]
    if model == "coriolis":
        return np.c_[v[:, 0] ** 2, v[:, 0] * v[:, 1], v[:, 1] ** 2]
    return v**2 if model == "squared_velocity" else v * np.abs(v)


def fit_signals(trial, method, model, dt, frequency, handle_mass):
    derivatives = {"lowpass": lowpass, "optimal": optimal, "state_variable": state_variable}[method]
    a, v, y, f = derivatives(trial["x"], trial["f"], dt, frequency)
    if method == "state_variable" and model not in ("linear", "no_damping"):
        terms = velocity_terms(np.gradient(smooth(trial["x"], dt), dt, axis=0), model)
        terms = states(terms, frequency, RATIO, dt)[2]
    else:
        terms = velocity_terms(v, model)
    return np.c_[a, terms, y, np.ones(len(y))], f - handle_mass * a


# Tuning and diagnosis


def tuned_frequency(trials, dt):
    rows = round(WINDOW / dt)
    u = np.stack([t["x"][t["onset"] : t["onset"] + rows] for t in trials])
    u = u - u.mean(axis=1, keepdims=True)
    length = 256
    while length < 8 * rows:
        length *= 2
    power = (np.abs(np.fft.rfft(u, length, axis=1)) ** 2).sum(axis=2)
    width = 1 / (length * dt)
    first = max(1, int(np.ceil(0.5 / (rows * dt) / width)))
    k = first + np.argmax(power[:, first : length // 4 + 1], axis=1)
    before, at, after = (np.take_along_axis(power, (k + i)[:, None], axis=1)[:, 0] for i in (-1, 0, 1))
    curvature = before - 2 * at + after
    shift = np.where((k > first) & (curvature < 0), 0.5 * (before - after) / curvature, 0.0)
    return ((k + shift) * width).mean()


def spread(scatter):
    values = np.linalg.eigvalsh(scatter)
    return np.sqrt(max(values[0], 0.0) / values[1]) if values[1] > 0 else 0.0


def has_flat_extreme(f, least, dt):
    limit = max(6, round(0.025 / dt))
    for extreme in (f.max(), f.min()):
        if abs(extreme) < least:
            continue
        flat = np.abs(f - extreme) <= 1e-9 * abs(extreme)
        edges = np.flatnonzero(np.diff(np.r_[0, flat, 0]))
        if len(edges) and (edges[1::2] - edges[::2]).max() >= limit:
            return True
    return False


def diagnose(trials, dt, frequency):
    window = round(WINDOW / dt)
    mean = lambda key: np.stack([t[key][t["onset"] : t["onset"] + window].mean(axis=0) for t in trials])
    reasons = []
    for axis in range(2):
        largest = max(np.abs(t["f"][:, axis]).max() for t in trials)
        if any(has_flat_extreme(t["f"][t["onset"] :, axis], 0.5 * largest, dt) for t in trials):
            reasons.append("clipped_force")
            break
    commanded = mean("commanded")
    if spread(commanded.T @ commanded) < 0.10:
        return reasons + ["single_direction"]

    D = mean("x")
    W = np.linalg.pinv(D)
    rest = min(t["onset"] for t in trials)
    moving = min(round((WINDOW + 0.060) / dt), *(len(t["x"]) - t["onset"] for t in trials))
    cut = lambda t, signal: signal[t["onset"] - rest : t["onset"] + moving]
    smooth = lambda signal: states(signal, 2 * frequency, 0.7, dt)
    x = np.stack([np.hstack(smooth(cut(t, t["x"]))) for t in trials])
    f = np.stack([smooth(cut(t, t["f"] - t["f"][: t["onset"]].mean(axis=0)))[2] for t in trials])
    mean_x, mean_f = (np.einsum("ig,gkj->ikj", W, one) for one in (x, f))
    if spread(sum(one.T @ one for one in mean_f)) < 0.03:
        return reasons + ["collinear_force"]

    reach = round(0.060 / dt)
    before = min(rest - reach, round(0.1 / dt))
    after = min(round(1.25 / frequency / dt), rest + moving - rest - reach)
    if before < 1 or after < 4 * 7 or len(trials) < 4:
        return reasons
    first, rows = rest - before, before + after
    stacked = lambda signals, begin: np.vstack([one[begin : begin + rows] for one in signals])
    phi = stacked(mean_x, first)
    Q, R = np.linalg.qr(np.c_[phi, np.ones(len(phi))])
    own_x, own_f = (one - np.einsum("gi,ikj->gkj", D, common) for one, common in ((x, mean_x), (f, mean_f)))
    own_share = (W**2).sum() / (len(trials) - 2)
    misfit, possible = [], []
    for lag in range(-reach, reach + 1):
        g = stacked(mean_f, first + lag)
        z = Q.T @ g
        theta = np.linalg.solve(R, z)
        own = ((stacked(own_f, first + lag) - stacked(own_x, first) @ theta[:6]) ** 2).sum(axis=0)
        misfit.append(((g - Q @ z) ** 2).sum(axis=0) / (own_share * own))
        possible.append([(theta[[i, 2 + i, 4 + i], i] > 0).all() for i in range(2)])
    misfit, possible = np.array(misfit), np.array(possible)
    for axis in range(2):
        if not possible[:, axis].any():
            continue
        best = np.where(possible[:, axis], misfit[:, axis], np.inf).argmin()
        needed = 1.5 if possible[reach, axis] else 1.0
        if abs(best - reach) * dt > 0.0175 and misfit[reach, axis] > needed * misfit[best, axis]:
            return reasons + ["force_shifted"]
    return reasons


# Fit


def parameters(theta, terms):
    M, B, K = theta[..., :2, :], theta[..., 2 : 2 + terms, :], theta[..., 2 + terms : 4 + terms, :]
    M, B, K = (np.swapaxes(Z, -1, -2) for Z in (M, B, K))
    X0 = -np.linalg.solve(K, theta[..., -1, :, None])[..., 0]
    return {"M_kg": M, "B_Ns_per_m": B, "K_N_per_m": K, "X0_m": X0}


def settling_time(phi, force, terms, value, dt):
    """From the estimate of every growing window. phi: trials x rows x regressors."""
    rows = phi.shape[1]
    if STYLE == "plain":
        times, theta = [], []
        for k in range(1, rows + 1):
            a, b = phi[:, :k].reshape(-1, phi.shape[2]), force[:, :k].reshape(-1, 2)
            solution, _, _, singular = np.linalg.lstsq(a, b, rcond=None)
            if singular[-1] > RANK_MARGIN * singular[0]:
                times.append(k * dt)
                theta.append(solution)
        times, theta = np.array(times), np.array(theta)
    else:
        times, theta = windows_at_once(phi, force, dt)
    trace = parameters(theta, terms)
    inside = np.ones(len(times), bool)
    for key in ("M_kg", "B_Ns_per_m", "K_N_per_m"):
        if value[key].size:
            limit = SETTLING_SHARE * np.abs(value[key]).max()
            inside &= (np.abs(trace[key] - value[key]) <= limit).all(axis=(1, 2))
    outside = np.flatnonzero(~inside)
    settled = 0 if len(outside) == 0 else outside[-1] + 1
    return times[settled] if settled < len(times) - 1 else None


def windows_at_once(phi, force, dt):
    """Times and solutions of the windows that determine one."""
    scale = np.sqrt((phi**2).sum(axis=(0, 1)))
    scaled = phi / scale
    normal = np.cumsum(np.einsum("gki,gkj->kij", scaled, scaled), axis=0)
    right = np.cumsum(np.einsum("gki,gkj->kij", scaled, force), axis=0)
    determined = np.linalg.cond(normal) < RANK_MARGIN**-2
    theta = np.linalg.solve(normal[determined], right[determined]) / scale[:, None]
    return (np.flatnonzero(determined) + 1) * dt, theta


def ellipse(Z):
    s = (Z + Z.T) / 2
    values = np.linalg.eigvalsh(s)
    if values[0] <= 0:
        return {"reason": "not positive definite"}, 0.0
    angle = 0.5 * np.arctan2(2 * s[0, 1], s[0, 0] - s[1, 1])
    curl = abs(Z[0, 1] - Z[1, 0]) / 2 / np.sqrt(values[0] * values[1])
    return {"size": np.pi * values[0] * values[1], "shape": values[1] / values[0],
            "orientation_deg": np.degrees(angle)}, curl


def identify(trials, method, model, dt, frequency, reasons, handle_mass):
    window = round(WINDOW / dt)
    pairs = [fit_signals(t, method, model, dt, frequency, handle_mass) for t in trials]
    phi = np.stack([p[t["onset"] : t["onset"] + window] for (p, _), t in zip(pairs, trials)])
    force = np.stack([f[t["onset"] : t["onset"] + window] for (_, f), t in zip(pairs, trials)])
    size, g = phi.shape[2], len(trials)
    terms = size - 5
    factors = np.linalg.qr(np.concatenate([phi, force], axis=2), mode="r") if STYLE == "tuned" else None

    def solve(used):
        if STYLE == "plain":
            solution = np.linalg.lstsq(phi[used].reshape(-1, size), force[used].reshape(-1, 2), rcond=None)[0]
            return phi[used].reshape(-1, size), solution
        R = np.linalg.qr(factors[used].reshape(-1, size + 2), mode="r")
        return R[:size, :size], np.linalg.solve(R[:size, :size], R[:size, size:])

    R, theta = solve(np.arange(g))
    value = parameters(theta, terms)
    condition = np.linalg.cond(R / np.linalg.norm(R, axis=0))
    result = {"condition_number": condition, "samples": g * window, "trials_used": g}
    if condition * RANK_MARGIN >= 1 or "single_direction" in reasons or g < 2:
        return {**result, "status": "undetermined"}
    left_out = parameters(np.stack([solve(np.arange(g) != i)[1] for i in range(g)]), terms)
    std = {k: np.sqrt((g - 1) / g * ((left_out[k] - value[k]) ** 2).sum(axis=0)) for k in value}
    factor = stats.t.ppf(0.975, g - 1)
    error = force - phi @ theta
    result["settled_s"] = settling_time(phi, force, terms, value, dt)
    result["sigma_N"] = np.sqrt((error**2).mean(axis=(0, 1)))
    result.update(value)
    result["std"] = std
    result["ci95"] = {k: np.stack([value[k] - factor * std[k], value[k] + factor * std[k]], axis=-1) for k in value}
    shapes = {k: ellipse(value[key]) for k, key in (("M", "M_kg"), ("B", "B_Ns_per_m"), ("K", "K_N_per_m"))
              if value[key].shape == (2, 2)}
    result["ellipses"] = {k: one[0] for k, one in shapes.items()}
    result["curl"] = {k: one[1] for k, one in shapes.items()}
    negative = [name for name, k in (("negative_stiffness", "K"), ("negative_mass", "M"), ("negative_damping", "B"))
                if (k != "B" or model == "linear") and "reason" in result["ellipses"][k]]
    result["reasons"] = reasons + negative
    result["status"] = "suspect" if result["reasons"] else "ok"
    return result


def plain(value):
    if isinstance(value, np.ndarray):
        return value.tolist()
    return value.item() if isinstance(value, np.generic) else str(value)


def main():
    global STYLE
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("dataset")
    parser.add_argument("--style", default="tuned", choices=("plain", "tuned"))
    parser.add_argument("--method", default="state_variable", choices=METHODS + ("all",))
    parser.add_argument("--model", default="linear", choices=MODELS + ("all",))
    parser.add_argument("--json", required=True)
    options = parser.parse_args()
    STYLE = options.style
    methods = METHODS if options.method == "all" else (options.method,)
    models = MODELS if options.model == "all" else (options.model,)
    conditions = []
    for run in read_runs(options.dataset):
        dt = 1 / run["rate"]
        trials, rejected = trials_of(run)
        frequency = tuned_frequency(trials, dt)
        reasons = diagnose(trials, dt, frequency)
        mass = run["channels"]["Rig"]["HandleMass_kg"]
        for method in methods:
            for model in models:
                conditions.append({
                    "participant": run["participant"], "session": run["session"], "run": run["run"],
                    "posture": run["channels"]["Posture"]["name"], "method": method, "model": model,
                    "trials_rejected": rejected,
                    **identify(trials, method, model, dt, frequency, reasons, mass),
                })
    with open(options.json, "w") as out:
        json.dump({"schema": 1, "conditions": conditions}, out, indent=1, default=plain)


main()
