"""The numbers of `summary.json`: pure functions of arrays. Links in the order of `skeleton.LINKS`."""

import numpy as np
from scipy.spatial.transform import Rotation

from drake_blfdmp.quaternions import angle_between
from drake_blfdmp.recording.run_log import RunLog
from drake_blfdmp.robot.retargeting import up_axis
from drake_blfdmp.skeleton import HANDS, LINKS
from drake_blfdmp.skill.bands import Bands
from drake_blfdmp.skill.barrier import barrier_derivative, normalised_error
from drake_blfdmp.skill.geometry import link_states
from drake_blfdmp.skill.rollout import Rollout
from drake_blfdmp.skill.sampled import Gains

RECORDING_RATE = 30.0
"""Samples a second by which the paper counts: a Kinect's."""


def rms_distance(a, b) -> float:
    """Root mean square over samples and points of the distance between points (N, P, 3), m."""
    return float(np.sqrt(np.mean(np.sum((np.asarray(a) - np.asarray(b)) ** 2, axis=-1))))


def samples_until_inside(t, lengths, lower, upper, rate: float = RECORDING_RATE):
    """How many recording samples pass until a length is inside its band for good; None where it never is.

    Args:
        t: (N,) s; lengths, lower, upper: (N,) m; rate: samples a second.
    """
    outside = np.flatnonzero((lengths <= lower) | (lengths >= upper))
    if len(outside) == 0:
        return 0
    if outside[-1] == len(t) - 1:
        return None
    return int(np.ceil(round(float(t[outside[-1] + 1] * rate), 6)))


def link_metrics(rollout: Rollout, bands: Bands, held_at: float | None) -> dict[str, dict]:
    """One entry a link: desired length while held, range, violations of the funnel, how soon the paper's band is met.

    Args:
        rollout: any rollout of the task, with or without coupling.
        bands: the funnel; `bands.paper()` is what (13) and (20) print.
        held_at: a time at which the box is held, s; None without one, where the hands have no one desired length.
    """
    lengths = rollout.lengths
    funnel, paper = bands.evaluate(rollout.t), bands.paper().evaluate(rollout.t)
    middle, half = 0.5 * (funnel[:, 0] + funnel[:, 1]), 0.5 * (funnel[:, 1] - funnel[:, 0])
    excess = np.abs(lengths - middle) - half
    desired = bands.desired(held_at or 0.0)[0]
    return {
        link.name: {
            "desired_m": None if held_at is None and i == HANDS else float(desired[i]),
            "min_m": float(lengths[:, i].min()),
            "max_m": float(lengths[:, i].max()),
            "violations": int(np.sum(excess[:, i] >= 0)),
            "largest_excess_m": float(max(0.0, excess[:, i].max())),
            "samples_until_inside": samples_until_inside(rollout.t, lengths[:, i], paper[:, 0, i], paper[:, 1, i]),
            "min_margin": float(np.min(-excess[:, i] / half[:, i])),
        }
        for i, link in enumerate(LINKS)
    }


def largest_barrier_derivative(rollout: Rollout, gains: Gains) -> float:
    """The largest V' of any link along a coupled rollout, 1/s: negative or zero where the law holds everywhere."""
    rho, rho_dot, _, _ = link_states(rollout.x, rollout.velocity)
    xi, xi_dot = normalised_error(rho, rho_dot, rollout.bands)
    return float(barrier_derivative(xi, xi_dot, gains.k_1, gains.k_2).max())


def robot_metrics(log: RunLog, settle_s: float = 0.0) -> dict[str, float]:
    """How far the arms stay from their limits, and, from `settle_s` on, how well the palms follow the plan."""
    follows = log.t >= settle_s
    return {
        "min_joint_margin_rad": float(np.minimum(log.q - log.q_lower, log.q_upper - log.q).min()),
        "max_velocity_ratio": float((np.abs(log.v) / log.v_limit).max()),
        "max_effort_ratio": float((np.abs(log.effort) / log.effort_limit).max()),
        "min_clearance_m": float(log.clearance.min()),
        "palm_tracking_rms_m": rms_distance(log.palm[follows, :, 4:], log.palm_desired[follows, :, 4:]),
    }


