"""Archives of a running or a finished system, read only: nothing that happens here can alter or hold up one."""

from __future__ import annotations

import json
import os
from functools import cached_property
from typing import Any, Iterator, Optional, Sequence, Union

import numpy as np
import numpy.typing as npt
import pandas as pd

from tonus import _tonus
from tonus.errors import NotFoundError
from tonus.estimate import Array, Estimate, estimates_of, table

Path = Union[str, "os.PathLike[str]"]


class Samples:
    """All rows of a session's trials, one trial after the other.

    Attributes:
        time: s from the onset of each trial's perturbation, ``(rows,)``.
        position: m, the hand from the shoulder, in S, ``(rows, axes)``; one-axis rigs: their displacement and unit.
        force: N in S, of the handle on the arm, ``(rows, axes)``.
        commanded: m in S, displacement commanded from the posture, ``(rows, axes)``.
        phase: part of the trial, ``(rows,)``: 0 idle, 1 centring, 2 waiting, 3 bias ramp, 4 bias hold, 5 perturbing,
            6 returning, 7 safe.
        is_missing: True where nothing was measured; the row's numbers are NaN.

    Nothing may be written, and the arrays of the trials are views of these.
    """

    def __init__(self, arrays: dict[str, npt.NDArray[Any]], places: Sequence[tuple[int, int, int]]) -> None:
        self.time: Array = arrays["time"]
        self.position: Array = arrays["position"]
        self.force: Array = arrays["force"]
        self.commanded: Array = arrays["commanded"]
        self.phase: npt.NDArray[np.uint8] = arrays["phase"]
        self.is_missing: npt.NDArray[np.bool_] = arrays["is_missing"]
        self._places = places

    def __len__(self) -> int:
        return len(self.time)

    @property
    def bounds(self) -> npt.NDArray[np.int64]:
        """First row and row after the last of each trial, ``(trials, 2)``."""
        places = np.array(self._places, dtype=np.int64).reshape(-1, 3)
        return np.stack([places[:, 0], places[:, 0] + places[:, 1]], axis=1)


class Trial:
    """One attempt at a planned trial. Its arrays are read when one of them is first asked for."""

    def __init__(self, session: "Session", index: int, facts: dict[str, Any]) -> None:
        self._session = session
        self._index = index
        self._facts = facts

    def _of_program(self, name: str, otherwise: Any = None) -> Any:
        program = self._facts["program"]
        return otherwise if program is None else program[name]

    @property
    def attempt(self) -> int:
        """1, 2, ... in the session."""
        return int(self._facts["attempt"])

    @property
    def id(self) -> str:
        return str(self._facts["trial_id"])

    @property
    def posture(self) -> str:
        return str(self._of_program("posture", ""))

    @property
    def posture_m(self) -> Array:
        """The hand's place, ``(2,)``, m in S."""
        return np.array(self._of_program("posture_m", [np.nan, np.nan]), dtype=float)

    @property
    def set(self) -> int:
        return int(self._of_program("set_number", 0))

    @property
    def direction_deg(self) -> float:
        """Of the perturbation, counter-clockwise from S's x axis."""
        return float(self._of_program("direction_deg", np.nan))

    @property
    def amplitude(self) -> float:
        """Of the commanded displacement, m."""
        return float(self._of_program("amplitude_m", np.nan))

    @property
    def bias(self) -> Array:
        """Bias force on the arm, ``(2,)``, N in S."""
        return np.array(self._of_program("bias_N", [np.nan, np.nan]), dtype=float)

    @property
    def instruction(self) -> str:
        return str(self._of_program("instruction", ""))

    @property
    def end(self) -> Optional[str]:
        """How the rig ended it (``completed``, ``aborted``, ``faulted``, ...); None: it runs."""
        outcome = self._facts["outcome"]
        return None if outcome is None else str(outcome["end"])

    @property
    def is_valid(self) -> Optional[bool]:
        """The verdict, an operator's rejection by hand included; None: there is none yet."""
        verdict = self._facts["verdict"]
        return None if verdict is None else bool(verdict["is_valid"])

    @property
    def reason(self) -> str:
        """Why it does not count, one line; empty: it counts."""
        return str(self._facts["why_not_counted"])

    @property
    def verdict(self) -> Optional[dict[str, Any]]:
        """Everything that the verdict says, an operator's rejection by hand included, by the names of the contract."""
        return self._facts["verdict"]  # type: ignore[no-any-return]

    @property
    def review(self) -> Optional[dict[str, Any]]:
        """An operator's word after the verdict (``is_rejected``, ``reason``, ``reviewed_by``, ...); None: there is none."""
        return self._facts["review"]  # type: ignore[no-any-return]

    @property
    def rate(self) -> float:
        """Samples a second, Hz; NaN while it runs."""
        outcome = self._facts["outcome"]
        return float("nan") if outcome is None else float(outcome["sample_rate_Hz"])

    @cached_property
    def _samples(self) -> tuple[Samples, int, int, int]:
        samples, (first, rows, onset) = self._session._read_trial(self._index)
        return samples, first, rows, onset

    @property
    def onset(self) -> Optional[int]:
        """Row at which the perturbation starts; None: the trial has no rows."""
        onset = self._samples[3]
        return None if onset < 0 else onset

    def _column(self, name: str) -> npt.NDArray[Any]:
        samples, first, rows, _ = self._samples
        return getattr(samples, name)[first:first + rows]  # type: ignore[no-any-return]

    @property
    def time(self) -> Array:
        """s from the onset of the perturbation, ``(rows,)``."""
        return self._column("time")

    @property
    def position(self) -> Array:
        """m, the hand from the shoulder, in S, ``(rows, axes)``; one-axis rigs: their displacement and unit."""
        return self._column("position")

    @cached_property
    def displacement(self) -> Array:
        """m in S, the hand from the posture, ``(rows, axes)``; one-axis rigs: as position."""
        position = self.position
        if position.shape[1] == 1:
            return position
        displacement: Array = position - self.posture_m
        displacement.setflags(write=False)
        return displacement

    @property
    def force(self) -> Array:
        """N in S, of the handle on the arm, ``(rows, axes)``; one-axis rigs: in their unit."""
        return self._column("force")

    @property
    def commanded(self) -> Array:
        """m in S, displacement commanded from the posture, ``(rows, axes)``."""
        return self._column("commanded")

    @property
    def phase(self) -> npt.NDArray[np.uint8]:
        """Part of the trial, ``(rows,)``; see :class:`Samples`."""
        return self._column("phase")

    @property
    def is_missing(self) -> npt.NDArray[np.bool_]:
        """True where nothing was measured, ``(rows,)``."""
        return self._column("is_missing")

    def __len__(self) -> int:
        return int(self._facts["rows"])

    def __repr__(self) -> str:
        verdict = "no verdict" if self.is_valid is None else "valid" if self.is_valid else self.reason
        return f"<Trial {self.attempt} {self.posture}: {len(self)} rows; {verdict}>"


