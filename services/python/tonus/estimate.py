"""Estimates of impedance, and the identification of arrays.

The law is ``F = M X" + B X' + K (X - X0)``: F is the force of the handle on the arm (N), X the displacement of the
hand (m), both in the shoulder frame S (x to the right, y forward). One-axis rigs have the units that ``units`` names.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import Any, Iterable, Mapping, Optional, Sequence, Tuple, Union

import numpy as np
import numpy.typing as npt
import pandas as pd

from tonus import _tonus
from tonus.errors import InvalidArgumentError

Array = npt.NDArray[np.float64]

_KEYS = {"M": "M_kg", "B": "B_Ns_per_m", "K": "K_N_per_m", "X0": "X0_m"}
_UNITS = {"M": "kg", "B": "N s/m", "K": "N/m", "X0": "m", "sigma": "N"}


@dataclass(frozen=True)
class Parameters:
    """Numbers for each element of the impedance.

    Attributes:
        M: mass, ``(axes, axes)``, kg. Of intervals ``(axes, axes, 2)``: low and high end.
        B: damping, as M, N s/m.
        K: stiffness, as M, N/m.
        X0: spring centre, ``(axes,)`` or ``(axes, 2)``, m.
    """

    M: Array
    B: Array
    K: Array
    X0: Array


@dataclass(frozen=True)
class Ellipse:
    """The ellipse of a matrix's symmetric part.

    Attributes:
        size: its area, pi l1 l2, in the square of the matrix's unit.
        shape: larger over smaller eigenvalue, 1 or more.
        orientation_deg: of the major axis from S's x axis, in (-90, 90].
        size_ci95, shape_ci95, orientation_ci95_deg, curl_ci95: 95 % intervals ``(low, high)`` of these and of the
            curl; NaN: not known. An orientation has none where a circle cannot be excluded, and an end of it may lie
            beyond -90 or 90.
    """

    size: float
    shape: float
    orientation_deg: float
    size_ci95: Tuple[float, float] = (np.nan, np.nan)
    shape_ci95: Tuple[float, float] = (np.nan, np.nan)
    orientation_ci95_deg: Tuple[float, float] = (np.nan, np.nan)
    curl_ci95: Tuple[float, float] = (np.nan, np.nan)


class Estimate:
    """One analysis of one condition (posture, bias, instruction).

    What is not known is NaN; an undetermined estimate has no numbers at all. :meth:`as_dict` is the object that
    ``tonus identify --json`` writes, with the same numbers to the last bit.
    """

    def __init__(self, data: Mapping[str, Any], axes: Optional[int] = None,
                 posture_m: Optional[Sequence[float]] = None) -> None:
        self._data = dict(data)
        if axes is None:
            axes = len(data["X0_m"]) if "X0_m" in data else (1 if "units" in data else 2)
        self.axes: int = axes
        """1 or 2."""
        place = None if self.axes == 1 else posture_m if posture_m is not None else data.get("posture_m")
        self.posture_m: Optional[Array] = None if place is None else np.asarray(place, dtype=float)
        """The hand's place, ``(2,)``, m in S; None: not known."""

    def as_dict(self) -> dict[str, Any]:
        """The JSON object, as ``tonus identify --json`` has it."""
        return dict(self._data)

    def _matrix(self, values: Optional[Mapping[str, Any]], name: str, interval: bool = False) -> Array:
        shape: Tuple[int, ...] = (self.axes,) if name == "X0" else (self.axes, self.axes)
        if interval:
            shape += (2,)
        if values is None or _KEYS[name] not in values:
            return np.full(shape, np.nan)
        return np.array(values[_KEYS[name]], dtype=float)  # None becomes NaN

    def _parameters(self, values: Optional[Mapping[str, Any]], interval: bool = False) -> Parameters:
        return Parameters(*(self._matrix(values, name, interval) for name in ("M", "B", "K", "X0")))

    @property
    def M(self) -> Array:
        """Mass, ``(axes, axes)``, kg, in S."""
        return self._matrix(self._data, "M")

    @property
    def B(self) -> Array:
        """Damping, ``(axes, axes)``, N s/m, in S."""
        return self._matrix(self._data, "B")

    @property
    def K(self) -> Array:
        """Stiffness, ``(axes, axes)``, N/m, in S."""
        return self._matrix(self._data, "K")

    @property
    def X0(self) -> Array:
        """Spring centre, ``(axes,)``, m in S, from the hand's mean place before the perturbations."""
        return self._matrix(self._data, "X0")

    @property
    def std(self) -> Parameters:
        """Standard errors."""
        return self._parameters(self._data.get("std"))

    @property
    def ci95(self) -> Parameters:
        """95 % intervals; the last axis is (low, high)."""
        return self._parameters(self._data.get("ci95"), interval=True)

    @property
    def covariance(self) -> Parameters:
        """Covariances of the elements of each matrix, row by row, ``(axes**2, axes**2)``, and of X0, ``(axes, axes)``."""
        found = self._data.get("covariance") or {}
        size = self.axes ** 2

        def of(key: str, n: int) -> Array:
            return np.array(found[key], dtype=float) if key in found else np.full((n, n), np.nan)

        return Parameters(of("M_kg2", size), of("B_N2s2_per_m2", size), of("K_N2_per_m2", size), of("X0_m2", self.axes))

    @property
    def known_bias(self) -> Parameters:
        """Bias of the method in M, B and K, simulated at this estimate; :attr:`ci95` carries it. NaN: not simulated."""
        found = self._data.get("known_bias") or {}

        def of(key: str) -> Array:
            return np.array(found[key], dtype=float) if found.get(key) is not None else np.full((self.axes,) * 2, np.nan)

        return Parameters(of("M_kg"), of("B_Ns_per_m"), of("K_N_per_m"), np.full(self.axes, np.nan))

    @property
    def prior(self) -> str:
        """Whose earlier estimate this one is combined with; empty: none."""
        return str(self._data.get("prior", ""))

    @property
    def status(self) -> str:
        """``ok``, ``suspect`` (do not use without having read :attr:`reasons`) or ``undetermined``."""
        return str(self._data["status"])

    @property
    def is_ok(self) -> bool:
        """True where every check passed."""
        return self.status == "ok"

    @property
    def reasons(self) -> list[str]:
        """Why it is not ok, with numbers."""
        return list(self._data["reasons"])

    @property
    def checks(self) -> list[dict[str, Any]]:
        """What it was judged by: ``test``, ``value``, ``limit``, ``passed``."""
        return list(self._data["checks"])

    @property
    def method(self) -> str:
        return str(self._data["method"])

    @property
    def model(self) -> str:
        return str(self._data["model"])

    @property
    def participant(self) -> str:
        return str(self._data.get("participant", ""))

    @property
    def session(self) -> Optional[str]:
        session = self._data.get("session", self._data.get("session_id"))
        return None if session is None else str(session)

    @property
    def run(self) -> int:
        """The posture's place in the plan, from 1."""
        return int(self._data.get("run", int(self._data.get("posture_index", 0)) + 1))

    @property
    def posture(self) -> str:
        return str(self._data["posture"])

    @property
    def bias(self) -> Array:
        """Bias force on the arm, ``(2,)``, N in S."""
        return np.array(self._data["bias_N"], dtype=float)

    @property
    def set(self) -> Optional[int]:
        """Number of the set; None: all sets together."""
        return None if self._data["set"] is None else int(self._data["set"])

    @property
    def trials_used(self) -> int:
        return int(self._data["trials_used"])

    @property
    def trials_rejected(self) -> list[dict[str, Any]]:
        """``trial`` and ``reason`` of each that was left out."""
        return list(self._data.get("trials_rejected", []))

    @property
    def explained_share(self) -> float:
        """Share of the force's variance that the model explains, 0 to 1."""
        share = self._data["explained_share"]
        return float("nan") if share is None else float(share)

    @property
    def sigma(self) -> Array:
        """Root mean square fitting error, ``(axes,)``, N."""
        return np.array(self._data.get("sigma_N", [np.nan] * self.axes), dtype=float)

    @property
    def units(self) -> dict[str, str]:
        """Units of M, B, K, X0 and sigma."""
        stated = self._data.get("units", {})
        keys = {**_KEYS, "sigma": "sigma_N"}
        return {name: str(stated.get(keys[name], unit)) for name, unit in _UNITS.items()}

    def ellipse(self, name: str = "K") -> Optional[Ellipse]:
        """Ellipse of ``M``, ``B`` or ``K``; None: one axis, or the matrix is not positive definite."""
        if name not in ("M", "B", "K"):
            raise InvalidArgumentError(f"ellipse: {name!r} is not allowed; expected 'M', 'B' or 'K'")
        found = self._data.get("ellipses", {}).get(name)
        if not found or "size" not in found:
            return None
        numbers = {key: tuple(np.nan if end is None else float(end) for end in value) if isinstance(value, list)
                   else value for key, value in found.items()}
        return Ellipse(**numbers)

    def __repr__(self) -> str:
        units = self.units
        lines = [f"<Estimate {self.posture or self.participant}: {self.method}, {self.model}; "
                 f"{self.trials_used} trials; {self.status}>"]
        lines += [f"  {reason}" for reason in self.reasons]
        if self.status != "undetermined":
            std = self.std
            for name in ("M", "B", "K"):
                value, error = getattr(self, name).ravel(), getattr(std, name).ravel()
                numbers = ", ".join(f"{v:.4g} ± {e:.2g}" for v, e in zip(value, error))
                lines.append(f"  {name} {units[name]}: {numbers}")
        return "\n".join(lines)