def feedback_metrics(log: RunLog, settle_s: float, duration_s: float) -> dict[str, float | int | bool]:
    """What the robot's state changed in its motion, and whether its own hands kept the band, from `settle_s` on.

    Args:
        duration_s: of the motion on the skill's clock.
    """
    follows = log.t >= settle_s
    middle, half = 0.5 * (log.lower + log.upper)[:, HANDS], 0.5 * (log.upper - log.lower)[:, HANDS]
    xi = (np.abs(log.hands - middle) / half)[follows]
    lag = np.linalg.norm((log.palm - log.palm_desired)[follows, :, 4:].mean(axis=1), axis=-1)
    return {
        "finished": bool(log.clock[-1] >= duration_s - 0.05),
        "min_tempo": float(log.tempo.min()),
        "delay_s": float(log.t[-1] - log.clock[-1]),
        "max_middle_error_m": float(lag.max()),
        "hands_outside_samples": int(np.sum(xi >= 1.0)),
        "hands_outside_s": float(np.sum(xi >= 1.0) * np.median(np.diff(log.t))),
        "hands_min_margin": float(1.0 - xi.max()),
    }


def tilt_deg(pose, desired):
    """The angle between the boxes' up axes, degrees: (...)."""
    return np.rad2deg(np.arccos(np.clip(np.sum(up_axis(pose) * up_axis(desired), axis=-1), -1.0, 1.0)))


def slip(palm, box, width: float):
    """How far the middle of each of the box's faces has slid along its palm since the first sample: (N, 2), m.

    Args:
        palm: (N, 2, 7) X_WP; box: (N, 7) X_WB; width: of the box, m.
    """
    turn = Rotation.from_quat(box[:, [1, 2, 3, 0]])
    faces = np.stack([box[:, 4:] + turn.apply([side * 0.5 * width, 0.0, 0.0]) for side in (-1.0, 1.0)], axis=1)
    along = np.empty((len(box), 2, 2))
    for arm in range(2):
        into_palm = Rotation.from_quat(palm[:, arm][:, [1, 2, 3, 0]]).inv()
        along[:, arm] = into_palm.apply(faces[:, arm] - palm[:, arm, 4:])[:, :2]
    return np.linalg.norm(along - along[:1], axis=-1)


def box_metrics(
    log: RunLog,
    held: tuple[float, float],
    goal,
    start_height: float,
    width: float,
    planned_force: float | None = None,
    force_limit: float | None = None,
) -> dict:
    """What happened to the box, which the log must have.

    Args:
        held: when it is squeezed, s on the skill's clock.
        goal: (7,) where the plan puts it.
        start_height: of its centre before the grasp, m.
        width: of the box, m.
        planned_force: of a palm while the box is held, N.
        force_limit: that no palm should pass then, N.
    """
    if log.box is None or log.box_desired is None:
        raise ValueError("a motion without a box has no metrics of one")
    inside = (log.clock >= held[0]) & (log.clock <= held[1])
    force = log.palm_force[inside]
    gripped = force.min(axis=1) if len(force) else np.zeros(1)
    end = log.box[-1, 4:]
    error = float(np.linalg.norm(end - np.asarray(goal)[4:]))
    return {
        "lifted_m": float(log.box[:, 6].max() - start_height),
        "placement_error_m": error,
        "placement_rotation_deg": float(np.rad2deg(angle_between(log.box[-1, :4], np.asarray(goal)[:4]))),
        "max_tilt_deg": float(tilt_deg(log.box, log.box_desired).max()),
        "dropped": bool(gripped.min() <= 0.0),
        "max_slip_m": float(slip(log.palm[inside], log.box[inside], width).max()) if inside.any() else 0.0,
        "squeeze_force_n": [float(force.min()), float(force.max())] if len(force) else [0.0, 0.0],
        "squeeze_planned_n": planned_force,
        "squeeze_limit_n": force_limit,
    }
