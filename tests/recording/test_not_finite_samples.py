"""What a recorder does with joint states that are not finite."""

import numpy as np
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder, LeafSystem

from drake_blfdmp.recording.mcap_recorder import McapRecorder
from drake_blfdmp.recording.read import read_mcap


def test_a_sample_with_joints_that_are_not_finite_is_left_out(tmp_path):
    class Falling(LeafSystem):
        def __init__(self):
            super().__init__()
            self.DeclareVectorOutputPort("state", 4, self._calc, {self.time_ticket()})

        def _calc(self, context, output):
            output.SetFromVector(np.full(4, 1.0 if context.get_time() < 0.055 else np.nan))

    builder = DiagramBuilder()
    falling = builder.AddSystem(Falling())
    recorder = builder.AddSystem(McapRecorder(filename=tmp_path / "run.mcap", joints={"arm": ["a", "b"]}))
    recorder.AddVectorInput("same", 4, ["p", "q", "r", "s"], "1")
    for name in ("arm_state", "same"):
        builder.Connect(falling.get_output_port(), recorder.GetInputPort(name))
    with recorder:
        Simulator(builder.Build()).AdvanceTo(0.1)
    for series in read_mcap(tmp_path / "run.mcap").series.values():
        np.testing.assert_allclose(series.t, np.arange(6) / 100.0)
