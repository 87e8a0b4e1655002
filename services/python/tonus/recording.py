"""Recordings: BIDS Motion datasets, and simulated ones."""

from __future__ import annotations

import json
import os
import warnings
from functools import cached_property
from typing import Any, Iterator, Optional, Sequence, Tuple, Union

import numpy as np
import numpy.typing as npt
import pandas as pd

from tonus import _tonus
from tonus.errors import InvalidArgumentError, IoError, NotFoundError
from tonus.estimate import Array, Estimate, estimates_of

Path = Union[str, "os.PathLike[str]"]


class Recording:
    """One run: one posture of one session, with the perturbations in it.

    Arrays have a row for each sample and may not be written; pairs are ``(rows, axes)``. Rows without a measurement
    are NaN.
    """

    def __init__(self, native: "_tonus.Recording") -> None:
        self._native = native
        self._facts: dict[str, Any] = json.loads(native.facts())

    @cached_property
    def _arrays(self) -> dict[str, npt.NDArray[Any]]:
        return self._native.arrays()

    @property
    def time(self) -> Array:
        """s after the first row, ``(rows,)``."""
        return self._arrays["time"]

    @property
    def position(self) -> Array:
        """m, the hand from the shoulder, in S; one-axis rigs: their displacement in :attr:`displacement_unit`."""
        return self._arrays["position"]

    @cached_property
    def displacement(self) -> Array:
        """m in S, the hand from its posture; one-axis rigs, and recordings without a stated posture: as position."""
        place = self.posture_m
        return self.position if place is None or self.axes == 1 else _fixed(self.position - place)

    @property
    def force(self) -> Array:
        """N in S, of the handle on the arm; one-axis rigs: in :attr:`force_unit`."""
        return self._arrays["force"]

    @property
    def commanded(self) -> Array:
        """m in S, displacement commanded from the posture; NaN: not known."""
        return self._arrays["commanded"]

    @property
    def is_missing(self) -> npt.NDArray[np.bool_]:
        """True where nothing was measured, ``(rows,)``."""
        return self._arrays["is_missing"]

    @property
    def axes(self) -> int:
        """1 or 2."""
        return int(self.force.shape[1])

    @property
    def rate(self) -> float:
        """Samples a second, Hz."""
        return float(self._facts["rate"])

    @property
    def participant(self) -> str:
        return str(self._facts["participant"])

    @property
    def session(self) -> Optional[str]:
        session = self._facts["session"]
        return None if session is None else str(session)

    @property
    def task(self) -> str:
        return str(self._facts["task"])

    @property
    def run(self) -> int:
        return int(self._facts["run"])

    @property
    def posture(self) -> str:
        return str(self._facts["posture"])

    @property
    def posture_m(self) -> Optional[Array]:
        """The hand's place, ``(2,)``, m in S; None: not stated."""
        place = self._facts["posture_m"]
        return None if place is None else np.array(place, dtype=float)

    @property
    def displacement_unit(self) -> str:
        return str(self._facts["displacement_unit"])

    @property
    def force_unit(self) -> str:
        return str(self._facts["force_unit"])

    @property
    def handle_mass(self) -> float:
        """kg on the hand's side of the force sensor."""
        return float(self._facts["handle_mass_kg"])

    @property
    def is_force_sign_stated(self) -> bool:
        """False: a one-axis dataset does not say whose force its channel is, and +1 was taken."""
        return bool(self._facts["is_force_sign_stated"])

    @property
    def events(self) -> pd.DataFrame:
        """A row for each perturbation: ``onset_s duration_s trial set direction_deg amplitude_m rise_time_s bias_x_N
        bias_y_N is_valid reason instruction``. A continuous one has no direction."""
        frame = pd.DataFrame(self._facts["events"])
        if not frame.empty:
            bias = np.array(frame.pop("bias_N").tolist(), dtype=float)
            frame["bias_x_N"], frame["bias_y_N"] = bias[:, 0], bias[:, 1]
        return frame

    def identify(self, **settings: Any) -> list[Estimate]:
        """Identifies every condition in it. Settings: ``method`` and ``model`` (also ``all``), ``window``, ``cutoff``,
        ``natural_frequency``, ``damping_ratio``, as :func:`tonus.identify`. Raises InvalidArgumentError."""
        return estimates_of(self._native.identify(**settings))

    def __len__(self) -> int:
        return len(self.time)

    def __repr__(self) -> str:
        session = f" {self.session}" if self.session else ""
        return f"<Recording {self.participant}{session} run {self.run}: {len(self._facts['events'])} perturbations>"