def estimates_of(text: str) -> list[Estimate]:
    """Estimates of the core's JSON."""
    results = json.loads(text)
    return [Estimate(condition, axes, place) for condition, axes, place in
            zip(results["conditions"], results["axes"], results["posture_m"])]


_ELEMENTS: dict[int, dict[Tuple[int, ...], str]] = {2: {(0, 0): "xx", (0, 1): "xy", (1, 0): "yx", (1, 1): "yy"}, 1: {(0, 0): ""}}
_SUFFIX = {"M": "_kg", "B": "_Ns_per_m", "K": "_N_per_m", "X0": "_m", "sigma": "_N"}


def _ellipse_cells(name: str, ellipse: Optional[Ellipse]) -> dict[str, Any]:
    """Columns of an ellipse's numbers; NaN where there is none."""
    nan = (np.nan, np.nan)
    numbers = {"size": (ellipse.size, ellipse.size_ci95), "shape": (ellipse.shape, ellipse.shape_ci95),
               "orientation_deg": (ellipse.orientation_deg, ellipse.orientation_ci95_deg)} if ellipse else {
                   key: (np.nan, nan) for key in ("size", "shape", "orientation_deg")}
    cells: dict[str, Any] = {}
    for key, (value, ends) in numbers.items():
        cells[f"{name}_{key}"] = value
        cells[f"{name}_{key}_low95"], cells[f"{name}_{key}_high95"] = ends
    return cells


