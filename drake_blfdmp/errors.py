"""Exceptions that a user's input can cause; each carries one line: what is wrong, where, and what to do."""


class BlfDmpError(Exception):
    """Base of everything that bad input can raise; `run.py` prints it as one line and exits with status 2."""


class RecordingError(BlfDmpError):
    """A recording cannot be read, or no two-handed skill can be learned from it."""


class SkillError(BlfDmpError):
    """A skill cannot be learned, loaded or rolled out with the given numbers."""


class ScenarioError(BlfDmpError):
    """A scenario holds an unknown key or a value out of range."""


class TaskError(BlfDmpError):
    """The task cannot be carried out by the arms: reach, force or clearance."""