class Session:
    """A session as it was when it was first looked at; :meth:`refresh` looks again."""

    def __init__(self, archive: "Archive", record: dict[str, Any]) -> None:
        self._archive = archive
        self._record = record

    @cached_property
    def _native(self) -> "_tonus.Session":
        return self._archive._native.session(self.id)

    @cached_property
    def _facts(self) -> dict[str, Any]:
        return json.loads(self._native.facts())  # type: ignore[no-any-return]

    @property
    def id(self) -> str:
        """32 hexadecimal digits."""
        return str(self._record["id"])

    @property
    def subject(self) -> str:
        return str(self._record["subject"])

    @property
    def protocol(self) -> str:
        return str(self._record["protocol_name"])

    @property
    def protocol_toml(self) -> str:
        """The whole text."""
        return str(self._facts["plan"]["protocol_toml"])

    @property
    def started_at(self) -> pd.Timestamp:
        """UTC."""
        return pd.Timestamp(self._record["started_at"])

    @property
    def seed(self) -> int:
        return int(self._record["seed"])

    @property
    def planned_trials(self) -> int:
        return int(self._record["planned_trials"])

    @property
    def software_version(self) -> str:
        return str(self._record["software_version"])

    @property
    def state(self) -> Optional[dict[str, Any]]:
        """The scheduler's newest report, by the names of the contract (``phase``, ``counted``, ``rejected``, ...)."""
        return self._facts["state"]  # type: ignore[no-any-return]

    @property
    def is_whole(self) -> bool:
        """True where the archive proves that it has every sample of every trial."""
        return bool(self._facts["is_whole"])

    @property
    def subject_facts(self) -> dict[str, Any]:
        """What is known of the subject (``age_years``, ``sex``, ``handedness``, ``measured_arm``, ``height_m``, ...)."""
        return self._facts["plan"]["subject_facts"]  # type: ignore[no-any-return]

    @property
    def operator(self) -> str:
        """Who ran the session; empty: not known."""
        return str(self._facts["plan"]["operator_name"])

    @property
    def study(self) -> str:
        """The study that the session belongs to; empty: none."""
        return str(self._facts["plan"]["study"])

    @property
    def is_pilot(self) -> bool:
        """True for a rehearsal, which is no part of a study's results."""
        return bool(self._facts["plan"]["is_pilot"])

    @property
    def notes(self) -> list[dict[str, Any]]:
        """Notes and markers in the order of their writing (``kind``, ``text``, ``written_by``, ``rig_clock_ns``, ...)."""
        return self._facts["notes"]  # type: ignore[no-any-return]

    @property
    def displacement_unit(self) -> str:
        return str(self._facts["displacement_unit"])

    @property
    def force_unit(self) -> str:
        return str(self._facts["force_unit"])

    @cached_property
    def trials(self) -> list[Trial]:
        """Every attempt, in order."""
        return [Trial(self, i, facts) for i, facts in enumerate(json.loads(self._native.trials()))]

    @property
    def trials_table(self) -> pd.DataFrame:
        """A row for each attempt: ``attempt posture x_m y_m set direction_deg amplitude_m bias_x_N bias_y_N instruction
        end is_valid reason rows``."""
        return pd.DataFrame([{
            "attempt": t.attempt, "posture": t.posture, "x_m": t.posture_m[0], "y_m": t.posture_m[1], "set": t.set,
            "direction_deg": t.direction_deg, "amplitude_m": t.amplitude, "bias_x_N": t.bias[0],
            "bias_y_N": t.bias[1], "instruction": t.instruction, "end": t.end, "is_valid": t.is_valid,
            "reason": t.reason, "rows": len(t)} for t in self.trials])

    @cached_property
    def samples(self) -> Samples:
        """All rows of all trials, read at once: the fastest way to a session's data."""
        return Samples(*self._native.read(list(range(len(self.trials)))))

    def _read_trial(self, index: int) -> tuple[Samples, tuple[int, int, int]]:
        if "samples" in self.__dict__:
            return self.samples, self.samples._places[index]
        arrays, places = self._native.read([index])
        return Samples(arrays, places), places[0]

    @property
    def published(self) -> list[Estimate]:
        """The newest estimate of each condition and method that the services published."""
        return estimates_of(self._native.published())

    @property
    def estimates(self) -> pd.DataFrame:
        """:attr:`published` as a table; columns: :func:`tonus.table`."""
        return table(self.published)

    def identify(self, **settings: Any) -> list[Estimate]:
        """Identifies the session anew from its raw samples, as ``tonus identify ARCHIVE --session ID``: with the
        settings of the services the same numbers as :attr:`published`, to the last bit. Settings as
        :meth:`Recording.identify`. Trials that do not count are left out with their reason."""
        return estimates_of(self._native.identify(**settings))

    def refresh(self) -> "Session":
        """The session as it is now; of a session that runs there may be more."""
        return Session(self._archive, self._record)

    def __repr__(self) -> str:
        return f"<Session {self.id[:8]} {self.subject}, {self.protocol}, {self._record['started_at']}>"


