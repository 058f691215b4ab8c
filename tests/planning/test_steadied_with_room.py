"""Hands are steadied only where the box keeps its room over the tables."""

from dataclasses import replace

import numpy as np

from drake_blfdmp.planning import steadied_task
from drake_blfdmp.planning.plan import MakePlan
from drake_blfdmp.planning.scenario import Scenario


def plan_with(monkeypatch, lowered: float):
    """The default plan with a "steadied" motion whose whole carry is lower, m in the person's frame."""

    def steadied(motion, t, middle, dwells=None):
        carry = (motion.t > motion.events["grasp_end"]) & (motion.t < motion.events["release"])
        return replace(motion, x=motion.x - lowered * carry[:, None, None] * np.array([0.0, 0.0, 1.0])), lowered

    monkeypatch.setattr(steadied_task, "Steadied", steadied)
    return MakePlan(Scenario())


def test_a_steadied_motion_that_leads_the_box_into_a_table_is_not_taken(monkeypatch):
    plain = plan_with(monkeypatch, 0.0)
    harmless = plan_with(monkeypatch, 0.002)
    harmful = plan_with(monkeypatch, 0.3)
    assert not np.array_equal(harmless.coupled.x, plain.coupled.x)
    assert np.array_equal(harmful.coupled.x, plain.coupled.x)
