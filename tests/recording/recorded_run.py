"""A diagram whose every recorded signal is a known function of time."""

from pathlib import Path

import numpy as np
from pydrake.common.value import AbstractValue
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder, LeafSystem

from drake_blfdmp.recording.mcap_recorder import McapRecorder

URDF = "<robot name='two'/>"
JOINTS = {"left": ["left_a", "left_b"], "right": ["right_a"]}
BODIES = {"left_link": 1, "box": 3}
STATIC = {"table": 2}
ELEMENTS = ["hands", "left_a"]  # The second is a joint's name.
SIZES = {"left_state": 4, "left_effort": 2, "right_state": 2, "right_effort": 1, "palm": 6, "margin": 2}


def signal(t: float, name: str) -> np.ndarray:
    """What the port `name` carries at time t; at a whole nanosecond, so that a recorded time gives the same bits."""
    return np.sin((1.0 + round(t, 9)) * np.arange(1, SIZES[name] + 1) + len(name))


def poses_at(t: float) -> list[RigidTransform]:
    return [RigidTransform(RollPitchYaw(k * t, 0.1 * k, t), [t, k, 0.5]) for k in range(4)]


class Signals(LeafSystem):
    def __init__(self, fail_at: float):
        LeafSystem.__init__(self)
        self._fail_at = fail_at
        for name, size in SIZES.items():
            self.DeclareVectorOutputPort(
                name, size, lambda context, output, name=name: self._calc(context, output, name), {self.time_ticket()}
            )
        self.DeclareAbstractOutputPort(
            "body_poses",
            lambda: AbstractValue.Make([RigidTransform()]),
            lambda context, output: output.set_value(poses_at(context.get_time())),
            {self.time_ticket()},
        )

    def _calc(self, context, output, name):
        if context.get_time() >= self._fail_at:
            raise ZeroDivisionError("the controller broke")
        output.SetFromVector(signal(context.get_time(), name))


def make_run(filename: Path, *, fail_at: float = np.inf, leave_out: tuple[str, ...] = (), **options):
    """Returns (diagram, recorder), all ports connected but those named in `leave_out`."""
    options = {
        "joints": JOINTS,
        "bodies": BODIES,
        "static_bodies": STATIC,
        "robot_description": URDF,
        "metadata": {"seed": 7, "synthetic": True},
        **options,
    }
    builder = DiagramBuilder()
    source = builder.AddSystem(Signals(fail_at))
    recorder = McapRecorder(filename=filename, **options)
    recorder.AddWrenchInput("palm", "world")
    recorder.AddVectorInput("margin", 2, ELEMENTS, "m")
    builder.AddSystem(recorder)
    for port in map(source.get_output_port, range(source.num_output_ports())):
        if port.get_name() not in leave_out:
            builder.Connect(port, recorder.GetInputPort(port.get_name()))
    return builder.Build(), recorder


def record(filename: Path, duration: float = 1.0, **options) -> None:
    """Records a run of `duration` s with one event and one attachment."""
    diagram, recorder = make_run(filename, **options)
    with recorder:
        Simulator(diagram).AdvanceTo(duration)
        recorder.Event("grasp", 0.5)
        recorder.AddAttachment("scenario.yaml", "seed: 7\n", "application/yaml")
