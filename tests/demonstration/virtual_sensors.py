"""A virtual Kinect without errors, and what its recordings are looked at for."""

import numpy as np

from drake_blfdmp.demonstration.virtual_kinect import VirtualKinect
from drake_blfdmp.skeleton import LINKS

BONES = [0, 1, 3, 4]
PERFECT = VirtualKinect(
    shoulder_drift_m=0,
    elbow_drift_m=0,
    wrist_drift_m=0,
    shortening=0,
    white_m=0,
    occlusion_drift_m=0,
    occlusion_pull_m=0,
    jump_rate_hz=0,
    drop_probability=0,
    repeat_probability=0,
)


def link_lengths(x):
    return np.stack([np.linalg.norm(x[:, link.b] - x[:, link.a], axis=-1) for link in LINKS], axis=-1)
