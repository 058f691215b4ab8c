"""Phase stopping: the tempo it gives, what it takes from the arms, and that it comes back."""

import numpy as np
import pytest
from pydrake.common.value import AbstractValue
from pydrake.math import RigidTransform

from drake_blfdmp.errors import ScenarioError
from drake_blfdmp.systems.phase_stopping import PhaseStopping

DT = 0.004
COMMANDED = np.array([-0.2, 0.5, 0.9, 0.2, 0.5, 0.9])
GIVEN = {"palms": (1, 3), "time_step": DT, "slack": 0.01, "scale": 0.02}


def prepared(error=0.0, arms=None, **changes):
    """Palms whose middle is `error` above the commanded one, each squeezed in by 12 mm."""
    system = PhaseStopping(**(GIVEN | changes))
    context = system.CreateDefaultContext()
    away = RigidTransform([9.0, 9.0, 9.0])
    poses = [
        away,
        RigidTransform(COMMANDED[:3] + np.array([-0.012, 0.0, error])),
        away,
        RigidTransform(COMMANDED[3:] + np.array([0.012, 0.0, error])),
    ]
    system.GetInputPort("body_poses").FixValue(context, AbstractValue.Make(poses))
    system.GetInputPort("commanded_palms").FixValue(context, COMMANDED)
    if arms is not None:
        system.GetInputPort("arms_tempo").FixValue(context, arms)
    return system, context


def tempo_after(system, context, steps):
    for _ in range(steps):
        context.SetDiscreteState(system.EvalUniquePeriodicDiscreteUpdate(context))
    return float(system.GetOutputPort("tempo").Eval(context)[0])


def test_ports():
    system = PhaseStopping(**GIVEN)
    inputs = [system.get_input_port(i).get_name() for i in range(system.num_input_ports())]
    assert inputs == ["body_poses", "commanded_palms", "arms_tempo"]
    outputs = [system.get_output_port(i) for i in range(system.num_output_ports())]
    assert [(port.get_name(), port.size()) for port in outputs] == [("tempo", 1), ("tracking_error", 1)]
    # What slows the phase must not ask what the phase moves, or the loop would be algebraic.
    through = [(i, o) for i in range(3) for o in range(2) if system.HasDirectFeedthrough(i, o)]
    assert through == [(0, 1), (1, 1), (2, 0)]


def test_the_tracking_error_is_the_middles():
    system, context = prepared(0.017)
    assert system.GetOutputPort("tracking_error").Eval(context) == pytest.approx(0.017)


@pytest.mark.parametrize(("error", "settles"), [(0.0, 1.0), (0.0099, 1.0), (0.03, 0.5), (0.05, 0.2), (5.0, 0.1)])
def test_it_settles_at_the_share_that_the_error_leaves_and_never_stops(error, settles):
    tempo = tempo_after(*prepared(error), 200)
    assert tempo == pytest.approx(settles, abs=1e-9)
    assert error > 0.01 or tempo == 1.0


def test_it_is_quick_to_slow_down_and_resumes():
    system, context = prepared(0.03)
    assert tempo_after(system, context, 1) == pytest.approx(0.5 + 0.5 * np.exp(-DT / 0.02))
    assert tempo_after(system, context, 50) == pytest.approx(0.5, abs=1e-4)
    calm, again = prepared(0.0)
    again.SetDiscreteState(0, [0.5])
    assert tempo_after(calm, again, 75) == pytest.approx(1.0 - 0.5 * np.exp(-75 * DT / 0.3))


@pytest.mark.parametrize(("arms", "error", "wanted"), [(0.7, 0.0, 0.7), (0.7, 0.03, 0.5), (1.0, 0.03, 0.5)])
def test_the_slower_of_both_counts(arms, error, wanted):
    assert tempo_after(*prepared(error, arms), 200) == pytest.approx(wanted, abs=1e-9)


@pytest.mark.parametrize(
    ("name", "value"),
    [("time_step", 0.0), ("slack", -1e-3), ("scale", 0.0), ("fall", 0.0), ("rise", np.inf), ("floor", 0.0),
     ("floor", 1.5), ("slack", np.nan)],
)  # fmt: skip
def test_what_is_out_of_range_is_named(name, value):
    with pytest.raises(ScenarioError, match=f"phase stopping: {name} is out of range"):
        PhaseStopping(**(GIVEN | {name: value}))
