"""Figures by Matplotlib."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Iterable, Optional

import numpy as np

from tonus.errors import InvalidArgumentError
from tonus.estimate import Array, Estimate

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def outline(matrix: Array, points: int = 181) -> Array:
    """The ellipse of a matrix's symmetric part, ``(points, 2)``, about the origin: what a unit displacement in each
    direction gives; semi-axes are the eigenvalues, in the matrix's unit.

    Raises InvalidArgumentError for a matrix that is not 2 x 2, or not positive definite.
    """
    given = np.asarray(matrix, dtype=float)
    if given.shape != (2, 2):
        raise InvalidArgumentError(f"matrix: shape {given.shape} is not allowed; expected (2, 2)")
    values, vectors = np.linalg.eigh((given + given.T) / 2)
    if not np.all(values > 0):
        raise InvalidArgumentError(f"matrix: eigenvalues {values} are not allowed; expected more than 0")
    angle = np.linspace(0.0, 2.0 * np.pi, points)
    circle = np.stack([values[0] * np.cos(angle), values[1] * np.sin(angle)])
    drawn: Array = (vectors @ circle).T
    return drawn


def ellipses(estimates: Iterable[Estimate], name: str = "K", *, ax: Optional["Axes"] = None,
             scale: Optional[float] = None, **style: Any) -> "Axes":
    """Draws the ellipse of ``M``, ``B`` or ``K`` of each estimate at its posture in S.

    Args:
        estimates: two-axis ones; those without numbers or without an ellipse are left out. Suspect ones are dashed.
        name: the matrix.
        ax: to draw into; None: a new figure.
        scale: m drawn for one unit of the matrix; None: the largest ellipse gets a semi-axis of 0.08 m.
        style: of the lines, as Matplotlib's ``plot``.

    Returns:
        The axes, in m, equal in both directions. A bar says how long the matrix's unit is.

    Raises:
        InvalidArgumentError: no estimate has an ellipse, or another name.
    """
    import matplotlib.pyplot as plt

    drawn = [e for e in estimates if e.axes == 2 and e.posture_m is not None and e.ellipse(name) is not None]
    if not drawn:
        raise InvalidArgumentError(f"ellipses: 0 estimates with an ellipse of {name} are not allowed; expected 1 or more")
    lines = [outline(getattr(e, name)) for e in drawn]
    largest = max(float(np.hypot(line[:, 0], line[:, 1]).max()) for line in lines)
    factor = 0.08 / largest if scale is None else scale
    if ax is None:
        _, ax = plt.subplots()
    colours: dict[str, Any] = {}
    for estimate, line in zip(drawn, lines):
        place = estimate.posture_m
        assert place is not None
        own = dict(style)
        label = estimate.posture if estimate.posture not in colours else None
        own.setdefault("color", colours.setdefault(estimate.posture, f"C{len(colours) % 10}"))
        own.setdefault("linestyle", "-" if estimate.is_ok else "--")
        ax.plot(place[0] + factor * line[:, 0], place[1] + factor * line[:, 1], label=label, **own)
        ax.plot([place[0]], [place[1]], ".", color=own["color"], markersize=3)
    _add_bar(ax, factor, largest, drawn[0].units[name])
    ax.set_aspect("equal", adjustable="datalim")
    ax.set_xlabel("x (m)")
    ax.set_ylabel("y (m)")
    ax.set_title(f"{name} in the shoulder frame")
    ax.legend(loc="upper right", fontsize="small")
    return ax


def _add_bar(ax: "Axes", factor: float, largest: float, unit: str) -> None:
    """A bar of a round length that says what a semi-axis means."""
    power = 10.0 ** np.floor(np.log10(largest))
    length = max(step for step in (1.0, 2.0, 5.0) if step * power <= largest) * power
    left, right = ax.get_xlim()
    bottom, top = ax.get_ylim()
    x, y = left + 0.05 * (right - left), bottom - 0.05 * (top - bottom)
    ax.plot([x, x + factor * length], [y, y], color="black", linewidth=2)
    ax.annotate(f"{length:g} {unit}", (x, y), textcoords="offset points", xytext=(0, 4), fontsize="small")