def _cells(estimate: Estimate) -> dict[str, Any]:
    """Columns of one estimate's numbers."""
    cells: dict[str, Any] = {}
    std, ci95 = estimate.std, estimate.ci95
    for name in ("M", "B", "K", "X0"):
        value, error, ends = getattr(estimate, name), getattr(std, name), getattr(ci95, name)
        unit = _SUFFIX[name] if estimate.axes == 2 else ""
        places = np.ndindex(value.shape)
        if name != "X0" and estimate.axes == 2:
            cells.update(_ellipse_cells(name, estimate.ellipse(name)))
        for place in places:
            element = _ELEMENTS[estimate.axes][place] if name != "X0" else "xy"[place[0]]
            column = f"{name}_{element}" if estimate.axes == 2 else name
            cells[f"{column}{unit}"] = value[place]
            cells[f"{column}_std{unit}"] = error[place]
            cells[f"{column}_low95{unit}"] = ends[place][0]
            cells[f"{column}_high95{unit}"] = ends[place][1]
        if estimate.axes == 1:
            cells[f"{name}_unit"] = estimate.units[name]
    return cells


def table(estimates: Iterable[Estimate]) -> pd.DataFrame:
    """Estimates as a table, a row each.

    Columns: ``participant session run posture x_m y_m bias_x_N bias_y_N set method model status reasons trials_used
    trials_rejected samples explained_share``, then each element with ``_std``, ``_low95`` and ``_high95``, its unit
    at the end of the name: ``K_xx_N_per_m``, ``K_xx_std_N_per_m``; of each ellipse ``K_size``, ``K_shape``,
    ``K_orientation_deg`` with ``_low95`` and ``_high95``. One-axis rigs have ``K``, ``K_std`` and ``K_unit``.
    """
    rows = []
    for e in estimates:
        place = e.posture_m if e.posture_m is not None else np.full(2, np.nan)
        row: dict[str, Any] = {
            "participant": e.participant, "session": e.session, "run": e.run, "posture": e.posture,
            "x_m": place[0], "y_m": place[1], "bias_x_N": e.bias[0], "bias_y_N": e.bias[1], "set": e.set,
            "method": e.method, "model": e.model, "status": e.status, "reasons": "; ".join(e.reasons),
            "trials_used": e.trials_used, "trials_rejected": len(e.trials_rejected),
            "samples": e.as_dict()["samples"], "explained_share": e.explained_share}
        row.update(_cells(e))
        rows.append(row)
    frame = pd.DataFrame(rows)
    if "set" in frame:
        frame["set"] = frame["set"].astype("Int64")
    return frame


ArrayLike = npt.ArrayLike


def _column(values: ArrayLike, name: str) -> Array:
    array = np.ascontiguousarray(values, dtype=float)
    if array.ndim == 1:
        array = array[:, np.newaxis]
    if array.ndim != 2 or array.shape[1] not in (1, 2):
        raise InvalidArgumentError(
            f"{name}: shape {np.shape(values)} is not allowed; expected (rows,), (rows, 1) or (rows, 2)")
    return array


