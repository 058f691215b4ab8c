"""What the planner took from a person's motion is said in sentences."""

import re
from dataclasses import dataclass, replace

import numpy as np
import pytest

from drake_blfdmp.planning.planned import AdaptationNotes, YawNotes
from drake_blfdmp.robot.reach import calmed
from drake_blfdmp.robot.retargeting import Retarget

MAP = Retarget(0.8, np.zeros(3), np.zeros(3), np.zeros(2))
LIMITED = "elbows' swing limited to {} degrees and the hands' yaw {}, to stay in reach"


@pytest.mark.parametrize(
    ("retarget", "stretch", "sentences"),
    [
        (MAP, 1.0, []),
        (MAP, 2.5, ["slowed down 2.50 times, to stay within the joints' speed and acceleration"]),
        (calmed(MAP, 0.2), 1.0, [LIMITED.format(14, "to 20% of the person's, at most 9")]),
        (calmed(MAP, 0.5, keep_yaw=True), 1.0, [LIMITED.format(35, "to 22")]),
        (replace(calmed(MAP, 0.2), yaw_share=0.0), 1.0, [LIMITED.format(14, "left aside")]),
        (replace(MAP, yaw_share=0.3), 1.0, ["30% of the hands' yaw taken: in the recording it is thrown about"]),
    ],
)
def test_notes(retarget, stretch, sentences):
    assert AdaptationNotes(retarget, stretch) == sentences


@dataclass
class Motion:
    """Of a rollout, what is looked at."""

    t: np.ndarray
    x: np.ndarray


@pytest.mark.parametrize(
    ("rate", "stretch", "told"),
    [
        (0.7, 2.0, None),
        (0.82, 1.0, None),  # As good as gentle.
        (
            1.2,
            2.0,
            r"turns by up to 1\.2 rad/s, changing by up to 0 rad/s\^2, .*; task\.duration_scale=3 makes it gentle",
        ),
    ],
)
def test_a_yaw_that_is_not_gentle(rate, stretch, told):
    """Hands that turn evenly about their middle, and throw themselves about before the arms move."""
    angle = np.linspace(-0.4, 0.4, 201)
    t = 1.0 + (angle + 0.4) / rate
    angle, t = np.concatenate([[0.3, -0.3, -0.4], angle]), np.concatenate([[0.0, 0.01, 0.02], t])
    x = np.zeros((len(angle), 6, 3))
    x[:, 5] = 0.15 * np.stack([np.cos(angle), np.sin(angle), 0.0 * angle], axis=-1)
    x[:, 2] = -x[:, 5]
    found = YawNotes(Motion(t, x), MAP, stretch, 1.0)
    assert found == [] if told is None else re.search(told, *found)
    assert YawNotes(Motion(1.5 * t, x), MAP, 1.5 * stretch, 1.5) == []
