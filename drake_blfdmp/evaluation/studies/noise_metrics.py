"""What a skeleton sensor gets wrong (Fig. 2): with the truth beside it, or from a recording alone.

With the truth, the errors of shoulders, elbows and hands are measured. Without it, two things still tell:

- The spread of the bones, which are constant. If errors of different points are independent, the forearm's variance
  less the upper arm's is that of the hand less that of the shoulder along the bones: the elbow's cancels. It says
  nothing of errors that both ends share.
- The jitter, by third differences: what a point does from frame to frame beyond a parabola. Over a person's motion they
  grow as the cube of the time step, over white noise they do not, so differences over one and over two frames tell
  them apart. It says nothing of slow errors.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from drake_blfdmp.demonstration.bones import FOREARMS, PLAUSIBLE_BONE, UPPER_ARMS, link_lengths, robust_sigma
from drake_blfdmp.demonstration.cleaning import clean
from drake_blfdmp.demonstration.demonstration import Recording
from drake_blfdmp.demonstration.formats import read_recording
from drake_blfdmp.demonstration.holding import find_holding
from drake_blfdmp.errors import RecordingError
from drake_blfdmp.skeleton import HANDS

KINDS = {"shoulders": (0, 3), "elbows": (1, 4), "hands": (2, 5)}
"""Kinds of point, with the paper's name for the wrists, and their indices in `skeleton.POINTS`."""

BONE_PAIRS = {"upper_arm": UPPER_ARMS, "forearm": FOREARMS}

JUMP_M = 0.04
"""An error that changes by more from one frame to the next is a jump: three times what 5 mm of white noise can do."""

LEAST_RATE_HZ = 20.0
"""Below it a person's motion fills the third differences and jitter cannot be told."""

LEAST_WOBBLE_M = 1e-3
"""Bones that vary less come from a body model with constant bones: no measuring error is left to be seen in them."""


@dataclass(frozen=True)
class ErrorStatistics:
    """Size of position errors of one kind of point.

    Attributes:
        rms_m, median_m, p95_m, largest_m: of the errors' norms.
        axis_rms_m: (3,) per axis of the recording's frame.
        jump_share: share of frame steps at which the error changes by more than `JUMP_M`.
    """

    rms_m: float
    median_m: float
    p95_m: float
    largest_m: float
    axis_rms_m: np.ndarray
    jump_share: float


@dataclass(frozen=True)
class Spread:
    """A length over many samples, m; `samples` counts those that hold a number."""

    samples: int
    mean_m: float
    std_m: float
    min_m: float
    max_m: float


@dataclass(frozen=True)
class SurveyedFile:
    """What one file of a folder tells.

    Attributes:
        name: below the folder.
        refused: the reason why it tells nothing; empty where it does.
        samples, rate_hz: different frames, and their median rate.
        spreads: "upper_arm" and "forearm" over the whole recording, "hands" while a box is held.
        not_held: why there are no "hands".
        jitter_m: (3,) of shoulders, elbows and hands; NaN where it cannot be told.
    """

    name: str
    refused: str = ""
    samples: int = 0
    rate_hz: float = float("nan")
    spreads: Mapping[str, Spread] = field(default_factory=dict)
    not_held: str = ""
    jitter_m: np.ndarray = field(default_factory=lambda: np.full(3, np.nan))


def distinct_frames(recording: Recording) -> np.ndarray:
    """Indices of the rows with different time stamps, in time's order; of equal ones the first."""
    return np.unique(recording.t, return_index=True)[1]


def seen_points(recording: Recording) -> np.ndarray:
    """The recording's points (N, 6, 3), m, NaN where the file has none: an all-zero joint is one that was not seen."""
    return np.where(np.any(recording.x != 0.0, axis=-1, keepdims=True), recording.x, np.nan)


def error_statistics(errors: np.ndarray) -> ErrorStatistics:
    """Statistics over takes and points of errors in time.

    Args:
        errors: (K, N, P, 3) of K takes of N frames, or (N, P, 3), m; takes of different length are padded with NaN.
    """
    errors = np.asarray(errors, dtype=float)
    size = np.linalg.norm(errors, axis=-1)
    steps = np.linalg.norm(np.diff(errors, axis=-3), axis=-1)
    known = np.isfinite(steps)
    flat = size[np.isfinite(size)]
    return ErrorStatistics(
        rms_m=float(np.sqrt(np.mean(flat**2))),
        median_m=float(np.median(flat)),
        p95_m=float(np.percentile(flat, 95.0)),
        largest_m=float(flat.max()),
        axis_rms_m=np.sqrt(np.nanmean(errors**2, axis=tuple(range(errors.ndim - 1)))),
        jump_share=float(np.sum(steps[known] > JUMP_M) / max(1, np.sum(known))),
    )


