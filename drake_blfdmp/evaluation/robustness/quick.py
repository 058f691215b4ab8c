"""The shortest base that still takes, lifts and places a box: for the quick study and for tests."""

from dataclasses import replace

from drake_blfdmp.planning.scenario import Scenario

SCALE = 0.5


def quick_base(scenario: Scenario) -> Scenario:
    """A scenario cut to a carry of a few seconds: no approach, no retreat, short rests, scale and duration given."""
    return replace(
        scenario,
        timing=replace(scenario.timing, approach_s=0.0, retreat_s=0.0, dwell_s=0.4, rest_s=0.3, ramp_s=0.4, speed=1.5),
        task=replace(scenario.task, tail=0.1, duration_scale=1.0),
        retarget=replace(scenario.retarget, scale=SCALE),
    )
