"""Hands are steadied only where the box keeps its room over the tables."""

from dataclasses import replace

import numpy as np

from drake_blfdmp.planning import steadied_task
from drake_blfdmp.planning.plan import MakePlan
from drake_blfdmp.planning.scenario import Scenario
from drake_blfdmp.planning.steady import RAMP_S, SHORT_RAMP_S


def plan_with(monkeypatch, lowered: float, while_moving: float | None = None, asked: list | None = None):
    """The default plan with a "steadied" motion whose whole carry is lower, m in the person's frame.

    Args:
        while_moving: by so much where only what happens while the hands move is asked for; None: by as much.
        asked: gets the dwells of each call but those of the unmoved motion.
    """

    def steadied(motion, t, middle, dwells):
        if asked is not None:
            asked.append(dwells)
        if dwells.ramp == SHORT_RAMP_S and while_moving is not None:
            return lowered_by(motion, while_moving), while_moving
        return lowered_by(motion, lowered), lowered

    def lowered_by(motion, lowered):
        carry = (motion.t > motion.events["grasp_end"]) & (motion.t < motion.events["release"])
        return replace(motion, x=motion.x - lowered * carry[:, None, None] * np.array([0.0, 0.0, 1.0]))

    monkeypatch.setattr(steadied_task, "Steadied", steadied)
    return MakePlan(Scenario())


def test_a_steadied_motion_that_leads_the_box_into_a_table_is_not_taken(monkeypatch):
    plain = plan_with(monkeypatch, 0.0)
    harmless = plan_with(monkeypatch, 0.002)
    harmful = plan_with(monkeypatch, 0.3)
    assert not np.array_equal(harmless.coupled.x, plain.coupled.x)
    assert np.array_equal(harmful.coupled.x, plain.coupled.x)


def test_what_would_lead_into_a_table_is_done_while_the_hands_move_twice_and_refused_once(monkeypatch):
    plain, asked = plan_with(monkeypatch, 0.0), []
    moving = plan_with(monkeypatch, 0.3, while_moving=0.002, asked=asked)
    assert [dwells.ramp for dwells in asked] == [RAMP_S, SHORT_RAMP_S, SHORT_RAMP_S]
    assert not np.array_equal(moving.coupled.x, plain.coupled.x)
    held = np.array(plain.task.held) / plain.stretch
    np.testing.assert_allclose([asked[1].grasp[1], asked[1].release[0]], held)
    refused: list = []
    plan_with(monkeypatch, 0.3, asked=refused)
    assert [dwells.ramp for dwells in refused] == [RAMP_S, SHORT_RAMP_S]
