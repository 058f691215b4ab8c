"""The choice of scale, place and palm rolls that lets both arms carry out a whole motion with margin."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from drake_blfdmp.errors import TaskError
from drake_blfdmp.robot.clearance import ClearanceChecker
from drake_blfdmp.robot.kinematics import DualArmKinematics
from drake_blfdmp.robot.plant import JointLimits
from drake_blfdmp.robot.reach_evaluation import (
    JOINT_MARGIN,
    POSE_TOLERANCE,
    SAMPLES,
    Reach,
    evaluate_all,
    palms_of,
)
from drake_blfdmp.robot.retargeting import Retarget
from drake_blfdmp.robot.yaw_rate import gentle_yaw_share

CENTRE = np.array([0.0, 0.47, 0.72])
"""Middle of the space in front of both arms where palms facing each other are reachable, m in W."""

SPAN = np.array([0.5, 0.30, 0.80])
"""Its size along x, y, z, m."""

SCALES = (1.0, 0.9, 0.8, 0.7, 0.6, 0.5, 0.4, 0.3)
SHIFTS = tuple(np.array([0.0, y, z]) for y in (0.0, 0.06, 0.12, -0.06) for z in (0.0, 0.1, -0.1))
_STEPS = (0.0, 0.12, -0.12, 0.24, -0.24, 0.36, -0.36)
WIDE = tuple(np.array([x, y, z]) for x in _STEPS[:5] for y in _STEPS[:5] for z in _STEPS)
"""Where the middle of the motion is put, seen from `CENTRE`, m; and where it is where none of these will do."""

REMEDY = "shorten timing.approach_s and timing.retreat_s, or use a smaller box"
EASE = 2.0
"""A motion that need not be slowed down more than this is taken without looking at smaller scales."""

STRAINED = 3.0
"""A motion that must be slowed down more than this is tried with calmer elbows."""

CALM = (1.0, 0.5, 0.2)
"""Shares of the elbows' swing and of the hands' yaw that are allowed, first to last."""

YAW_TRIALS = 4
"""How often the hands' yaw is taken back where it is too fast (`yaw_rate`)."""


def calmed(retarget: Retarget, share: float, keep_yaw: bool = False) -> Retarget:
    """The same map with the elbows' swing and the hands' yaw and pitch limited to a share of what it allows.

    Unless it is to be kept, so much of the yaw is taken before it is limited: hands that a noisy recording throws about
    would be thrown from one narrow limit to the other. An elbow's limit keeps it off the shoulder's singularity.
    """
    allowed = (retarget.swing_out, retarget.swing_in, retarget.yaw, retarget.pitch)
    out, inward, yaw, pitch = ((share * a, share * b) for a, b in allowed)
    taken = retarget.yaw_share * (1.0 if keep_yaw else share)
    return replace(retarget, swing_out=out, swing_in=inward, yaw=yaw, pitch=pitch, yaw_share=taken)


def _rank(reach: Reach) -> tuple[bool, float]:
    return (not reach.comfortable, reach.stretch / np.sqrt(reach.retarget.scale))


