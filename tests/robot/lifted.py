"""A person who lifts and carries, as a simple motion for the arms."""

import numpy as np

SAMPLES, ANCHOR = 31, 10
TIME = np.linspace(0, 3.0, SAMPLES)


def lift_and_carry(width=0.30, lift=0.20, carry=0.10):
    """A person (N, 6, 3) who lifts what is between the hands, and carries it to the right; elbows a little outward."""
    share = 0.5 - 0.5 * np.cos(np.pi * np.linspace(0, 1, SAMPLES))
    x = np.zeros((SAMPLES, 6, 3))
    for first, side in ((0, -1.0), (3, 1.0)):
        x[:, first] = [0.18 * side, 0.0, 1.40]
        x[:, first + 2] = [0.5 * width * side, 0.30, 1.05]
        x[:, first + 2] += share[:, None] * [carry, 0.0, lift]
        x[:, first + 1] = 0.5 * (x[:, first] + x[:, first + 2]) + [0.08 * side, -0.05, -0.12]
    return x
