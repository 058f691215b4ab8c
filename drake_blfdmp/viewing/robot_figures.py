"""Figures of the two arms and the box, in the world frame: did the robots do what the skill asked?"""

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure
from scipy.spatial.transform import Rotation

from drake_blfdmp.errors import RecordingError
from drake_blfdmp.recording.run_log import RunLog
from drake_blfdmp.skeleton import HANDS
from drake_blfdmp.viewing import style

_ARMS = ("left arm", "right arm")
_JOINTS_PER_ARM = 7
_LEAST_HEIGHT = 0.02  # m, that the figure of the box's height shows.


def tilt_angle(quaternion: np.ndarray, quaternion_desired: np.ndarray) -> np.ndarray:
    """Angle (N,), rad, between the z axes of two orientations (N, 4), each qw qx qy qz; yaw does not count."""
    up = [Rotation.from_quat(q[:, [1, 2, 3, 0]]).apply([0.0, 0.0, 1.0]) for q in (quaternion, quaternion_desired)]
    # arctan2 keeps its precision near zero, where arccos loses half of its digits.
    return np.arctan2(np.linalg.norm(np.cross(*up), axis=-1), np.sum(up[0] * up[1], axis=-1))


def unwrap_known(angle: np.ndarray) -> np.ndarray:
    """`angle` (N,), rad, without jumps of a whole turn; samples that are NaN stay so and are stepped over."""
    unwrapped = np.array(angle, dtype=float)
    known = np.isfinite(unwrapped)
    unwrapped[known] = np.unwrap(unwrapped[known])
    return unwrapped


@style.styled
def joint_angles(log: RunLog) -> Figure:
    """All fourteen joint angles, the desired ones dashed, with their limits."""
    figure = Figure(figsize=(style.PAGE, 7.6))
    axes = figure.subplots(_JOINTS_PER_ARM, 2, sharex=True, sharey="row")
    for arm, name in enumerate(_ARMS):
        axes[0, arm].set_title(name, pad=style.event_label_height(log.events, (log.t[0], log.t[-1])))
        for joint in range(_JOINTS_PER_ARM):
            axis, index = axes[joint, arm], arm * _JOINTS_PER_ARM + joint
            axis.plot(log.t, log.q[:, index], color=style.BLUE, linewidth=1.3, label="measured")
            axis.plot(log.t, log.q_desired[:, index], **style.PLANNED, label="desired")
            for limit in (log.q_lower[index], log.q_upper[index]):
                axis.axhline(limit, **style.LIMIT, label="limit")
            both = [joint, joint + _JOINTS_PER_ARM]
            limits = (log.q_lower[both], log.q_upper[both])
            axis.set_ylim(style.finite_range(log.q[:, both], log.q_desired[:, both], *limits))
            if arm == 0:
                axis.set_ylabel(f"joint {joint + 1}\n(rad)")
        style.finish_time_axis(axes[-1, arm], log.t)
        style.mark_events(axes[:, arm], log.events, (log.t[0], log.t[-1]))
    figure.align_ylabels(axes[:, 0])
    handles, labels = axes[0, 0].get_legend_handles_labels()
    figure.legend(handles[:3], labels[:3], loc="outside upper center", ncols=3)
    return figure


def contact_forces(log: RunLog) -> Figure:
    """Normal force of both palms on the box."""
    return palm_forces(log.t, log.palm_force, log.events)


@style.styled
def palm_forces(t: np.ndarray, force: np.ndarray, events: Sequence[tuple[str, float]]) -> Figure:
    """Normal force (N, 2), N, of both palms over t (N,), s; events are (name, s)."""
    figure = Figure(figsize=(style.COLUMN, 2.3))
    axis = figure.subplots()
    for palm, look in enumerate((style.LEFT, style.RIGHT)):
        axis.plot(t, force[:, palm], **look)
    axis.set_ylabel("normal force (N)")
    axis.set_ylim(bottom=min(0.0, style.finite_range(force, pad=0.0)[0]))
    style.finish_time_axis(axis, t)
    style.mark_events((axis,), events, (t[0], t[-1]))
    style.legend_above(figure, axis, columns=2)
    return figure


