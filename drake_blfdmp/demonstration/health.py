"""What a recording is worth: clock, points and lengths in numbers, and whether a two-handed skill can be learned."""

from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np

from drake_blfdmp.demonstration.bones import BONES, estimate_bone_lengths, length_jumps, link_lengths
from drake_blfdmp.demonstration.cleaning import CleaningOptions, clean
from drake_blfdmp.demonstration.demonstration import Demonstration, Recording
from drake_blfdmp.demonstration.grasp import grasp_and_release
from drake_blfdmp.demonstration.hand_orientation import turn_since
from drake_blfdmp.demonstration.holding import Holding, find_holding
from drake_blfdmp.demonstration.orientation_cleaning import has_orientation
from drake_blfdmp.demonstration.timing import LONGEST_MOTION_S
from drake_blfdmp.demonstration.torso_frame import CUTOFF_HZ, low_pass, to_torso_frame
from drake_blfdmp.errors import RecordingError
from drake_blfdmp.skeleton import HANDS, LINKS, POINTS, SHOULDERS

_GUESSED = 0.75  # Confidence below which the sensor says that it guesses.
_LEAST_WIDTH, _MOST_WIDTH = 0.08, 1.0  # m: boxes two Frankas can take between their palms.
_SMALL_SHARE = 0.1  # Of a recording: arms that move for a minute come to move together for a second.
_POOR_SEEN, _POOR_RATE, _POOR_WOBBLE = 0.8, 12.0, 0.05  # Shares, Hz and m that are worth a warning.


@dataclass(frozen=True)
class ClockHealth:
    """How the samples lie in time.

    Attributes:
        frames: samples in the file.
        duration_s: from the first to the last.
        rate_hz, mean_rate_hz: by the median step between different times, and over the whole; None for a single time.
        jitter_s: standard deviation of the steps that skip nothing.
        dropped, repeated, out_of_order: frames that a clock of that rate misses; that share another's time; that
            come late.
        longest_gap_s: between two samples.
    """

    frames: int
    duration_s: float
    rate_hz: float | None
    mean_rate_hz: float | None
    jitter_s: float
    dropped: int
    repeated: int
    out_of_order: int
    longest_gap_s: float


@dataclass(frozen=True)
class PointHealth:
    """One point: shares of the frames in which it is seen, and in which the sensor says it guesses; its noise, m.

    `confidence` is the sensor's mean, 0 to 1; `guessed` and it are None where the sensor says nothing, `noise_m` where
    the recording could not be cleaned.
    """

    seen: float
    guessed: float | None
    confidence: float | None
    noise_m: float | None


@dataclass(frozen=True)
class LengthHealth:
    """One link's raw length, m, and in how many frames it cannot be (`jumps`; 0 for the hands' distance)."""

    mean_m: float
    std_m: float
    min_m: float
    max_m: float
    jumps: int


@dataclass(frozen=True)
class HoldingHealth:
    """When both hands hold, s from the cleaned recording's start; their median distance and its wobble (1 sigma), m.

    `turn_deg` is how far they turn what they hold about the line between them; None without orientations.
    """

    start_s: float
    end_s: float
    hand_distance_m: float
    wobble_m: float
    turn_deg: float | None = None


@dataclass(frozen=True)
class Health:
    """The report.

    Attributes:
        source, format: of the recording.
        evidence: how the file was understood, in sentences.
        clock, points, lengths: in numbers; points and lengths by their names in `skeleton`.
        orientations: shares of the frames with the left and the right hand's orientation; None where there are none.
        repairs: what cleaning did, name -> count; empty where it refused.
        notes: what cleaning chose, in sentences.
        bones_m: upper arm and forearm, the estimate cleaning works with; None where it refused.
        walked_m: how far the shoulders' middle gets from its place, horizontally; None where cleaning refused.
        holding: None where nothing is held in two hands.
        suitable: whether a two-handed skill can be learned as it stands.
        reasons: why not, or what to watch.
        settings: scenario settings that suit this recording, as `--set` takes them; where nothing is held, those that
            play the motion without a box.
    """

    source: str
    format: str
    evidence: tuple[str, ...]
    clock: ClockHealth
    points: dict[str, PointHealth]
    lengths: dict[str, LengthHealth]
    orientations: tuple[float, float] | None = None
    repairs: dict[str, int] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    bones_m: tuple[float, float] | None = None
    walked_m: float | None = None
    holding: HoldingHealth | None = None
    suitable: bool = False
    reasons: tuple[str, ...] = ()
    settings: tuple[str, ...] = ()

    def as_dict(self) -> dict[str, Any]:
        """For JSON: numbers, strings, lists and None only."""
        return asdict(self)


