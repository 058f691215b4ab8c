"""From the numbers in a file to metres, seconds and one person, each with its evidence."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from drake_blfdmp.demonstration.clock import SECONDS, find_clock
from drake_blfdmp.demonstration.demonstration import Recording
from drake_blfdmp.demonstration.formats.recording_format import Joints
from drake_blfdmp.demonstration.length_unit import METRES, find_length_unit
from drake_blfdmp.demonstration.orientation_cleaning import describe_orientations, turning_orientations
from drake_blfdmp.demonstration.people import choose_person
from drake_blfdmp.demonstration.raw_recording import RawRecording
from drake_blfdmp.errors import RecordingError

_LARGEST = 1e7  # In any unit: 10 km in millimetres; beyond it a number is no position.


@dataclass(frozen=True)
class ReadOptions:
    """What the person who reads a file knows better than the reader.

    Attributes:
        frames: first and last of the file's own frame numbers, both included; None reads all.
        joints: point of `skeleton.POINTS` (or "time") -> the file's name for it, or three column names.
        unit: "m", "cm" or "mm"; None finds it.
        time_unit: "s", "ms", "us", "100ns", "ns" or "frames"; None finds it.
        rate_hz: frames a second; counts frames instead of reading a clock.
        body: the person's id in the file; None takes the one who moves both hands most.
    """

    frames: tuple[int, int] | None = None
    joints: Joints | None = None
    unit: str | None = None
    time_unit: str | None = None
    rate_hz: float | None = None
    body: str | None = None


def check_options(path: Path, options: ReadOptions) -> None:
    """Refuse what no file can be read with.

    Raises:
        RecordingError: an unknown unit, or a rate that is none.
    """
    if options.unit is not None and options.unit not in METRES:
        raise RecordingError(f"{path}: unknown unit '{options.unit}'; give one of {', '.join(METRES)}")
    if options.time_unit is not None and options.time_unit not in (*SECONDS, "frames"):
        known = ", ".join((*SECONDS, "frames"))
        raise RecordingError(f"{path}: unknown unit of time '{options.time_unit}'; give one of {known}")
    if options.rate_hz is not None and not 0.0 < options.rate_hz < np.inf:
        raise RecordingError(f"{path}: a rate of {options.rate_hz:g} frames a second; give a positive number")


def interpret(path: Path, format_name: str, raw: RawRecording, options: ReadOptions) -> Recording:
    """One person of a file in metres and seconds.

    Raises:
        RecordingError: nobody, nobody of that id, no samples, none in the range of frames, times that are no numbers,
            or units that change.
    """
    check_options(path, options)
    where = str(path)
    person = choose_person(where, raw.bodies, options.body)
    body = person.body
    frames, t, confidence = np.asarray(body.frames), body.t, body.confidence
    orientations = None if body.orientations is None else turning_orientations(body.orientations)
    x = np.asarray(body.x, float)
    if len(x) == 0:
        raise RecordingError(f"{where}: holds a header but no samples; export the recording again")
    if t is not None and not np.isfinite(t).all():
        raise RecordingError(
            f"{where}: frame {frames[int(np.argmin(np.isfinite(t)))]} has no time; repair or remove it"
        )
    # The clock and the units are found from the whole file, so that a range of frames does not change them.
    clock = find_clock(
        t,
        frames,
        stated_unit=raw.time_unit,
        stated_hz=raw.clock_hz,
        time_unit=options.time_unit,
        rate_hz=options.rate_hz,
    )
    seconds = clock.t
    lost = ~(np.abs(x) <= _LARGEST)  # True for NaN, too.
    absurd = int((lost & ~np.isnan(x)).sum())
    x = np.where(lost, np.nan, x)
    if options.frames is not None:
        first, last = options.frames
        keep = (frames >= first) & (frames <= last)
        if not keep.any():
            raise RecordingError(
                f"{where}: no frame lies in {first}:{last}; the file has frames {frames.min()} to {frames.max()}"
            )
        seconds, x, frames = seconds[keep], x[keep], frames[keep]
        confidence = None if confidence is None else confidence[keep]
        orientations = None if orientations is None else orientations[keep]
    length = find_length_unit(where, x, frames, stated=raw.unit, given=options.unit)
    evidence = [
        "synthetic: the file says that no person was recorded" if raw.synthetic else "",
        length.evidence,
        clock.evidence,
        person.evidence,
        *raw.notes,
        describe_orientations(orientations),
    ]
    if raw.empty_frames:
        evidence.append(f"{raw.empty_frames} frames hold no person")
    if absurd:
        evidence.append(f"{absurd} numbers are infinite or too large to be positions and count as missing")
    return Recording(
        t=seconds,
        x=x * METRES[length.unit],
        source=where,
        format=format_name,
        frames=frames,
        synthetic=raw.synthetic,
        confidence=confidence,
        orientations=orientations,
        up=raw.up,
        evidence=tuple(sentence for sentence in evidence if sentence),
    )