def find_reach(
    t,
    x,
    anchor: int,
    *,
    kinematics: DualArmKinematics,
    limits: JointLimits,
    scale: float | None = None,
    world: np.ndarray | None = None,
    person: np.ndarray | None = None,
    calms: Sequence[float] = CALM,
    level: bool = True,
    elbow_up: bool = True,
    shrink_hands: bool = False,
    keep_yaw: bool = False,
    sample_rate_hz: float = 0.0,
    remedy: str = REMEDY,
    turn: np.ndarray | None = None,
    wide: bool = False,
    progress: Callable[[float], None] = lambda share: None,
) -> Reach:
    """The largest scale at which the whole motion is reachable in comfort, and for it the place that needs least speed.

    Where no scale is comfortable or easy, the sound one that needs least slowing down; where that is still strained,
    the elbows' swing and the hands' yaw are limited further.

    Args:
        t: (N,) s.
        x: (N, 6, 3) motion in the torso frame, m.
        anchor: index of the grasp, or of a posture to which the others are near.
        kinematics: of both arms.
        limits: of their joints.
        scale: fixed by the user; searched where None.
        world: (3,) fixed by the user, m; searched where None.
        person: (3,) as in `Retarget`; None takes the shoulders' mean midpoint in this motion.
        calms: shares of the elbows' swing and of the hands' yaw and pitch that are tried, first to last.
        level: as in `Retarget`.
        elbow_up: as in `Retarget`.
        shrink_hands: the hands' distance may be scaled with the motion, as nothing is held between them.
        keep_yaw: as in `calmed`.
        sample_rate_hz: what is found on `SAMPLES` samples has to hold on so many a second, too.
        remedy: what the error tells a person to do.
        turn: (N, 4) how what is held turns, as in `retarget_motion`; None where nothing tells.
        wide: looks at many more places, as far as the arms are long; takes seconds a scale.
        progress: called with the share of the search that is done.

    Raises:
        TaskError: nothing fits.
    """
    if person is None:
        person = 0.5 * (x[:, 0] + x[:, 3]).mean(axis=0)
    middle = 0.5 * (x[:, 2] + x[:, 5])
    low, high = middle.min(axis=0), middle.max(axis=0)
    largest = largest_scale(middle)
    checker = ClearanceChecker(max_distance=0.1)
    scales = [scale] if scale is not None else [s for s in SCALES if s <= max(largest, SCALES[-1])]
    finer = int(sample_rate_hz * float(t[-1] - t[0]))
    hand_scales = {s: (1.0, s) if shrink_hands and s != 1.0 else (1.0,) for s in scales}

    def candidates(s: float, calm: float) -> list[Retarget]:
        middle_now = 0.5 * (low + high) - person
        shifts = WIDE if wide else SHIFTS
        places = [CENTRE + shift - s * middle_now for shift in shifts] if world is None else [np.asarray(world)]
        found = [
            calmed(Retarget(s, person, place, np.zeros(2), level, elbow_up, hands_scale=hands), calm, keep_yaw)
            for hands in hand_scales[s]
            for place in places
        ]
        return _near_enough(kinematics, x, found, turn) if wide else found

    def tried(retargets: Sequence[Retarget], samples: int = SAMPLES) -> list[Reach]:
        found = evaluate_all(kinematics, limits, checker, t, x, retargets, anchor, samples, turn)
        return [reach for reach in found if reach is not None]

    def gentle(reach: Reach) -> Reach:
        """The reach with as much of the hands' yaw as it bears; as it is where the arms cannot do with less."""
        for _ in range(YAW_TRIALS):
            share = gentle_yaw_share(t, x, reach.retarget, reach.stretch)
            if share == reach.retarget.yaw_share:
                break
            found = tried([replace(reach.retarget, yaw_share=share)], max(SAMPLES, finer))
            if not (found and found[0].sound):
                break
            reach = found[0]  # It may need less slowing down, and its yaw is faster then.
        return reach

    best, nearest = None, None
    for c, calm in enumerate(calms):
        for i, (_, reaches) in enumerate(_by_scale(scales, partial(candidates, calm=calm), tried)):
            progress((c + (i + 1) / len(scales)) / len(calms))
            promising = [reach for reach in reaches if reach.sound and (best is None or _rank(reach) < _rank(best))]
            if finer > SAMPLES and promising:
                reaches = [reach for reach in reaches if not reach.sound]
                reaches += tried([reach.retarget for reach in promising], finer)
            for reach in reaches:
                nearest = max(nearest or reach, reach, key=lambda r: -r.following.pose_error)
                if reach.sound and (best is None or _rank(reach) < _rank(best)):
                    best = reach
            if best is not None and best.comfortable and best.stretch <= EASE:
                break
        if best is not None and best.stretch <= STRAINED:
            break
    progress(1.0)
    if best is not None:
        return best if keep_yaw else gentle(best)
    if nearest is None:
        distance = float(np.linalg.norm(x[anchor, 5] - x[anchor, 2]))
        if shrink_hands:
            raise TaskError(
                f"reach: the arms cannot hold their palms {distance:.2f} m apart as asked; {remedy}", reason="reach"
            )
        raise TaskError(
            f"reach: the arms cannot take a box {distance:.2f} m wide anywhere in front of them; use a narrower box",
            reason="reach",
        )
    f = nearest.following
    how = f"palms {1000 * f.pose_error:.0f} mm off, joint margin {f.joint_margin:.2f} rad"
    if reached := f.pose_error <= POSE_TOLERANCE and f.joint_margin >= JOINT_MARGIN:
        how = f"clearance {nearest.clearance:.3f} m between the arms"
    scaled = f"no scale from {scales[0]:g} to {scales[-1]:g}" if len(scales) > 1 else f"no place at scale {scales[0]:g}"
    raise TaskError(
        f"reach: {scaled} makes the whole motion reachable (best: {how}); {remedy}",
        reason="clearance" if reached else "reach",
    )


def largest_scale(middle: np.ndarray) -> float:
    """The largest scale at which the way (N, 3) of the hands' middle fits into `SPAN`."""
    return float(np.min(SPAN / np.maximum(np.ptp(middle, axis=0), 1e-3)))


def _near_enough(kinematics: DualArmKinematics, x, retargets: Sequence[Retarget], turn) -> list[Retarget]:
    """Those that ask for no palm farther from its shoulder than an arm is long."""
    few = np.linspace(0, len(x) - 1, SAMPLES).round().astype(int)
    poses, _ = palms_of(x[few], retargets, None if turn is None else turn[few])
    near = np.linalg.norm(poses[..., 4:] - kinematics.shoulders, axis=-1) < kinematics.arm_length
    return [retarget for retarget, ok in zip(retargets, near.all(axis=(1, 2)), strict=True) if ok]


def _by_scale(
    scales: Sequence[float],
    candidates: Callable[[float], list[Retarget]],
    tried: Callable[[Sequence[Retarget]], list[Reach]],
) -> Iterator[tuple[float, list[Reach]]]:
    """Each scale with what became of its candidates: the first alone, as it mostly serves, then more at once."""
    first = 0
    for size in (1, 2, len(scales)):
        chunk = scales[first : first + size]
        asked = [retarget for s in chunk for retarget in candidates(s)]
        reaches = tried(asked) if asked else []
        for s in chunk:
            yield s, [reach for reach in reaches if reach.retarget.scale == s]
        first += size
