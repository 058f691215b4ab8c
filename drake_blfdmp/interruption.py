"""Ctrl-C, SIGTERM and SIGHUP, none of which is lost.

Python raises at a signal wherever the main thread is. While pybind11 converts arguments, it clears that exception:
what comes out instead is a TypeError of "incompatible arguments", or nothing at all. So what came is noted here; see
`check`.
"""

import signal
from types import FrameType

_received: list[int] = []


class Terminated(KeyboardInterrupt):
    """SIGTERM or SIGHUP came: everything is closed as after Ctrl-C."""


def listen() -> None:
    """From now on the three signals raise KeyboardInterrupt and are noted; what is ignored (nohup) stays so."""
    for name in ("SIGINT", "SIGTERM", "SIGHUP"):
        number = getattr(signal, name, None)
        if number is not None and signal.getsignal(number) in (signal.SIG_DFL, signal.default_int_handler):
            signal.signal(number, _note)


def received() -> int | None:
    """The number of the signal that came last, None of none."""
    return _received[-1] if _received else None


def check() -> None:
    """Raise again what came and was cleared.

    Raises:
        KeyboardInterrupt: a signal came.
    """
    if _received:
        _raise(_received[-1])


def told(number: int) -> str:
    """What a command says that a signal has ended."""
    return "interrupted" if number == signal.SIGINT else f"terminated by {signal.Signals(number).name}"


def _note(number: int, frame: FrameType | None) -> None:
    _received.append(number)
    _raise(number)


def _raise(number: int) -> None:
    raise KeyboardInterrupt if number == signal.SIGINT else Terminated(number)