@dataclass(frozen=True)
class Examined:
    """A report, and what it was made from; `demonstration` and `holding` are None where there is none."""

    health: Health
    recording: Recording
    demonstration: Demonstration | None
    holding: Holding | None


def examine(recording: Recording, options: CleaningOptions | None = None) -> Examined:
    """Judge a recording: cleaned and searched for the held interval as a run would; never raises for what it finds."""
    reasons: list[str] = []
    demonstration, holding, found = None, None, None
    settings: tuple[str, ...] = ()
    try:
        demonstration = clean(recording, options or CleaningOptions())
    except RecordingError as error:
        reasons.append(_without_source(recording, error))
    if demonstration is not None:
        try:
            in_torso = to_torso_frame(demonstration)
            settings = motion_settings(demonstration.duration_s)
            holding = grasp_and_release(in_torso, find_holding(demonstration))
            found, settings = _holding_health(demonstration, holding), ()
        except RecordingError as error:
            reasons.append(_without_source(recording, error))
    clock, points = clock_health(recording), _points_health(recording, demonstration)
    suitable = holding is not None and _LEAST_WIDTH <= holding.hand_distance <= _MOST_WIDTH
    if holding is not None and not suitable:
        reasons.append(
            f"the hands are {holding.hand_distance:.2f} m apart while they hold; the arms take boxes of "
            f"{_LEAST_WIDTH:g} to {_MOST_WIDTH:g} m"
        )
    reasons += _warnings(clock, points, found)
    health = Health(
        source=recording.source,
        format=recording.format,
        evidence=recording.evidence,
        clock=clock,
        points=points,
        lengths=lengths_health(recording.x),
        orientations=_orientations(recording),
        repairs=dict(demonstration.repairs) if demonstration else {},
        notes=demonstration.notes if demonstration else (),
        bones_m=_bones(demonstration),
        walked_m=_walked(demonstration),
        holding=found,
        suitable=suitable,
        reasons=tuple(reasons),
        settings=(f"box.width={found.hand_distance_m:.3f}",) if suitable and found else settings,
    )
    return Examined(health, recording, demonstration, holding)


def motion_settings(duration_s: float) -> tuple[str, ...]:
    """What plays a recording of that length as a motion without a box: all of it, or as much as may be played."""
    if duration_s <= LONGEST_MOTION_S:
        return ("task.kind=motion",)
    return ("task.kind=motion", f"task.held=[0, {LONGEST_MOTION_S:g}]")


def clock_health(recording: Recording) -> ClockHealth:
    """How a recording's samples lie in time."""
    t = np.asarray(recording.t, float)
    late = int(np.less(t, np.maximum.accumulate(t)).sum())
    distinct = np.unique(t)
    steps = np.diff(distinct)
    if len(steps) == 0:
        return ClockHealth(len(t), 0.0, None, None, 0.0, 0, len(t) - 1, late, 0.0)
    step = float(np.median(steps))
    regular = steps[steps < 1.5 * step]
    return ClockHealth(
        frames=len(t),
        duration_s=float(distinct[-1] - distinct[0]),
        rate_hz=1.0 / step,
        mean_rate_hz=float(len(steps) / (distinct[-1] - distinct[0])),
        jitter_s=float(np.std(regular)) if len(regular) else 0.0,
        dropped=int(np.maximum(np.round(steps / step) - 1.0, 0.0).sum()),
        repeated=len(t) - len(distinct),
        out_of_order=late,
        longest_gap_s=float(steps.max()),
    )


