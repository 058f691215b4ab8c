"""Every figure of one run, from its log and nothing else."""

from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from drake_blfdmp.errors import BlfDmpError, RecordingError
from drake_blfdmp.recording.run_log import RunLog
from drake_blfdmp.viewing import robot_figures, skill_figures, style

FIGURES: Mapping[str, Callable[[RunLog], Figure]] = {
    "link_lengths": skill_figures.link_lengths,
    "hands_distance": skill_figures.hands_distance,
    "paths": skill_figures.paths,
    "joint_angles": robot_figures.joint_angles,
    "contact_forces": robot_figures.contact_forces,
    "box_height_tilt": robot_figures.box_height_tilt,
    "swivel": robot_figures.swivel,
    "feedback": robot_figures.feedback,
}
"""File name without its ending -> the function that makes the figure."""

OF_THE_BOX = ("contact_forces", "box_height_tilt")
"""Those of `FIGURES` that a motion without a box has not."""

SPREAD = "spread"
"""The figure, and its file's name, of a skill that was learned from several recordings."""

_SAMPLED = {  # Shape of one sample of each signal the figures show.
    "tempo": (),
    "hands": (),
    "palm": (2, 7),
    "palm_desired": (2, 7),
    "position": (6, 3),
    "uncoupled": (6, 3),
    "demonstrated": (6, 3),
    "lower": (5,),
    "upper": (5,),
    "desired": (5,),
    "q": (14,),
    "q_desired": (14,),
    "palm_force": (2,),
    "swivel": (2,),
    "swivel_desired": (2,),
}
_NOT_ALWAYS = {"box": (7,), "box_desired": (7,), "spread": (6, 3)}  # None where the run has none.


def write_figures(log: RunLog, directory: Path) -> list[Path]:
    """Writes all `FIGURES` of a run as PNG files, but what it has no signals for; the same log gives the same bytes.

    Args:
        log: the run; where its skill was learned from several recordings, their spread is drawn, too.
        directory: where to write; made when it does not exist.

    Returns: the files' paths, in the order of `FIGURES`, then that of `SPREAD`.

    Raises:
        RecordingError: a signal of the log has not the shape `RunLog` states.
        BlfDmpError: the directory cannot be written to.
    """
    check_log(log)
    try:
        directory.mkdir(parents=True, exist_ok=True)
        left_out = OF_THE_BOX if log.box is None else ()
        makers = {name: make for name, make in FIGURES.items() if name not in left_out}
        if (spread := log.spread) is not None:
            makers[SPREAD] = lambda log: skill_figures.spread(log, spread)
        # One after the other: of a long run each takes tens of megabytes.
        return [style.save(make(log), directory / f"{name}.png") for name, make in makers.items()]
    except OSError as error:
        raise BlfDmpError(
            f"figures cannot be written to {directory}: {error.strerror or error}; name another directory"
        ) from error


def check_log(log: RunLog) -> None:
    """Raises RecordingError, naming the signal, when `log` cannot be drawn."""
    t = np.asarray(log.t)
    if t.ndim != 1 or len(t) < 2 or not np.all(np.diff(t) > 0):
        raise RecordingError(f"run log: t must be 2 or more growing times in s, not an array of {t.shape}; rerun")
    present = {name: shape for name, shape in _NOT_ALWAYS.items() if getattr(log, name) is not None}
    for name, shape in (_SAMPLED | present).items():
        found = np.shape(getattr(log, name))
        if found != (len(t), *shape):
            raise RecordingError(f"run log: {name} has shape {found}, expected {(len(t), *shape)}; rerun")
    for name in ("q_lower", "q_upper"):
        if np.shape(getattr(log, name)) != (14,):
            raise RecordingError(f"run log: {name} has shape {np.shape(getattr(log, name))}, expected (14,); rerun")
