"""What the planner took from a person's motion is said in sentences."""

from dataclasses import replace

import numpy as np
import pytest

from drake_blfdmp.planning.planned import AdaptationNotes
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