def _as_list(values: Any) -> list[Any]:
    """A list of trials as it is; one array as a list of one."""
    is_trials = isinstance(values, (list, tuple)) and len(values) > 0 and np.ndim(values[0]) > 0 and (
        np.ndim(values[0]) == 2 or not isinstance(values[0], (list, tuple)))
    return list(values) if is_trials else [values]


def identify(force: Union[ArrayLike, Sequence[ArrayLike]], displacement: Union[ArrayLike, Sequence[ArrayLike]],
             rate: float, *, onset: Union[None, int, Sequence[int]] = None,
             commanded: Union[None, ArrayLike, Sequence[ArrayLike]] = None, method: str = "auto",
             model: str = "linear", window: float = 1.0, cutoff: float = 10.0,
             natural_frequency: Optional[float] = None, damping_ratio: float = 0.1, handle_mass: float = 0.0,
             bias: Sequence[float] = (0.0, 0.0), units: Tuple[str, str] = ("m", "N"),
             posture: str = "") -> Estimate:
    """Identifies one condition from arrays: the core of ``tonus identify``, to the last bit.

    Args:
        force: of the handle on the arm, N in S: ``(rows,)`` or ``(rows, 2)``; or a list of such, one for each trial.
            NaN where nothing was measured (continuous records only).
        displacement: of the hand, m in S, as ``force``. Its mean before the onset (of a record: its mean) is
            taken away, so that any origin will do.
        rate: samples a second, Hz.
        onset: row at which the perturbation starts; a list for a list of trials (one number: the same for all).
            None: continuous records, without onset.
        commanded: commanded displacement, as ``displacement``; None: not known.
        method: ``auto`` (state_variable for perturbations, spectral for records), ``lowpass``, ``optimal``,
            ``state_variable``, ``spectral``.
        model: ``linear``, ``no_damping``, ``coriolis``, ``squared_velocity``, ``signed_squared_velocity``.
        window: s from the onset that are fitted.
        cutoff: Hz, of the low-pass filter.
        natural_frequency: Hz, of the state-variable filter; None: from the data.
        damping_ratio: of that filter, in (0, 1].
        handle_mass: kg on the hand's side of the force sensor; its inertia is taken from the force.
        bias: force on the arm, N in S. Where it is not zero the mean force before the onset is not taken away.
        units: of displacement and force of a one-axis rig, e.g. ``("rad", "N m")``.
        posture: name, for the reader.

    Returns:
        The estimate. Trials that cannot be used are in ``trials_rejected`` with their reason.

    Raises:
        InvalidArgumentError: shapes that do not fit, a rate, setting or name that is not allowed.

    The interpreter's lock is released meanwhile.
    """
    if method == "all" or model == "all":
        raise InvalidArgumentError("identify: 'all' is not allowed; expected one method and one model")
    forces = [_column(f, "force") for f in _as_list(force)]
    displacements = [_column(x, "displacement") for x in _as_list(displacement)]
    count = len(forces)
    commands: list[Optional[Array]] = ([None] * count if commanded is None else
                                       [_column(c, "commanded") for c in _as_list(commanded)])
    onsets: list[Optional[int]] = (list(onset) if isinstance(onset, (list, tuple, np.ndarray))
                                   else [onset] * count)  # type: ignore[list-item]
    lengths = {"displacement": len(displacements), "commanded": len(commands), "onset": len(onsets)}
    for name, length in lengths.items():
        if length != count:
            raise InvalidArgumentError(f"{name}: {length} trials are not allowed; expected {count} as the force")
    axes = forces[0].shape[1]
    columns: dict[str, Sequence[Optional[Array]]] = {
        "force": forces, "displacement": displacements, "commanded": commands}
    for name, arrays in columns.items():
        for i, array in enumerate(arrays):
            if array is not None and array.shape[1] != axes:
                raise InvalidArgumentError(f"trial {i + 1}: {name} of {array.shape[1]} columns is not allowed; "
                                           f"expected {axes}")
    place = (float(bias[0]), float(bias[1]) if len(bias) > 1 else 0.0)
    trials = [(f, x, c, None if o is None else int(o))
              for f, x, c, o in zip(forces, displacements, commands, onsets)]
    found = estimates_of(_tonus.identify_arrays(
        trials, float(rate), axes, units, float(handle_mass), place, posture, method=method, model=model,
        window=window, cutoff=cutoff, natural_frequency=natural_frequency, damping_ratio=damping_ratio))
    if not found:
        raise InvalidArgumentError("force: 0 trials are not allowed; expected 1 or more")
    return found[0]