def spread(lengths: np.ndarray) -> Spread:
    """Mean, standard deviation, least and greatest of lengths (...), m, NaN ignored.

    Raises:
        RecordingError: there is no length at all.
    """
    known = np.asarray(lengths, dtype=float)
    known = known[np.isfinite(known)]
    if not known.size:
        raise RecordingError("no sample shows both ends of the bone")
    return Spread(known.size, float(known.mean()), float(known.std()), float(known.min()), float(known.max()))


def bone_spreads(x: np.ndarray) -> dict[str, Spread]:
    """Spread of upper arms and forearms of points (N, 6, 3), m: of both arms, each about its own mean.

    Raises:
        RecordingError: a bone is never seen whole.
    """
    lengths = link_lengths(x)
    result = {}
    for name, pair in BONE_PAIRS.items():
        sides = [spread(lengths[:, index]) for index in pair]
        count = sum(side.samples for side in sides)
        result[name] = Spread(
            samples=count,
            mean_m=sum(side.samples * side.mean_m for side in sides) / count,
            std_m=float(np.sqrt(sum(side.samples * side.std_m**2 for side in sides) / count)),
            min_m=min(side.min_m for side in sides),
            max_m=max(side.max_m for side in sides),
        )
    return result


def jitter(t: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Frame-to-frame noise of shoulders, elbows and hands (3,), standard deviation per axis, m.

    With D_k the third difference over k frames, noise gives 20 sigma^2 at any k, motion grows by 4^3 from k = 1 to 2:
    20 sigma^2 = (64 var D_1 - var D_2) / 63. Variances are by the median absolute
    deviation: jumps are not jitter.

    Args:
        t: (N,) increasing, s; only stretches of even time steps count.
        x: (N, 6, 3) m, NaN where missing.

    Returns:
        NaN where the frame rate is below `LEAST_RATE_HZ`, too few frames are even, or motion makes most of D_1.
    """
    result = np.full(len(KINDS), np.nan)
    if len(t) < 8:
        return result
    step = float(np.median(np.diff(t)))
    if not step * LEAST_RATE_HZ <= 1.0:
        return result
    even = np.abs(np.diff(t) / step - 1.0) < 0.25
    for index, points in enumerate(KINDS.values()):
        variances = []
        for k in (1, 2):
            whole = np.lib.stride_tricks.sliding_window_view(even, 3 * k).all(axis=-1)
            third = x[3 * k :] - 3.0 * x[2 * k : -k] + 3.0 * x[k : -2 * k] - x[: -3 * k]
            third = third[whole][:, points].reshape(-1)
            third = third[np.isfinite(third)]
            variances.append(float(robust_sigma(third)) ** 2 if len(third) >= 50 else np.nan)
        noise = (64.0 * variances[0] - variances[1]) / 63.0
        if noise >= 0.5 * variances[0]:
            result[index] = np.sqrt(noise / 20.0)
    return result


def survey_recording(name: str, recording: Recording) -> SurveyedFile:
    """What one recording tells; its bones as they stand in the file, the hands' distance after cleaning, while held."""
    rows = distinct_frames(recording)
    t, x = recording.t[rows], seen_points(recording)[rows]
    if len(t) < 2:
        return SurveyedFile(name, refused=f"{len(t)} frame only; nothing varies")
    try:
        spreads = bone_spreads(x)
    except RecordingError as error:
        return SurveyedFile(name, refused=str(error))
    for bone, found in spreads.items():
        if not PLAUSIBLE_BONE[0] <= found.mean_m <= PLAUSIBLE_BONE[1]:
            return SurveyedFile(
                name, refused=f"the {bone.replace('_', ' ')} measures {found.mean_m:.3g} m on average; no person's"
            )
    not_held = ""
    try:
        demonstration = clean(recording)
        holding = find_holding(demonstration)
        inside = (demonstration.t >= holding.start_s) & (demonstration.t <= holding.end_s)
        spreads["hands"] = spread(link_lengths(demonstration.x[inside])[:, HANDS])
    except RecordingError as error:
        not_held = str(error).removeprefix(f"{recording.source}: ")
    rate = 1.0 / float(np.median(np.diff(t)))
    return SurveyedFile(name, "", len(t), rate, spreads, not_held, jitter(t, x))


def survey_folder(
    folder: Path, progress: Callable[[str, float], None] = lambda what, share: None
) -> list[SurveyedFile]:
    """Every file below a folder, in the order of its path, read as `read_recording` reads it without help.

    Raises:
        RecordingError: the folder is none or holds no file.
    """
    folder = Path(folder)
    if not folder.is_dir():
        raise RecordingError(f"{folder}: is no folder; give one that holds recordings")
    paths = sorted(path for path in folder.rglob("*") if path.is_file())
    if not paths:
        raise RecordingError(f"{folder}: holds no file; give a folder with recordings")
    found = []
    for index, path in enumerate(paths):
        name = path.relative_to(folder).as_posix()
        progress(f"reading {name}", index / len(paths))
        try:
            found.append(survey_recording(name, read_recording(path)))
        except RecordingError as error:
            found.append(SurveyedFile(name, refused=str(error).removeprefix(f"{path}: ")))
    return found
