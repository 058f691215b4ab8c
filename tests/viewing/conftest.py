"""A made-up run with the shapes, sizes and events of a real one: reach, hold, lift, carry, place."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from drake_blfdmp.recording.run_log import RunLog
from drake_blfdmp.skeleton import LINKS

Q_LOWER = np.tile([-2.8973, -1.7628, -2.8973, -3.0718, -2.8973, -0.0175, -2.8973], 2)
Q_UPPER = np.tile([2.8973, 1.7628, 2.8973, -0.0698, 2.8973, 3.7525, 2.8973], 2)


def _ramp(t, start, end):
    u = np.clip((t - start) / (end - start), 0.0, 1.0)
    return u**3 * (10 - 15 * u + 6 * u**2)


def _person(t, *, hands, upper_arm=0.22, forearm=0.28):
    """(N, 6, 3): hands close to `hands` (N,), rise, move forward, come down; elbows by two-link inverse kinematics."""
    lift, place = _ramp(t, 2.2, 3.4), _ramp(t, 4.2, 5.2)
    x = np.zeros((len(t), 6, 3))
    for side, first in ((-1.0, 0), (1.0, 3)):
        shoulder = np.array([side * 0.18, 0.0, 1.40])
        wrist = np.stack(
            [side * hands / 2, 0.30 + 0.05 * lift + 0.03 * place, 1.10 + 0.25 * lift - 0.15 * place], axis=-1
        )
        reach = wrist - shoulder
        distance = np.linalg.norm(reach, axis=-1, keepdims=True)
        along = (upper_arm**2 - forearm**2 + distance**2) / (2 * distance)
        across = np.sqrt(np.maximum(upper_arm**2 - along**2, 0.0))
        axis = reach / distance
        down = np.array([side * 0.7, -0.2, -0.7]) - axis * (axis @ [side * 0.7, -0.2, -0.7])[:, None]
        down /= np.linalg.norm(down, axis=-1, keepdims=True)
        x[:, first], x[:, first + 1], x[:, first + 2] = shoulder, shoulder + along * axis + across * down, wrist
    return x


def _lengths(x):
    return np.stack([np.linalg.norm(x[:, link.b] - x[:, link.a], axis=-1) for link in LINKS], axis=-1)


def make_run_log(samples=600, duration=6.0, seed=3):
    random = np.random.default_rng(seed)
    t = np.linspace(0.0, duration, samples)
    hands = 0.62 - 0.32 * _ramp(t, 0.2, 1.6) + 0.12 * _ramp(t, 5.4, 6.0)
    position = _person(t, hands=hands)
    desired = _lengths(position)
    slow = np.sin(2 * np.pi * t[:, None] * random.uniform(0.1, 0.6, 18) + np.arange(18))
    uncoupled = position + 0.02 * slow.reshape(-1, 6, 3)
    demonstrated = uncoupled + 0.006 * random.standard_normal(position.shape)
    half = np.full((samples, 5), 0.01)
    half[:, 2] += 0.02 * np.exp(-3 * t)
    position = position + 0.0015 * np.roll(slow, 5, axis=-1).reshape(-1, 6, 3)

    middle = (Q_LOWER + Q_UPPER) / 2
    swing = np.stack([np.sin(0.9 * t + k) for k in range(14)], axis=-1)
    q_desired = middle + 0.35 * (Q_UPPER - Q_LOWER) / 2 * swing
    held = _ramp(t, 1.6, 1.9) - _ramp(t, 5.4, 5.5)
    height = 0.80 + 0.25 * _ramp(t, 2.2, 3.4) - 0.15 * _ramp(t, 4.2, 5.2)
    box = np.zeros((samples, 7))
    box_desired = np.zeros((samples, 7))
    box_desired[:, 0], box_desired[:, 5], box_desired[:, 6] = 1.0, 0.45, height
    xyzw = Rotation.from_euler("xz", np.stack([0.03 * held * np.sin(3 * t), 0.4 * held], axis=-1)).as_quat()
    box[:, :4], box[:, 4:] = xyzw[:, [3, 0, 1, 2]], box_desired[:, 4:]
    box[:, 6] += 0.004 * held * np.sin(2 * t)
    palm = np.tile([1.0, 0, 0, 0, 0, 0.45, 0.9], (samples, 2, 1))
    swivel_desired = np.stack([-1.2 + 0.3 * np.sin(t), 3.0 + 0.4 * np.sin(t)], axis=-1)
    swivel = swivel_desired + 0.03 * np.sin(2 * t)[:, None]
    return RunLog(
        t=t,
        clock=t,
        phase=np.exp(-t / 2),
        tempo=np.ones(samples),
        position=position,
        uncoupled=uncoupled,
        demonstrated=demonstrated,
        lower=desired - half,
        upper=desired + half,
        desired=desired,
        barrier=0.1 * np.abs(slow[:, :5]),
        q=q_desired + 0.03 * np.roll(swing, 3, axis=-1),
        q_desired=q_desired,
        v=np.gradient(q_desired, t, axis=0),
        effort=np.zeros((samples, 14)),
        q_lower=Q_LOWER,
        q_upper=Q_UPPER,
        v_limit=np.full(14, 2.2),
        effort_limit=np.full(14, 87.0),
        palm=palm,
        palm_desired=palm,
        swivel=(swivel + np.pi) % (2 * np.pi) - np.pi,
        swivel_desired=(swivel_desired + np.pi) % (2 * np.pi) - np.pi,
        hands=desired[:, 2] + 0.002 * np.sin(5 * t),
        palm_force=held[:, None] * (np.array([118.0, 121.0]) + 6 * np.stack([np.sin(4 * t), np.cos(4 * t)], axis=-1)),
        box=box,
        box_desired=box_desired,
        clearance=np.full(samples, 0.05),
        events=(("grasp", 1.7), ("lift", 2.2), ("carry", 3.4), ("lower", 4.2), ("place", 5.2), ("release", 5.4)),
    )


@pytest.fixture(scope="session")
def run_log():
    return make_run_log()
