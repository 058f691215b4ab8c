"""The recogniser as a system: ports, its discrete update, and what becomes of its transitions in a recording."""

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder

from drake_blfdmp.recording.mcap_recorder import McapRecorder
from drake_blfdmp.recording.read import read_mcap
from drake_blfdmp.robot.box import TableParameters
from drake_blfdmp.robot.carry_phases import CONTACT, PHASES, next_state
from drake_blfdmp.systems.carry_phase import CarryPhase

TABLES = [TableParameters("table", (0.0, 0.5, 0.4), (0.3, 0.3))]
BOX = np.array([1.0, 0, 0, 0, 0.0, 0.5, 0.5, 0, 0, 0, 0, 0, 0])


def test_ports():
    system = CarryPhase(tables=TABLES, box_height=0.2)
    assert (system.GetInputPort("palm_force").size(), system.GetInputPort("box_state").size()) == (2, 13)
    assert system.GetOutputPort("carry_phase").size() == 1
    assert not system.HasAnyDirectFeedthrough()
    context = system.CreateDefaultContext()
    assert system.GetOutputPort("carry_phase").Eval(context) == [0.0]


@pytest.mark.parametrize("lifted", [0.0, 0.05])
def test_the_update_is_that_of_the_pure_function(lifted):
    system = CarryPhase(tables=TABLES, box_height=0.2)
    context = system.CreateDefaultContext()
    state = np.array([CONTACT, CONTACT, 0.3, 40.0])
    context.SetDiscreteState(state)
    context.SetTime(2.0)
    velocity = [0.0, 0.01, 0.1]
    system.GetInputPort("palm_force").FixValue(context, [50.0, 55.0])
    system.GetInputPort("box_state").FixValue(context, np.concatenate([BOX[:6], [0.5 + lifted, 0, 0, 0], velocity]))
    after = system.EvalUniquePeriodicDiscreteUpdate(context).value()
    np.testing.assert_array_equal(after, next_state(state, 2.0, [50.0, 55.0], lifted, velocity))
    assert after[3] == 50.0 and (after[1] == 2) == (lifted > 0)


def test_events_are_written_when_they_happen(tmp_path):
    builder = DiagramBuilder()
    phase = builder.AddSystem(CarryPhase(tables=TABLES, box_height=0.2))
    recorder = McapRecorder(filename=tmp_path / "run.mcap", rate=50.0)
    builder.AddSystem(recorder)
    builder.Connect(phase.get_output_port(), recorder.AddEventInput("events", PHASES))
    builder.Connect(phase.get_output_port(), recorder.AddVectorInput("carry_phase", 1, ["phase"], "1"))
    diagram = builder.Build()
    simulator = Simulator(diagram)
    mine = phase.GetMyMutableContextFromRoot(simulator.get_mutable_context())
    phase.GetInputPort("box_state").FixValue(mine, BOX)
    force = phase.GetInputPort("palm_force").FixValue(mine, np.zeros(2))
    with recorder:
        simulator.AdvanceTo(0.5)
        force.GetMutableData().set_value(np.array([10.0, 10.0]))
        simulator.AdvanceTo(1.0)
        force.GetMutableData().set_value(np.zeros(2))
        simulator.AdvanceTo(1.5)
    run = read_mcap(tmp_path / "run.mcap")
    assert [name for name, _ in run.events] == ["free_space", "contact", "free_space"]
    np.testing.assert_allclose([t for _, t in run.events], [0.0, 0.54, 1.04], atol=0.021)
    series = run.series["/carry_phase"]
    for name, t in run.events:
        assert PHASES[int(series.values[np.searchsorted(series.t, t - 1e-9), 0])] == name
