"""The topics of named numbers that a run's recording has: which ports each comes from, and what is made of them."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import ModelInstanceIndex
from pydrake.systems.framework import OutputPort

from drake_blfdmp.diagrams.hold_and_place import HoldAndPlace
from drake_blfdmp.planning.plan import Plan
from drake_blfdmp.recording.planned_signals import PlannedSignals
from drake_blfdmp.recording.sample_block import Make
from drake_blfdmp.robot.plant import JOINTS_PER_ARM
from drake_blfdmp.robot.swivel import swivel_angle
from drake_blfdmp.skeleton import LINKS, POINTS
from drake_blfdmp.skill.canonical import time_at
from drake_blfdmp.skill.geometry import link_lengths

ARMS = ("left", "right")
LINK_NAMES = tuple(link.name for link in LINKS)
LINK_LENGTHS = tuple(f"{link}{end}" for end in ("", "_lower", "_upper") for link in LINK_NAMES)
"""Elements of `/link_lengths`."""

_POSE = ("qw", "qx", "qy", "qz", "x", "y", "z")
_POINTS = [f"{point}_{axis}" for point in POINTS for axis in "xyz"]
_JOINTS = [f"{arm}_{joint}" for arm in ARMS for joint in range(1, JOINTS_PER_ARM + 1)]


class Signal(NamedTuple):
    """A topic of named numbers.

    Attributes:
        name: of the topic, without `/`.
        ports: whose values it has, or is made of, one after the other.
        elements: names of its numbers.
        unit: of all, or of each kind.
        slow: recorded at a lower rate, as it is only looked at.
        exact: in double precision, where seven digits are not enough.
        make: what makes the numbers (N, len(elements)) of the ports' (N, ...); None takes these as they are.
        bodies: those whose poses in W `make` gets behind the ports' numbers, as in VectorTopic.
    """

    name: str
    ports: Sequence[OutputPort]
    elements: Sequence[str]
    unit: str
    slow: bool = False
    exact: bool = False
    make: Make | None = None
    bodies: Sequence[int] = ()


def RunSignals(parts: HoldAndPlace, planned: PlannedSignals) -> list[Signal]:
    """Every topic of named numbers of a run."""
    plan, skill, plant = parts.plan, parts.skill, parts.plant
    phase = skill.canonical.GetOutputPort("phase")
    swivels = SwivelMaker(plant, parts.arms)
    points = skill.transformation.GetOutputPort("position")
    signals = [
        Signal("phase", [phase], ["s"], "1", exact=True),
        Signal("skill_clock", [phase], ["clock"], "s", slow=True, make=ClockMaker(plan)),
        Signal("points", [points], _POINTS, "m"),
        Signal(
            "link_lengths", [points, skill.bands.GetOutputPort("bands")], LINK_LENGTHS, "m", make=lengths_and_limits
        ),
        Signal("barrier", [skill.coupler.GetOutputPort("barrier")], LINK_NAMES, "1"),
        Signal("margin", [skill.coupler.GetOutputPort("margin")], LINK_NAMES, "1"),
        Signal("desired_position", [parts.ik.GetOutputPort("position")], _JOINTS, "rad"),
        Signal("task_scale", [parts.ik.GetOutputPort("task_scale")], ARMS, "1"),
        Signal("hands", [parts.observer.GetOutputPort("effective_distance")], ["distance"], "m"),
        Signal(
            "swivel",
            [parts.retargeting.GetOutputPort("swivel")],
            [*ARMS, *(f"{arm}_person" for arm in ARMS)],
            "rad",
            slow=True,
            make=swivels,
            bodies=swivels.bodies,
        ),
        Signal(
            "planned_palms",
            [parts.retargeting.GetOutputPort("palm_poses")],
            [f"{arm}_{part}" for arm in ARMS for part in _POSE],
            "1, m",
        ),
    ]
    if parts.tempo is not None:
        signals.append(Signal("tempo", [parts.tempo], ["tempo"], "1"))
    if parts.orientation is not None:
        orientation = parts.orientation.GetOutputPort("orientation")
        signals.append(Signal("turn", [orientation], ["qw", "qx", "qy", "qz"], "1"))
    if parts.palm_forces is not None:
        signals.append(Signal("palm_force", [parts.palm_forces.get_output_port()], ARMS, "N"))
    if parts.carry_phase is not None:
        signals.append(Signal("carry_phase", [parts.carry_phase.get_output_port()], ["phase"], "1", slow=True))
    if planned.box is not None:
        make = PlannedBoxMaker(plan, planned)
        signals.append(Signal("planned_box", [phase], _POSE, "1, m", slow=True, make=make))
    return signals


def lengths_and_limits(rows: np.ndarray) -> np.ndarray:
    """The links' lengths and the limits they are to stay between (N, 15), m, in the order of `LINK_LENGTHS`.

    Args:
        rows: (N, 48): the points (18), m, and the bands (30), as from DistanceBands.
    """
    points, bands = rows[:, : 3 * len(POINTS)], rows[:, 3 * len(POINTS) :]
    lengths = link_lengths(points.reshape(len(rows), len(POINTS), 3))
    return np.hstack([lengths, bands[:, : 2 * len(LINKS)]])


def ClockMaker(plan: Plan) -> Make:
    """Of phases (N, 1), the times that they tell: the simulation's where nothing slows the skill, behind it else."""
    skill = plan.task.skill
    return lambda phase: time_at(phase, skill.tau, skill.gamma)


class SwivelMaker:
    """Makes the arms' swivel angles (`robot.swivel`), and puts further numbers behind them.

    Attributes:
        bodies: (2 A,) indices of those on which the elbows of A arms stand, then their wrists.
    """

    def __init__(self, plant: MultibodyPlant, arms: Sequence[ModelInstanceIndex]):
        """Of a plant's arms."""
        context = plant.CreateDefaultContext()
        # The first two axes meet there whatever the joints' angles.
        self._shoulders = np.array(
            [plant.GetFrameByName("shoulder", arm).CalcPoseInWorld(context).translation() for arm in arms]
        )
        frames = [plant.GetFrameByName(name, arm) for name in ("elbow", "wrist") for arm in arms]
        self.bodies = [int(frame.body().index()) for frame in frames]
        self._places = np.array([[*frame.GetFixedPoseInBodyFrame().translation(), 1.0] for frame in frames])

    def __call__(self, rows: np.ndarray) -> np.ndarray:
        """Angles (N, A), rad, and M numbers, of rows (N, M + 24 A): the numbers, then the poses [R p] of the bodies."""
        arms, count = len(self._shoulders), len(self.bodies)
        numbers, poses = np.split(rows, [rows.shape[1] - 12 * count], axis=1)
        points = (poses.reshape(-1, count, 3, 4) @ self._places[:, :, None])[..., 0]
        return np.hstack([swivel_angle(self._shoulders, points[:, :arms], points[:, arms:]), numbers])


def PlannedBoxMaker(plan: Plan, planned: PlannedSignals) -> Make:
    """Of phases (N, 1), where the plan has the box at the nearest of its times: (N, 7), qw qx qy qz x y z."""
    clock, poses = ClockMaker(plan), planned.box
    if poses is None:
        raise ValueError("there is no box")
    middles = 0.5 * (planned.clock[1:] + planned.clock[:-1])
    return lambda phase: poses[np.searchsorted(middles, clock(phase)[:, 0])]
