"""Live sessions: what the gateway (``tonus up --dashboard``) tells, in JSON."""

from __future__ import annotations

import asyncio
import importlib
import json
import threading
from dataclasses import dataclass
from typing import Any, AsyncIterator, Coroutine, Iterator, Optional, Sequence, TypeVar
from urllib.parse import quote, urlsplit, urlunsplit

from tonus.errors import InvalidArgumentError, TimeoutError, UnavailableError
from tonus.estimate import Estimate

TOPICS = ("estimate/condition", "trial/verdict", "session/state", "rig/state")
"""What is told where nothing else is asked for."""

_T = TypeVar("_T")

websockets: Any = importlib.import_module("websockets")  # its names come when they are used: no types of them


@dataclass(frozen=True)
class Message:
    """One message.

    Attributes:
        topic: of the bus, e.g. ``trial/verdict``.
        time_ns: when it was written, ns of UTC.
        data: its fields, by the names of the contract (``services/dashboard/openapi.json``).
    """

    topic: str
    time_ns: int
    data: dict[str, Any]

    @property
    def estimate(self) -> Optional[Estimate]:
        """Of ``estimate/condition`` and ``estimate/live``; None: another topic."""
        return Estimate(self.data) if self.topic.startswith("estimate/") else None


def _address(url: str, topics: Optional[Sequence[str]]) -> str:
    """The gateway's WebSocket of these topics."""
    parts = urlsplit(url if "://" in url else f"http://{url}")
    schemes = {"http": "ws", "ws": "ws", "https": "wss", "wss": "wss"}
    if parts.scheme not in schemes or not parts.netloc:
        raise InvalidArgumentError(f"url: {url!r} is not allowed; expected http://HOST:PORT, https:, ws: or wss:")
    query = "topics=" + quote(",".join(topics if topics is not None else TOPICS), safe="/,")
    return urlunsplit((schemes[parts.scheme], parts.netloc, "/json", query, ""))


def _message(text: Any) -> Message:
    found = json.loads(text)
    if "error" in found:
        raise UnavailableError(f"gateway: {found['error']}")
    return Message(found["topic"], found["time_ns"], found["message"])


class Subscription:
    """Messages as they come, to be taken by ``for`` or ``async for``, one of both. Close it, or use ``with``.

    What the gateway has is never skipped, but for ``estimate/live``: who takes too slowly is disconnected in the end,
    with an UnavailableError that says so.
    """

    def __init__(self, url: str, topics: Optional[Sequence[str]], token: Optional[str],
                 timeout: Optional[float]) -> None:
        self._url = _address(url, topics)
        self._place = url
        self._token = token
        self._timeout = timeout
        self._socket: Any = None
        self._loop: Optional[asyncio.AbstractEventLoop] = None
        self._thread: Optional[threading.Thread] = None
        self._closed = False

    async def _connect(self) -> Any:
        headers = {} if self._token is None else {"Authorization": f"Bearer {self._token}"}
        try:
            return await websockets.connect(self._url, extra_headers=headers, max_size=16 << 20, open_timeout=10.0,
                                            close_timeout=2.0)
        except websockets.InvalidStatusCode as error:
            reasons = {400: "a topic does not exist", 401: "a token is needed, or it is a wrong one",
                       403: "this host or origin is not admitted", 503: "too many are connected"}
            raise UnavailableError(f"gateway {self._place}: answered {error.status_code}: "
                                   f"{reasons.get(error.status_code, 'is it a gateway?')}") from error
        except (OSError, websockets.WebSocketException, asyncio.TimeoutError) as error:
            raise UnavailableError(f"gateway {self._place}: cannot be reached ({error}); is `tonus up --dashboard` "
                                   "running?") from error

    async def _next(self) -> Optional[Message]:
        """The next message; None: there will be none."""
        if self._closed:
            return None
        if self._socket is None:
            self._socket = await self._connect()
        try:
            return _message(await asyncio.wait_for(self._socket.recv(), self._timeout))
        except asyncio.TimeoutError as error:
            raise TimeoutError(f"gateway {self._place}: nothing came within {self._timeout} s") from error
        except websockets.ConnectionClosed as error:
            if self._closed:
                return None
            end = error.rcvd
            why = f"{end.code} {end.reason}".strip() if end is not None else "it may have been stopped"
            raise UnavailableError(f"gateway {self._place}: ended the connection: {why}") from error

    async def _close(self) -> None:
        if self._socket is not None:
            await self._socket.close()

    def _run(self, work: Coroutine[Any, Any, _T]) -> _T:
        """In a loop of its own thread, so that it also works inside of another loop (a notebook's)."""
        if self._loop is None:
            self._loop = asyncio.new_event_loop()
            self._thread = threading.Thread(target=self._loop.run_forever, name="tonus-subscription", daemon=True)
            self._thread.start()
        return asyncio.run_coroutine_threadsafe(work, self._loop).result()

    def __iter__(self) -> Iterator[Message]:
        return self

    def __next__(self) -> Message:
        if self._closed:
            raise StopIteration
        try:
            message = self._run(self._next())
        except UnavailableError:
            self.close()
            raise
        if message is None:
            self.close()
            raise StopIteration
        return message

    def __aiter__(self) -> AsyncIterator[Message]:
        return self

    async def __anext__(self) -> Message:
        message = await self._next()
        if message is None:
            await self.aclose()
            raise StopAsyncIteration
        return message

    def close(self) -> None:
        """Ends it. Harmless when repeated."""
        if self._closed:
            return
        self._closed = True
        if self._loop is None:
            return
        self._run(self._close())
        self._loop.call_soon_threadsafe(self._loop.stop)
        assert self._thread is not None
        self._thread.join()
        self._loop.close()

    async def aclose(self) -> None:
        """Ends it, in the loop that it was used in."""
        self._closed = True
        await self._close()

    def __enter__(self) -> "Subscription":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    async def __aenter__(self) -> "Subscription":
        return self

    async def __aexit__(self, *_: object) -> None:
        await self.aclose()


def subscribe(url: str = "http://127.0.0.1:8765", topics: Optional[Sequence[str]] = None, *,
              token: Optional[str] = None, timeout: Optional[float] = None) -> Subscription:
    """Live states, verdicts and estimates from a gateway: first the newest of each, then what comes.

        for message in tonus.subscribe("http://127.0.0.1:8765"):
            if message.estimate:
                print(message.estimate.K)

    or ``async for`` in a coroutine. It goes on until it is closed; the end of the gateway is an UnavailableError.

    Args:
        url: of the gateway, as it prints it.
        topics: of ``estimate/condition estimate/live trial/verdict trial/outcome session/plan session/state rig/state``;
            None: :data:`tonus.live.TOPICS`.
        token: of the gateway's tokens file, where it wants one. It is sent as a header, not in the address.
        timeout: s to wait for each message; None: for ever.

    Raises:
        InvalidArgumentError: an address of another kind. UnavailableError: nobody answers, the gateway refuses, or the
        connection is lost. TimeoutError: nothing came in time; the subscription can be used further.
    """
    return Subscription(url, topics, token, timeout)
