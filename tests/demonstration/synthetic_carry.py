"""A person who closes both hands on a box, lifts it and opens them again; every bone keeps its length."""

from pathlib import Path

import numpy as np

from drake_blfdmp.demonstration.demonstration import Recording

UPPER_ARM, FOREARM, BOX = 0.29, 0.26, 0.30
SHARED = Path(__file__).resolve().parents[3] / "shared" / "recordings"


def smooth_step(t, start, end):
    u = np.clip((t - start) / (end - start), 0.0, 1.0)
    return u**3 * (10 - 15 * u + 6 * u**2)


def elbows(shoulder, wrist, side):
    axis = wrist - shoulder
    reach = np.linalg.norm(axis, axis=-1, keepdims=True)
    axis = axis / reach
    along = (reach**2 + UPPER_ARM**2 - FOREARM**2) / (2 * reach)
    bend = np.array([0.3 * side, 0.0, -1.0]) - axis * (axis @ np.array([0.3 * side, 0.0, -1.0]))[:, None]
    bend /= np.linalg.norm(bend, axis=-1, keepdims=True)
    return shoulder + along * axis + np.sqrt(UPPER_ARM**2 - along**2) * bend


def carry(duration=6.0, rate=30.0, held=(1.2, 4.6), opening=0.2):
    """(t, x): hands BOX + opening apart, then BOX from held[0] to held[1] while lifted and put down, then apart."""
    t = np.arange(round(duration * rate) + 1) / rate
    still = np.ones_like(t)
    apart = BOX + opening * (1 - smooth_step(t, held[0] - 0.8, held[0]) + smooth_step(t, held[1], held[1] + 0.8))
    lift = 0.25 * (smooth_step(t, held[0], held[0] + 1.2) - smooth_step(t, held[1] - 1.2, held[1]))
    breath = 0.004 * np.sin(2 * np.pi * 0.4 * t)  # No two frames alike.
    points = []
    for side in (-1, 1):
        shoulder = np.stack([0.19 * side * still, breath, 1.4 * still], axis=-1)
        wrist = np.stack([side * apart / 2, 0.32 * still + breath, 0.98 * still + lift], axis=-1)
        points += [shoulder, elbows(shoulder, wrist, side), wrist]
    return t, np.stack(points, axis=1)


def recording(t, x, frames=None, format="test"):
    return Recording(t=t, x=x, source="test.csv", format=format, frames=np.arange(len(t)) if frames is None else frames)


def turn(x, angle):
    c, s = np.cos(angle), np.sin(angle)
    return x @ np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]).T
