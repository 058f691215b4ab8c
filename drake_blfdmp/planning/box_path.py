"""The carried box against the tables: how much room it has along a path, and a path that has more: up, over, down."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.interpolate import make_interp_spline
from scipy.spatial.transform import Rotation

from drake_blfdmp.demonstration.timing import TaskMotion
from drake_blfdmp.robot.box import BoxParameters, TableParameters
from drake_blfdmp.skill.profiles import smooth_step

ROOM = 0.015
"""Distance, m, that a carried box keeps from every table, once it is away from where it stands on it."""

LIFT_OFF = 0.005
"""So far, m, a box may move on the table: hands that close push it a little."""

STEEPNESS = 0.1
"""Room that is asked for over the way from the place on the table; a box that slides along has none."""

TOUCH = 0.003
"""How deep, m, a plan may put the box into a table: the person's hands are not steadier in the dwells."""


def table_gaps(pose, box: BoxParameters, table: TableParameters):
    """How far a box at poses (N, 7), qw qx qy qz x y z, is from a table, m: (N,); negative where it is inside.

    The table counts as solid from its top to the floor. The separating axis theorem: two boxes are apart by at least
    the largest gap between their projections on the axes of either and on the products of these.
    """
    pose = np.asarray(pose, dtype=float)
    axes = Rotation.from_quat(pose[:, [1, 2, 3, 0]]).as_matrix().swapaxes(1, 2)  # Rows: the box's axes in W.
    half = 0.5 * box.size
    top = np.array(table.top_center)
    middle, table_half = top * [1.0, 1.0, 0.5], np.array([0.5 * table.size[0], 0.5 * table.size[1], 0.5 * top[2]])
    world = np.broadcast_to(np.eye(3), axes.shape)
    across = np.cross(axes[:, :, None], world[:, None]).reshape(-1, 9, 3)
    size = np.linalg.norm(across, axis=-1, keepdims=True)
    parallel = size[..., 0] < 1e-6
    tried = np.concatenate([world, axes, across / np.where(size < 1e-6, 1.0, size)], axis=1)
    apart = np.abs(np.einsum("nai,ni->na", tried, pose[:, 4:] - middle))
    reach = np.einsum("nai,nbi->nab", tried, axes)
    gaps = apart - np.abs(reach) @ half - np.abs(tried) @ table_half
    gaps[:, 6:][parallel] = -np.inf
    return gaps.max(axis=1)


def lacking_room(pose, box: BoxParameters, tables: Sequence[TableParameters], ends) -> np.ndarray:
    """How much room a box at poses (N, 7) lacks: (N,), m; what is not positive is enough.

    Args:
        pose: of the box while it is held.
        box: the box.
        tables: one for both ends, or one for each.
        ends: (2, 7) where it stands.
    """
    ends = np.asarray(ends, dtype=float)
    away = np.linalg.norm(pose[:, None, 4:] - ends[None, :, 4:], axis=-1)
    lacking = np.full(len(pose), -np.inf)
    for k, table in enumerate(tables):
        moved = away.min(axis=1) if len(tables) == 1 else away[:, k]
        wanted = np.minimum(ROOM, STEEPNESS * np.maximum(moved - LIFT_OFF, 0.0)) - TOUCH
        lacking = np.maximum(lacking, wanted - table_gaps(pose, box, table))
    return lacking


OVER_S = 2.0
"""The way over the ground takes at least so long, s: a skill follows nothing much faster."""

SLOWEST = 6.0
"""A carry is never slowed down more for that."""


def CarriedSlower(motion: TaskMotion, factor: float) -> TaskMotion:
    """The motion with its carry, which begins and ends at rest, taking `factor` times as long."""
    first, last = (motion.events[name] for name in ("grasp_end", "release"))
    extra = (factor - 1.0) * (last - first)
    step = motion.t[1] - motion.t[0]
    t = step * np.arange(round((motion.t[-1] + extra) / step) + 1)
    old = np.where(t < first, t, np.where(t > last + extra, t - extra, first + (t - first) / factor))
    old = np.clip(old, motion.t[0], motion.t[-1])
    x = make_interp_spline(motion.t, motion.x.reshape(len(motion.t), 18), k=5)(old).reshape(-1, 6, 3)
    events = {name: at + extra * (at >= last) for name, at in motion.events.items()}
    turn = motion.turn
    if turn is not None:
        turn = np.stack([np.interp(old, motion.t, part) for part in turn.T], axis=-1)
        turn = turn / np.linalg.norm(turn, axis=-1, keepdims=True)
    return replace(motion, t=t, x=x, recorded=np.interp(old, motion.t, motion.recorded), events=events, turn=turn)


def LedOver(motion: TaskMotion, above: float) -> tuple[TaskMotion, tuple[float, float]]:
    """The motion with its carry's heights replaced: up in a third of its time, along a level, and down in a third.

    For a way that gets above both of its ends nowhere, or only at its end.

    Args:
        motion: what is taught.
        above: height of the level over the higher end, m.

    Returns:
        The motion, all of its points moved alike, and from when to when it is on the level, s.
    """
    first, last = (motion.events[name] for name in ("grasp_end", "release"))
    third = (last - first) / 3.0
    z = 0.5 * (motion.x[:, 2, 2] + motion.x[:, 5, 2])
    start, end = np.interp([first, last], motion.t, z)
    level = max(start, end) + above
    up, down = (smooth_step((motion.t - begin) / third)[0] for begin in (first, last - third))
    led = start + up * (level - start) + down * (end - level)
    held = (motion.t >= first) & (motion.t <= last)
    x = motion.x.copy()
    x[..., 2] += np.where(held, led - z, 0.0)[:, None]
    return replace(motion, x=x), (first + third, last - third)


def UpOverDown(motion: TaskMotion, window: tuple[float, float]) -> TaskMotion:
    """The motion with the hands' middle led over the ground only within a window of times, s, while the box is held.

    Before it the box goes straight up, after it straight down; heights stay the person's, and all points are moved
    alike. Where the window is short the whole carry is slowed down.
    """
    factor = float(np.clip(OVER_S / (window[1] - window[0]), 1.0, SLOWEST))
    begin = motion.events["grasp_end"]
    motion = CarriedSlower(motion, factor)
    window = begin + factor * (window[0] - begin), begin + factor * (window[1] - begin)
    first, last = (motion.events[name] for name in ("grasp_end", "release"))
    held = (motion.t >= first) & (motion.t <= last)
    middle = 0.5 * (motion.x[:, 2, :2] + motion.x[:, 5, :2])
    start, end = (middle[int(np.clip(np.searchsorted(motion.t, t), 0, len(motion.t) - 1))] for t in (first, last))
    share = smooth_step((motion.t - window[0]) / (window[1] - window[0]))[0]
    x = motion.x.copy()
    x[..., :2] += np.where(held[:, None], start + share[:, None] * (end - start) - middle, 0.0)[:, None]
    return replace(motion, x=x)