@style.styled
def box_height_tilt(log: RunLog) -> Figure:
    """Height of the box's origin beside the plan's, and the angle of its up axis to the planned one.

    Raises:
        RecordingError: the run has no box.
    """
    if log.box is None or log.box_desired is None:
        raise RecordingError("run log: a motion without a box has no height of one; draw another figure")
    figure = Figure(figsize=(style.COLUMN, 3.2))
    height, tilt = figure.subplots(2, 1, sharex=True)
    height.plot(log.t, log.box[:, 6], color=style.BLUE, linewidth=1.4, label="box")
    height.plot(log.t, log.box_desired[:, 6], **style.PLANNED, label="planned")
    height.set_ylabel("height (m)")
    low, high = height.get_ylim()
    if high - low < _LEAST_HEIGHT:  # A box that only stands would be drawn by its micrometres.
        height.set_ylim((low + high - _LEAST_HEIGHT) / 2, (low + high + _LEAST_HEIGHT) / 2)
    degrees = np.degrees(tilt_angle(log.box[:, :4], log.box_desired[:, :4]))
    tilt.plot(log.t, degrees, color=style.BLUE, linewidth=1.4)
    tilt.set_ylabel("tilt (deg)")
    tilt.set_ylim(0.0, max(1.0, 1.1 * style.finite_range(degrees, pad=0.0)[1]))
    style.finish_time_axis(tilt, log.t)
    style.mark_events((height, tilt), log.events, (log.t[0], log.t[-1]))
    style.legend_above(figure, height, columns=2)
    figure.align_ylabels([height, tilt])
    return figure


@style.styled
def swivel(log: RunLog) -> Figure:
    """Swivel angle of both arms, the person's beside the robot's, without jumps of a whole turn."""
    figure = Figure(figsize=(style.COLUMN, 3.2))
    axes = figure.subplots(2, 1, sharex=True)
    for arm, (axis, name) in enumerate(zip(axes, _ARMS, strict=True)):
        person, robot = unwrap_known(log.swivel_desired[:, arm]), unwrap_known(log.swivel[:, arm])
        difference = robot - person
        if np.isfinite(difference).any():
            robot = robot - 2 * np.pi * np.round(np.nanmedian(difference) / (2 * np.pi))
        axis.plot(log.t, np.degrees(robot), color=style.BLUE, linewidth=1.4, label="robot")
        axis.plot(log.t, np.degrees(person), **style.PLANNED, label="person, mirrored")
        axis.set_ylabel(f"{name}\nswivel (deg)")
    style.finish_time_axis(axes[-1], log.t)
    style.mark_events(axes, log.events, (log.t[0], log.t[-1]))
    style.legend_above(figure, axes[0], columns=2)
    figure.align_ylabels(axes)
    return figure


@style.styled
def feedback(log: RunLog) -> Figure:
    """The palms' own distance in the hands' band, how far their middle is off its place, and the tempo that leaves."""
    figure = Figure(figsize=(style.COLUMN, 3.9))
    band, lag, tempo = figure.subplots(3, 1, sharex=True, height_ratios=(3, 2, 2))
    lower, upper = log.lower[:, HANDS], log.upper[:, HANDS]
    middle, millimetres = (lower + upper) / 2, 1000.0
    edges = [(edge - middle) * millimetres for edge in (lower, upper)]
    band.fill_between(log.t, *edges, **style.BAND)
    band.plot(log.t, (log.hands - middle) * millimetres, color=style.BLUE, linewidth=1.2, label="palms, effective")
    planned = np.linalg.norm(log.position[:, 5] - log.position[:, 2], axis=-1)
    band.plot(log.t, (planned - middle) * millimetres, **style.PLANNED, label="skill")
    # The palms follow the skill only once they have joined in; the band decides what is shown.
    band.set_ylim(-1.6 * edges[1].min(), 1.6 * edges[1].min())
    band.set_ylabel("hands, off the\nmiddle (mm)")
    off = np.linalg.norm((log.palm - log.palm_desired)[..., 4:].mean(axis=1), axis=-1) * millimetres
    lag.plot(log.t, off, color=style.BLUE, linewidth=1.2)
    lag.set_ylim(0.0, max(5.0, 1.1 * style.finite_range(off, pad=0.0)[1]))
    lag.set_ylabel("palms' middle\noff (mm)")
    tempo.plot(log.t, log.tempo, color=style.BLUE, linewidth=1.2)
    tempo.set_ylim(0.0, 1.05)
    tempo.set_ylabel("tempo")
    style.finish_time_axis(tempo, log.t)
    style.mark_events((band, lag, tempo), log.events, (log.t[0], log.t[-1]))
    style.legend_above(figure, band, columns=3)
    figure.align_ylabels([band, lag, tempo])
    return figure
