"""What the planner took from a person's motion is said in sentences."""

from dataclasses import replace

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


@pytest.mark.parametrize(
    ("rate", "stretch", "sentences"),
    [
        (0.7, 2.0, []),
        (0.82, 1.0, []),  # As good as gentle.
        (1.2, 2.0, ["the line between the palms turns by up to 1.2 rad/s, which throws about what they hold; ", "3"]),
    ],
)
def test_a_yaw_that_is_not_gentle(rate, stretch, sentences):
    """Hands that turn evenly about their middle; slowed down as the note says they are gentle."""
    angle = np.linspace(-0.4, 0.4, 201)
    t, x = (angle + 0.4) / rate, np.zeros((len(angle), 6, 3))
    x[:, 5] = 0.15 * np.stack([np.cos(angle), np.sin(angle), 0.0 * angle], axis=-1)
    x[:, 2] = -x[:, 5]
    found = YawNotes(t, x, MAP, stretch)
    assert found == ([f"{sentences[0]}task.duration_scale={sentences[1]} makes it gentle"] if sentences else [])
    assert YawNotes(1.5 * t, x, MAP, 1.5 * stretch) == []
