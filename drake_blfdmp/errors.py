"""Exceptions that a user's input can cause; each carries one line: what is wrong, where, and what to do."""

from typing import Literal

Reason = Literal["reach", "force", "clearance", "input"]
"""Why something is refused: the arms cannot get there, cannot press so hard, would touch what they must not; or the
input itself is wrong."""


class BlfDmpError(Exception):
    """Base of everything that bad input can raise; `run.py` prints it as one line and exits with `exit_status`.

    Attributes:
        reason: the class of the refusal.
    """

    exit_status = 2
    reason: Reason = "input"


class RecordingError(BlfDmpError):
    """A recording cannot be read, or no two-handed skill can be learned from it."""


class SkillError(BlfDmpError):
    """A skill cannot be learned, loaded or rolled out with the given numbers."""


class ScenarioError(BlfDmpError):
    """A scenario holds an unknown key or a value out of range."""


class TaskError(BlfDmpError):
    """The task cannot be carried out by the arms: reach, force or clearance."""

    def __init__(self, message: str, *, reason: Reason = "input"):
        """Of a message in one line and the class of the refusal."""
        super().__init__(message)
        self.reason = reason

    def __reduce__(self):
        """Pickled with its reason, as errors come back from worker processes."""
        return _task_error, (type(self), str(self), self.reason)


def _task_error(kind: type[TaskError], message: str, reason: Reason) -> TaskError:
    return kind(message, reason=reason)


class SimulationError(BlfDmpError):
    """A simulation that had begun cannot go on: a run without success, not bad input."""

    exit_status = 1


class NonFiniteError(SimulationError):
    """A number in a simulation is not finite.

    Attributes:
        system, port: where it stood first, in the direction of the data; names, `a::b` for b inside a.
        time: s, of the last state that was finite.
        states: that state: system -> its continuous and discrete state vectors, as lists.
    """

    def __init__(
        self, message: str, *, system: str = "", port: str = "", time: float = 0.0, states: dict | None = None
    ):
        super().__init__(message)
        self.system, self.port, self.time, self.states = system, port, time, states or {}
