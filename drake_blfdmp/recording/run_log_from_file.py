"""A run's log from its recording alone, as it was or evenly thinned, in bounded memory. Without pydrake."""

import struct
from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np

from drake_blfdmp.recording.mcap_file import RecorderError
from drake_blfdmp.recording.planned_signals import ATTACHMENT, MEASURED, PlannedSignals, read_measured, read_planned
from drake_blfdmp.recording.run_log import RunLog
from drake_blfdmp.recording.sample_table import MOST_SAMPLES, SampleTable
from drake_blfdmp.recording.samples import Decoder, Sample, text_of
from drake_blfdmp.recording.stream import McapStream, Topic
from drake_blfdmp.ros2.messages import JOINT_STATE, LOG, TF
from drake_blfdmp.skeleton import LINKS
from drake_blfdmp.skill.canonical import time_at

RECORD = "run"
"""The metadata record that makes a recording a run's."""

_JOINTS, _LINKS = 14, len(LINKS)
_SIZES = {  # Topic -> how many numbers of it are kept; the poses of /tf are counted at their link.
    "/joint_states": 3 * _JOINTS,
    "/phase": 1,
    "/points": 18,
    "/link_lengths": 3 * _LINKS,
    "/barrier": _LINKS,
    "/desired_position": _JOINTS,
    "/hands": 1,
    "/planned_palms": 14,
}
_NOT_ALWAYS = {"/tempo": 1, "/palm_force": 2}
_SLOW = {"/swivel": 4}  # Recorded less often than the rest.
_TYPES = {**dict.fromkeys((*_SIZES, *_NOT_ALWAYS, *_SLOW), JOINT_STATE), "/tf": TF, "/events": LOG}
_TO_SCALAR_FIRST = [6, 3, 4, 5, 0, 1, 2]  # From x y z qx qy qz qw.


def read_run_log(
    filename: str | Path, *, most: int = MOST_SAMPLES, progress: Callable[[float], None] = lambda share: None
) -> RunLog:
    """The log of a run as its recording has it: most numbers, and all poses, in single precision.

    Args:
        filename: what `python run.py` recorded, whole or recovered.
        most: more samples are thinned out evenly; an even number.
        progress: called with the share that has been read, 0 to 1.

    Raises:
        RecorderError: the file cannot be read, is truncated or damaged, is no run's, or lacks what a run has.
    """
    path = Path(filename)
    stream = McapStream(path, topics=set(_TYPES), progress=progress)
    tables, events = (SampleTable(most), SampleTable(most)), []
    decoders: dict[str, tuple[Decoder, list[int]]] = {}
    for topic, message in stream.messages():
        try:
            if not decoders and not events:
                check_run(path, stream.metadata)
            if topic.type != _TYPES[topic.name]:
                raise ValueError(f"its messages are of the type {topic.type or 'unknown'}, not {_TYPES[topic.name]}")
            if topic.name == "/events":
                events.append((text_of(LOG, message.data), message.log_time * 1e-9))
                continue
            table = tables[topic.name in _SLOW]
            if table.wants(message.log_time):
                if topic.name not in decoders:
                    decoders[topic.name] = _decoder(topic, message.data, stream.metadata[RECORD])
                decoder, links = decoders[topic.name]
                table.put(topic.name, _numbers(decoder.decode(0.0, message.data), links))
        except (ValueError, IndexError, struct.error) as error:
            raise RecorderError(f"{path}: {topic.name}: {error}; give a run.mcap that run.py wrote") from None
    check_run(path, stream.metadata)
    if ATTACHMENT not in stream.attachments:
        raise RecorderError(f"{path}: the attachment {ATTACHMENT} is missing, which every run has; record the run anew")
    planned = read_planned(stream.attachments[ATTACHMENT], str(path))
    t, signals = tables[0].rows()
    slow = tables[1].rows()
    _check(path, t, signals | slow[1], planned)
    clearance = read_measured(stream.attachments[MEASURED], str(path)) if MEASURED in stream.attachments else None
    return _log(t, signals, slow, planned, clearance, stream.metadata[RECORD], events)


def check_run(path: Path, metadata: Mapping[str, Mapping[str, str]]) -> None:
    """Raises RecorderError where a file's metadata are no run's."""
    if RECORD not in metadata:
        raise RecorderError(
            f"{path}: not a recording of a run (no metadata record '{RECORD}'); give a run.mcap that run.py wrote"
        )
    if not {"kind", "tau_s", "gamma"} <= set(metadata[RECORD]):
        raise RecorderError(
            f"{path}: recorded by an older version, which did not keep all that figures need; run its attached "
            "scenario.yaml again"
        )


