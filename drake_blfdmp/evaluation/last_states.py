"""What is kept of a simulation that had to stop: the recording up to then, with the last finite states."""

import json
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager

from drake_blfdmp.errors import NonFiniteError, SimulationError
from drake_blfdmp.recording.mcap_recorder import McapRecorder

LAST_STATES = "last_states.json"


@contextmanager
def LastStatesKept(recorders: Sequence[McapRecorder], attachments: Mapping[str, str]) -> Iterator[None]:
    """Complete the recordings where the simulation inside stops by a SimulationError, and name them in its line.

    A recording then also holds the attachments, and where a number was not finite an event `non_finite` with system
    and port, and the attachment `last_states.json`: the time and every system's last finite state. It is closed.

    Args:
        recorders: may be filled inside.
        attachments: name -> text, what one needs to run it again.
    """
    try:
        yield
    except SimulationError as error:
        for recorder in recorders:
            _complete(recorder, attachments, error)
        if recorders:
            paths = ", ".join(str(recorder.path) for recorder in recorders)
            error.args = (f"{error}; the states up to then are in {paths}",)
        raise


def _complete(recorder: McapRecorder, attachments: Mapping[str, str], error: SimulationError) -> None:
    for name, text in attachments.items():
        recorder.AddAttachment(name, text)
    if isinstance(error, NonFiniteError):
        recorder.Event(f"non_finite {error.system} {error.port}".rstrip(), error.time)
        document = {
            "time_s": error.time,
            "not_finite": {"system": error.system, "port": error.port},
            "states": error.states,
        }
        recorder.AddAttachment(LAST_STATES, json.dumps(document, indent=1) + "\n", "application/json")
    recorder.Close()
