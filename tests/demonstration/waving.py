"""A modelled person who stands and moves both arms, holding nothing: exact, at rest at neither end."""

import numpy as np

from drake_blfdmp.demonstration.demonstration import Recording
from drake_blfdmp.demonstration.modelled_person import elbow_position

UPPER_ARM, FOREARM = 0.26, 0.24


def wave(duration_s=5.0, rate_hz=30.0, apart=0.36, sweep=0.10):
    """(t, x): both hands wave, the distance between them goes from `apart` - 2 `sweep` to `apart` + 2 `sweep` m."""
    t = np.arange(round(duration_s * rate_hz) + 1) / rate_hz
    phase = 2.0 * np.pi * t / 2.5
    x = np.empty((len(t), 6, 3))
    for side, first in ((-1.0, 0), (1.0, 3)):
        shoulder = np.broadcast_to([side * 0.18, 0.0, 1.40], (len(t), 3))
        wrist = np.stack(
            [
                side * (0.5 * apart + sweep * np.sin(phase)),
                0.28 + 0.03 * np.cos(phase),
                1.20 + 0.08 * np.sin(0.7 * phase + 0.4 * side),
            ],
            axis=-1,
        )
        x[:, first], x[:, first + 2] = shoulder, wrist
        x[:, first + 1] = elbow_position(shoulder, wrist, UPPER_ARM, FOREARM, 0.4 + 0.1 * np.sin(phase), side)
    return t, x


def recorded(t, x):
    """The motion as a file's reader would hand it over."""
    return Recording(t=t, x=x, source="waving", format="made_up", frames=np.arange(len(t)), synthetic=True, up="z")


def write_csv(path, t, x):
    """The motion as a CSV that `read_recording` takes; returns the path."""
    from drake_blfdmp.skeleton import POINTS

    header = ",".join(["t", *(f"{name}_{axis}" for name in POINTS for axis in "xyz")])
    np.savetxt(path, np.column_stack([t, x.reshape(len(t), -1)]), delimiter=",", header=header, comments="", fmt="%.9f")
    return path