class Archive:
    """What :func:`tonus.open` gives."""

    def __init__(self, name: str) -> None:
        self._name = name
        self._native = _tonus.Archive(name)

    @property
    def sessions(self) -> list[Session]:
        """By start. Asked anew each time."""
        return [Session(self, record) for record in json.loads(self._native.sessions())]

    def session(self, wanted: str = "last") -> Session:
        """By its id or the beginning of it; ``last``: the one that began last. Raises NotFoundError."""
        sessions = self.sessions
        if wanted == "last" and sessions:
            return sessions[-1]
        matches = [s for s in sessions if s.id.startswith(wanted.replace("-", "").lower())] if wanted else []
        if len(matches) == 1:
            return matches[0]
        self._native.session(wanted)  # raises, with the sessions to choose from
        raise NotFoundError(f"session {wanted!r}: does not exist")

    @property
    def estimates(self) -> pd.DataFrame:
        """The published estimates of all sessions as one table; columns: :func:`tonus.table`."""
        return table(e for session in self.sessions for e in session.published)

    def __iter__(self) -> Iterator[Session]:
        return iter(self.sessions)

    def __len__(self) -> int:
        return len(self.sessions)

    def __repr__(self) -> str:
        return f"<Archive {self._name}: {len(self)} sessions>"


def open(archive: Path) -> Archive:  # noqa: A001
    """Opens an archive to read.

    Args:
        archive: ``archive.sqlite``, the data folder that it is in, or ``postgresql://USER@HOST/DATABASE``. A system may
            write it meanwhile.

    Raises:
        NotFoundError: there is none. InvalidArgumentError: another program's file, or a newer one. UnavailableError:
        the server does not answer. DataLossError: it is damaged. IoError: no permission.
    """
    name = os.fspath(archive)
    if "://" not in name and os.path.isdir(name):
        name = _tonus.default_store(name)
    return Archive(name)
