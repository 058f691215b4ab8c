"""The systems that tell when events are due, each against numbers that are known without it."""

import numpy as np

from drake_blfdmp.skill.canonical import phase_at
from drake_blfdmp.systems.passed_times import PassedTimes
from drake_blfdmp.systems.skill_clock import SkillClock


def output(system, **inputs):
    context = system.CreateDefaultContext()
    for name, value in inputs.items():
        system.GetInputPort(name).FixValue(context, value)
    return system.get_output_port().Eval(context)


def test_the_clock_is_the_time_of_the_phase():
    phase = phase_at(1.7, tau=3.0)
    np.testing.assert_allclose(output(SkillClock(tau=3.0), phase=[phase]), [1.7])


def test_times_are_counted_once_they_are_reached():
    system = PassedTimes(times=[2.0, 0.5])
    for clock, number in ((0.0, 0), (0.499, 0), (0.5, 1), (1.9, 1), (2.0 - 1e-12, 2), (7.0, 2)):
        assert output(system, clock=[clock]) == [number]
