"""What a topic of a recording is: its name and unit, and which ports its messages come from."""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from pydrake.systems.framework import InputPort

from drake_blfdmp.recording.mcap_file import RecorderError
from drake_blfdmp.recording.sample_block import Make
from drake_blfdmp.ros2.cdr import CdrTemplate

POSE_SIZE = 12
"""Numbers in a pose [R p] (3, 4)."""

Encode = Callable[[int, np.ndarray], bytes | None]
"""The message of a port's value at a time in ns; None where there is none to be written."""


def check_unique(what: str, names: Sequence[str]) -> None:
    """Refuse names that are empty or given twice.

    Raises:
        RecorderError: one is.
    """
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice or "" in names:
        raise RecorderError(f"recorder: {what} name '{twice[0] if twice else ''}' is empty or given twice; rename it")


class VectorTopic(NamedTuple):
    """A topic of named numbers.

    Attributes:
        name: of the topic, without its first `/`: letters, digits, `_`, and `/` between parts.
        elements: names of the numbers.
        unit: of all elements, for example "m"; "1" for pure numbers.
        single_precision: round to the seven digits of a float32, which halves what the numbers take in the file.
        size: how many numbers the port has for the topic; as many as there are elements when None.
        make: makes the elements' numbers (N, len(elements)) of N samples' numbers (N, size); None takes them as they
            are. What is looked at and not simulated with costs less so than as a system of its own: it is called for
            many samples at once.
        bodies: indices of bodies whose poses in W `make` gets, too: behind the port's numbers the rows of [R p], 12
            numbers a body. Only a recorder that records bodies knows them.
    """

    name: str
    elements: Sequence[str]
    unit: str
    single_precision: bool = False
    size: int | None = None
    make: Make | None = None
    bodies: Sequence[int] = ()


class RecordedTopic(NamedTuple):
    """A topic whose messages differ in times and numbers alone.

    Attributes:
        channel: where to.
        parts: where from: ports, and of each the places in its value of the numbers wanted, one after the other.
        template: of its messages.
        every: of how many samples one is recorded.
        single_precision: whether its numbers are rounded.
        make: what makes the template's numbers (N, m) of the parts' (N, n); None takes these.
        bodies: indices of those whose poses [R p] `make` gets behind the parts' numbers, POSE_SIZE each.
        finite: whether a sample is left out as a whole where one of the parts' numbers is not finite.
    """

    channel: int
    parts: Sequence[tuple[InputPort, np.ndarray]]
    template: CdrTemplate
    every: int = 1
    single_precision: bool = False
    make: Make | None = None
    bodies: Sequence[int] = ()
    finite: bool = False


class EncodedTopic(NamedTuple):
    """A topic whose messages are made one by one.

    Attributes:
        channel, port: where to and where from.
        encode: makes them.
        every: of how many samples one is recorded.
    """

    channel: int
    port: InputPort
    encode: Encode
    every: int


class PoseSource(NamedTuple):
    """Where bodies' poses come from.

    Attributes:
        port: MultibodyPlant's `body_poses`, or a port of numbers from which `make` makes them.
        make: of bodies, by their indices, what makes their poses [R p] (N, POSE_SIZE B) of the port's numbers; None
            where the port is `body_poses`.
    """

    port: InputPort
    make: Callable[[Sequence[int]], Make] | None = None