def _fixed(array: Array) -> Array:
    array.setflags(write=False)
    return array


class Dataset:
    """A BIDS Motion dataset. Recordings are read when they are asked for, by index or one after the other."""

    def __init__(self, root: Path, force_sign: Optional[int] = None) -> None:
        self._native = _tonus.Dataset(os.fspath(root))
        self._force_sign = force_sign
        self._root = os.fspath(root)

    def __len__(self) -> int:
        return len(self._native)

    def __getitem__(self, index: int) -> Recording:
        place = index + len(self) if index < 0 else index
        if not 0 <= place < len(self):
            raise IndexError(f"recording {index} does not exist; the dataset has {len(self)}")
        return Recording(self._native.read(place, self._force_sign))

    def __iter__(self) -> Iterator[Recording]:
        return (self[index] for index in range(len(self)))

    def identify(self, **settings: Any) -> list[Estimate]:
        """Identifies every recording, on all processors; exactly ``tonus identify DIR``. Settings as
        :meth:`Recording.identify`. Warns of every item of the dataset that is left out, with the reason."""
        found = self._native.identify(self._force_sign, **settings)
        for item in json.loads(found).get("left_out", []):
            warnings.warn(f"left out: {item}", stacklevel=2)
        return estimates_of(found)

    def __repr__(self) -> str:
        return f"<Dataset {self._root}: {len(self)} recordings>"


def read_bids(directory: Path, force_sign: Optional[int] = None) -> Dataset:
    """Opens a BIDS Motion dataset.

    Args:
        directory: its folder.
        force_sign: +1 or -1, of a one-axis dataset that does not state whose force its channel is.

    Raises:
        NotFoundError, InvalidArgumentError: a file is missing, or its content is not allowed; the message names file,
            line and column.
    """
    return Dataset(directory, force_sign)


def _profile_text(profile: Optional[Path]) -> Tuple[str, str]:
    if profile is None:
        return "", "default profile"
    try:
        with open(profile, encoding="utf-8") as file:
            return file.read(), os.fspath(profile)
    except FileNotFoundError as error:
        raise NotFoundError(f"profile '{os.fspath(profile)}': does not exist") from error
    except (OSError, UnicodeDecodeError) as error:
        raise IoError(f"profile '{os.fspath(profile)}': {error}") from error


def simulate(profile: Optional[Path] = None, seed: int = 1, *, profile_toml: Optional[str] = None,
             posture: str = "reference", posture_m: Optional[Sequence[float]] = None, sets: int = 2) -> Recording:
    """Measures one posture of a simulated subject on the simulated rig: the realtime loop, driver, plant and subject
    of ``tonus-rig-agent --driver simulated``, in this process and as fast as it goes.

    Args:
        profile: a profile file (TOML, as ``deploy/profiles/default.toml``); None: the default rig and subject.
        seed: of all noise, 0 or more; the same profile and seed give the same bits.
        profile_toml: the profile's text instead of a file.
        posture: one of the published postures (reference, distal, proximal, right, left), or any name with
        posture_m: the hand's place, m in S.
        sets: of eight perturbations, 45 degrees apart.

    Raises:
        InvalidArgumentError: a value in the profile, a posture, or a trial that the rig refuses.
        NotFoundError, IoError: the profile cannot be read.

    The interpreter's lock is released meanwhile; a set takes about 0.1 s.
    """
    if profile is not None and profile_toml is not None:
        raise InvalidArgumentError("simulate: profile and profile_toml together are not allowed; expected one")
    if isinstance(seed, bool) or not 0 <= seed < 2**64:
        raise InvalidArgumentError(f"seed: {seed} is not allowed; expected 0 to {2**64 - 1}")
    if not 1 <= sets <= 1000:
        raise InvalidArgumentError(f"sets: {sets} is not allowed; expected 1 to 1000")
    if posture_m is None:
        places = dict(_tonus.published_postures())
        if posture not in places:
            raise InvalidArgumentError(f"posture: {posture!r} is not allowed; expected {', '.join(places)}, "
                                       "or a name with posture_m")
        place = places[posture]
    else:
        place = (float(posture_m[0]), float(posture_m[1]))
    text, source = (profile_toml, "profile_toml") if profile_toml is not None else _profile_text(profile)
    return Recording(_tonus.simulate(text, source, seed, posture, place, sets))