def _decoder(topic: Topic, message: bytes, run: Mapping[str, str]) -> tuple[Decoder, list[int]]:
    """The topic's decoder, and which of its transforms are kept: both palms', and the box's.

    Raises:
        ValueError: the topic has not what it has in a run.
    """
    decoder = Decoder(topic.name, topic.type, topic.metadata.get("unit", ""))
    first = decoder.decode(0.0, message)
    if topic.type != TF:
        return decoder, []
    wanted = [run.get("left_palm", ""), run.get("right_palm", ""), *(["box"] if run.get("kind") == "box" else [])]
    missing = [name for name in wanted if name not in first.names]
    if missing:
        raise ValueError(f"the frame '{missing[0]}' is missing")
    return decoder, [first.names.index(name) for name in wanted]


def _numbers(sample: Sample, links: list[int]) -> np.ndarray:
    """The numbers that are kept of a message, flat: the poses of `links`, positions, velocities and efforts, or all."""
    if sample.type == TF:
        return sample.values[links].ravel()
    return sample.values.T.ravel() if sample.values.ndim == 2 else sample.values


def _check(path: Path, t: np.ndarray, signals: Mapping[str, np.ndarray], planned: PlannedSignals) -> None:
    """Raises RecorderError where a signal is missing or of another size, or the run has no duration."""
    palms_and_box = 14 if planned.box is None else 21
    sizes = _SIZES | _SLOW | {"/tf": palms_and_box} | {name: n for name, n in _NOT_ALWAYS.items() if name in signals}
    for name, size in sizes.items():
        if name not in signals:
            raise RecorderError(f"{path}: has no topic {name}, which every run has; give a run.mcap that run.py wrote")
        if signals[name].shape[1] != size:
            raise RecorderError(
                f"{path}: {name}: {signals[name].shape[1]} numbers a message, not {size}; give a run.mcap that run.py "
                "wrote"
            )
    if len(t) < 2:
        raise RecorderError(
            f"{path}: holds {len(t)} whole sample{'s' * (len(t) != 1)}, so no duration; record a run that goes on"
        )


def _log(
    t: np.ndarray,
    signals: Mapping[str, np.ndarray],
    slow: tuple[np.ndarray, Mapping[str, np.ndarray]],
    planned: PlannedSignals,
    clearance: tuple[np.ndarray, np.ndarray] | None,
    run: Mapping[str, str],
    events: list[tuple[str, float]],
) -> RunLog:
    n = len(t)
    joints, lengths = signals["/joint_states"].reshape(n, 3, _JOINTS), signals["/link_lengths"].reshape(n, 3, _LINKS)
    poses = signals["/tf"].reshape(n, -1, 7)[:, :, _TO_SCALAR_FIRST]
    phase = signals["/phase"][:, 0]
    clock = time_at(phase, float(run["tau_s"]), float(run["gamma"]))
    swivels = _angles_at(t, slow[0], slow[1]["/swivel"])
    lower, upper = lengths[:, 1], lengths[:, 2]
    phases = {name for key, name in run.items() if key.startswith("carry_phase_")}
    return RunLog(
        t=t,
        clock=clock,
        phase=phase,
        tempo=signals["/tempo"][:, 0] if "/tempo" in signals else np.ones(n),
        position=signals["/points"].reshape(n, 6, 3),
        uncoupled=planned.points_at("uncoupled", clock),
        demonstrated=planned.points_at("demonstrated", clock),
        lower=lower,
        upper=upper,
        desired=0.5 * (lower + upper),
        barrier=signals["/barrier"],
        q=joints[:, 0],
        q_desired=signals["/desired_position"],
        v=joints[:, 1],
        effort=joints[:, 2],
        q_lower=planned.q_lower,
        q_upper=planned.q_upper,
        v_limit=planned.v_limit,
        effort_limit=planned.effort_limit,
        palm=poses[:, :2],
        palm_desired=signals["/planned_palms"].reshape(n, 2, 7),
        swivel=swivels[:, :2],
        swivel_desired=swivels[:, 2:],
        hands=signals["/hands"][:, 0],
        palm_force=signals.get("/palm_force", np.zeros((n, 2))),
        box=None if planned.box is None else poses[:, 2],
        box_desired=planned.box_at(clock),
        clearance=np.full(n, np.nan) if clearance is None else np.interp(t, *clearance),
        events=_planned_events(run, t, clock),
        spread=planned.spread_at(clock),
        # The first is where the run begins.
        recognised=tuple((name, at) for name, at in events if name in phases)[1:],
    )


def _angles_at(t: np.ndarray, times: np.ndarray, angles: np.ndarray) -> np.ndarray:
    """Angles (N, k), rad in [-pi, pi), at t (N,) from those (M, k) at other times (M,), the shortest way between."""
    columns = [np.interp(t, times, np.unwrap(column)) for column in angles.T]
    return (np.stack(columns, axis=-1) + np.pi) % (2.0 * np.pi) - np.pi


def _planned_events(run: Mapping[str, str], t: np.ndarray, clock: np.ndarray) -> tuple[tuple[str, float], ...]:
    """The task's phases by the time of the run, as far as it got."""
    planned = [(key.removeprefix("event_"), float(value)) for key, value in run.items() if key.startswith("event_")]
    return tuple((name, float(np.interp(at, clock, t))) for name, at in planned if at <= clock[-1] + 1e-6)
