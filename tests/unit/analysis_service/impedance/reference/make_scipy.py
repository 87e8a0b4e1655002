"""Writes scipy.txt: what NumPy and SciPy make of record.txt. Blocks of "name rows columns" and their numbers."""
import numpy as np
from scipy import signal
from scipy.fft import dst
from scipy.optimize import brentq

DT, REST, WINDOW = 0.005, 20, 100
CUTOFF, NATURAL, RATIO = 10.0, 2.3, 0.1
record = np.loadtxt("record.txt")
out = open("scipy.txt", "w")


def write(name, values):
    values = np.atleast_2d(np.asarray(values, float))
    out.write(f"{name} {values.shape[0]} {values.shape[1]}\n")
    np.savetxt(out, values, fmt="%.17g")


trials = []
for number in np.unique(record[:, 0]):
    rows = record[record[:, 0] == number][:, 1:]
    rows = rows - rows[:REST].mean(axis=0)
    trials.append((rows[:, :2], rows[:, 2:]))


def second_difference(x):
    a = np.empty_like(x)
    a[1:-1] = (x[2:] - 2 * x[1:-1] + x[:-2]) / DT**2
    a[0], a[-1] = a[1], a[-2]
    return a


def lowpass(x, f):
    b, a = signal.butter(2, CUTOFF, fs=1 / DT)
    y = signal.filtfilt(b, a, x, axis=0)
    return second_difference(y), np.gradient(y, DT, axis=0), y, f


def state_variable_one(u):
    """Exact for a first-order hold; a zero sample stands before the first."""
    wn = 2 * np.pi * NATURAL
    A = np.array([[0, 1], [-wn**2, -2 * RATIO * wn]])
    u = np.r_[0.0, u]
    system = (A, np.array([[0], [wn**2]]), np.eye(2), np.zeros((2, 1)))
    _, _, s = signal.lsim(system, u, np.arange(len(u)) * DT, interp=True)
    acceleration = wn**2 * (u - s[:, 0]) - 2 * RATIO * wn * s[:, 1]
    return acceleration[1:], s[1:, 1], s[1:, 0]


def state_variable(x, f):
    states = [state_variable_one(x[:, i]) for i in range(2)]
    force = np.c_[state_variable_one(f[:, 0])[2], state_variable_one(f[:, 1])[2]]
    return tuple(np.c_[states[0][i], states[1][i]] for i in range(3)) + (force,)


def regularisation(b, duration, p, cost):
    """Root of d ln V / d ln mu next to the lowest V of a grid, by Brent's method."""
    penalty = (np.arange(1, len(b) + 1) * np.pi / duration) ** (2 * p)
    n = len(b)

    def value(log_mu):
        s = 1 - 1 / (1 + np.exp(log_mu) * penalty)
        freedom = n - cost * (n - s.sum())
        return (s**2 * b**2).sum() / freedom**2 if freedom > 0 else np.inf

    def slope(log_mu):
        g = 1 / (1 + np.exp(log_mu) * penalty)
        s = np.exp(log_mu) * penalty * g
        lost = (s**2 * b**2).sum()
        return (s**2 * g * b**2).sum() / lost - cost * (s * g).sum() / (n - cost * g.sum())

    grid = np.linspace(-np.log(penalty[-1]) - 2 * p * np.log(4), -np.log(penalty[0]) + 2 * p * np.log(2), 30)
    best = int(np.argmin([value(l) for l in grid]))
    low, high = grid[best - 1], grid[best + 1]
    while not np.isfinite(value(low)):
        low += 0.01 * (high - low)
    return np.exp(brentq(slope, low, high, xtol=1e-14, rtol=1e-15))


def optimal_one(x, cost=2.0):
    m = len(x) - 1
    duration = m * DT
    line = x[0] + (x[-1] - x[0]) * np.arange(m + 1) / m
    b = dst((x - line)[1:-1], type=1) / m
    q = np.arange(1, m) * np.pi / duration
    phase = np.outer(np.arange(m + 1), np.arange(1, m)) * np.pi / m
    mu2, mu3 = (regularisation(b, duration, p, cost) for p in (2, 3))
    c2, c3 = b / (1 + mu2 * q**4), b / (1 + mu3 * q**6)
    value = line + np.sin(phase) @ c2
    rate = (x[-1] - x[0]) / duration + np.cos(phase) @ (q * c2)
    return -np.sin(phase) @ (q**2 * c3), rate, value, mu2, mu3


def optimal(x, f):
    states = [optimal_one(x[:, i]) for i in range(2)]
    return tuple(np.c_[states[0][i], states[1][i]] for i in range(3)) + (f,)


def fit(method, left_out=None):
    phi, force = [], []
    for number, (x, f) in enumerate(trials):
        if number == left_out:
            continue
        a, v, y, g = method(x, f)
        rows = slice(REST, REST + WINDOW)
        phi.append(np.c_[a, v, y, np.ones(len(y))][rows])
        force.append(g[rows])
    phi, force = np.vstack(phi), np.vstack(force)
    theta = np.linalg.lstsq(phi, force, rcond=None)[0]
    sigma = np.sqrt(((force - phi @ theta) ** 2).mean(axis=0))
    condition = np.linalg.cond(phi / np.linalg.norm(phi, axis=0))
    return theta, sigma, condition


for name, method in (("lowpass", lowpass), ("optimal", optimal), ("state_variable", state_variable)):
    a, v, y, f = method(*trials[0])
    write(name, np.c_[a, v, y, f])
    theta, sigma, condition = fit(method)
    write(name + "_theta", theta)
    write(name + "_sigma", sigma)
    write(name + "_condition", condition)
    g = len(trials)
    left_out = np.array([fit(method, i)[0] for i in range(g)])
    write(name + "_std", np.sqrt((g - 1) / g * ((left_out - theta) ** 2).sum(axis=0)))

m = len(trials[0][0]) - 1
x = trials[0][0][:, 0]
b = dst((x - x[0] - (x[-1] - x[0]) * np.arange(m + 1) / m)[1:-1], type=1) / m
write("sine_coefficients", b[:, None])
write("mu", [[regularisation(b, m * DT, p, cost) for p in (2, 3)] for cost in (1.0, 2.0)])


def peak(x):
    u = x[REST : REST + WINDOW] - x[REST : REST + WINDOW].mean(axis=0)
    length = 1024  # the power of two at or above eight times 100
    power = (np.abs(np.fft.rfft(u, length, axis=0)) ** 2).sum(axis=1)
    width = 1 / (length * DT)
    first = int(np.ceil(0.5 / (WINDOW * DT) / width))
    k = first + int(np.argmax(power[first : length // 4 + 1]))
    parabola = np.polyfit([-1, 0, 1], power[k - 1 : k + 2], 2) if k > first else [1, 0, 0]
    return (k - parabola[1] / (2 * parabola[0])) * width


write("peak_frequency", [peak(x) for x, _ in trials])
