"""What can go wrong. Every error of this package is an :class:`Error` whose text is one line for a person:
what it is about, its value, and what is allowed or what to do."""

from __future__ import annotations

import builtins


class Error(Exception):
    """Base class of all errors of this package."""


class InvalidArgumentError(Error, ValueError):
    """A value is not allowed; the message names it and the limits."""


class NotFoundError(Error, LookupError):
    """A named file, trial, session or recording does not exist."""


class AlreadyExistsError(Error):
    """Something that must be unique already exists."""


class TimeoutError(Error, builtins.TimeoutError):  # noqa: A001
    """Something was not done within its time; it may be tried again."""


class UnavailableError(Error, ConnectionError):
    """A server, a store or a peer is not there now, or has gone."""


class DataLossError(Error):
    """Data are damaged or missing."""


class IoError(Error, OSError):
    """The operating system refused a read, a write or a connection."""


class InternalError(Error):
    """A fault of this package."""