def lengths_health(x: np.ndarray) -> dict[str, LengthHealth]:
    """Statistics of the five links of (N, 6, 3) raw points, m; links that are never seen whole are left out."""
    lengths = link_lengths(x)
    jumps = np.zeros(len(LINKS), dtype=int)
    seen = np.isfinite(lengths)
    whole = [bone for bone in BONES if seen[:, bone].any()]
    jumps[whole] = length_jumps(lengths[:, whole]).sum(axis=0)
    report = {}
    for index, link in enumerate(LINKS):
        values = lengths[seen[:, index], index]
        if len(values):
            report[link.name] = LengthHealth(
                float(values.mean()), float(values.std()), float(values.min()), float(values.max()), int(jumps[index])
            )
    return report


def _points_health(recording: Recording, demonstration: Demonstration | None) -> dict[str, PointHealth]:
    seen = np.isfinite(recording.x).all(axis=-1) & np.any(recording.x != 0.0, axis=-1)
    noise = None if demonstration is None else demonstration.uncertainty
    confidence = recording.confidence
    report = {}
    for index, name in enumerate(POINTS):
        report[name] = PointHealth(
            seen=float(seen[:, index].mean()),
            guessed=None if confidence is None else float((confidence[:, index] < _GUESSED).mean()),
            confidence=None if confidence is None else float(confidence[:, index].mean()),
            noise_m=None if noise is None else float(noise[index]),
        )
    return report


def _holding_health(demonstration: Demonstration, holding: Holding) -> HoldingHealth:
    held = (demonstration.t >= holding.start_s) & (demonstration.t <= holding.end_s)
    wobble = float(np.std(link_lengths(demonstration.x[held])[:, HANDS]))
    return HoldingHealth(holding.start_s, holding.end_s, holding.hand_distance, wobble, _turn(demonstration, holding))


def _turn(demonstration: Demonstration, holding: Holding) -> float | None:
    """How far what is held is turned about the line between the hands at most, degrees."""
    t = demonstration.t[(demonstration.t >= holding.start_s) & (demonstration.t <= holding.end_s)]
    turn = turn_since(demonstration, t, holding.start_s, CUTOFF_HZ)
    return None if turn is None else float(np.rad2deg(np.abs(2.0 * np.arctan2(turn[:, 1], turn[:, 0])).max()))


def _orientations(recording: Recording) -> tuple[float, float] | None:
    if recording.orientations is None:
        return None
    left, right = has_orientation(recording.orientations).mean(axis=0)
    return float(left), float(right)


def _bones(demonstration: Demonstration | None) -> tuple[float, float] | None:
    return None if demonstration is None else estimate_bone_lengths(demonstration.x)


def _walked(demonstration: Demonstration | None) -> float | None:
    if demonstration is None:
        return None
    middle = low_pass(demonstration.x[:, SHOULDERS, :2].mean(axis=1), demonstration.rate_hz, CUTOFF_HZ)
    return float(np.linalg.norm(middle - middle[0], axis=-1).max())


def _warnings(clock: ClockHealth, points: dict[str, PointHealth], holding: HoldingHealth | None) -> list[str]:
    warnings = []
    if clock.rate_hz is not None and clock.rate_hz < _POOR_RATE:
        warnings.append(f"only {clock.rate_hz:.1f} samples a second: fast movements are lost")
    for name, point in points.items():
        if point.seen < _POOR_SEEN:
            warnings.append(f"{name} is seen in {100 * point.seen:.0f} % of the frames only")
        if point.guessed is not None and point.guessed > 1.0 - _POOR_SEEN:
            warnings.append(f"{name} is guessed by the sensor in {100 * point.guessed:.0f} % of the frames")
    held_s = 0.0 if holding is None else holding.end_s - holding.start_s
    if holding is not None and held_s < _SMALL_SHARE * clock.duration_s:
        warnings.append(
            f"the hands keep a distance in {held_s:.1f} s of {clock.duration_s:.0f} s only, which may be chance: cut "
            "the carry out with --frames, or play all of it without a box with --set task.kind=motion"
        )
    if holding is not None and holding.wobble_m > _POOR_WOBBLE:
        warnings.append(
            f"the hands' distance wobbles by {1000 * holding.wobble_m:.0f} mm while they hold: give box.width if "
            "the box is known"
        )
    return warnings


def _without_source(recording: Recording, error: RecordingError) -> str:
    return str(error).removeprefix(f"{recording.source}: ")
