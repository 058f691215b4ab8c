"""Random tasks: what varies, how it is drawn, and the scenario that carries one out.

Task i of seed s is always the same, whatever the number of tasks, their order or the law: each has a generator of its
own. Every number is drawn, in a fixed order, whether it is used or not.
"""

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace

import numpy as np

from drake_blfdmp.planning.scenario import Scenario
from drake_blfdmp.planning.scenario_sections import SENSOR_NAMES, RobustnessConfig

LARGEST_SEED = 2**31


@dataclass(frozen=True)
class Ranges:
    """What is drawn, uniformly; a pair is a range.

    Attributes:
        sensors: what films the person: the noise level.
        region_m: (3,) size of the region in which the box stands, and of that in which it is put down, along x, y, z in
            W; both are centred on where the person's own motion has it.
        width_m, mass_kg, friction: of the box, as the plan believes.
        duration: of the person's motion between its rests, over the person's own.
        error: mass and friction of the simulated box, over what the plan believes, are off by up to this share.
    """

    sensors: Sequence[str] = SENSOR_NAMES
    region_m: tuple[float, float, float] = (0.3, 0.3, 0.2)
    width_m: tuple[float, float] = (0.20, 0.40)
    mass_kg: tuple[float, float] = (0.2, 3.0)
    friction: tuple[float, float] = (0.4, 1.0)
    duration: tuple[float, float] = (0.7, 1.5)
    error: float = 0.2


HARDER = Ranges(region_m=(1.2, 1.2, 0.6), mass_kg=(0.2, 6.0), friction=(0.3, 1.0))
"""Ranges in which much cannot be done, by the arms and not by the person who is filmed: for a sample of refusals."""


@dataclass(frozen=True)
class RandomTask:
    """One task: `Ranges` says what its numbers mean.

    Attributes:
        seed, index: name it.
        recording_seed: of the virtual Kinect.
        take_offset_m, place_offset_m: (3,) in W.
        mass_scale, friction_scale: of the simulated box, over what the plan believes.
    """

    seed: int
    index: int
    recording_seed: int
    sensor: str
    take_offset_m: tuple[float, float, float]
    place_offset_m: tuple[float, float, float]
    width_m: float
    mass_kg: float
    friction: float
    duration: float
    mass_scale: float
    friction_scale: float

    def as_dict(self) -> dict:
        """Plain numbers, lists and text, as JSON gives them back."""
        return {name: list(value) if isinstance(value, tuple) else value for name, value in asdict(self).items()}


def draw_task(seed: int, index: int, ranges: Ranges = Ranges()) -> RandomTask:
    """Task `index` of a seed, both zero or more; `RandomTask.recording_seed` differs from task to task."""
    rng = np.random.default_rng([seed, index])
    half = 0.5 * np.array(ranges.region_m)
    recording_seed = int(rng.integers(LARGEST_SEED))
    sensor = str(ranges.sensors[int(rng.integers(len(ranges.sensors)))])
    take, place = (tuple(float(value) for value in rng.uniform(-half, half)) for _ in range(2))
    width, mass, friction, duration = (
        float(rng.uniform(*pair)) for pair in (ranges.width_m, ranges.mass_kg, ranges.friction, ranges.duration)
    )
    mass_scale, friction_scale = (float(rng.uniform(1.0 - ranges.error, 1.0 + ranges.error)) for _ in range(2))
    return RandomTask(
        seed=seed,
        index=index,
        recording_seed=recording_seed,
        sensor=sensor,
        take_offset_m=take,
        place_offset_m=place,
        width_m=width,
        mass_kg=mass,
        friction=friction,
        duration=duration,
        mass_scale=mass_scale,
        friction_scale=friction_scale,
    )


def task_scenario(base: Scenario, task: RandomTask, law: str) -> Scenario:
    """The scenario that carries out a task with a law; whatever the task does not vary is the base's.

    The duration is the person's: the recording is played 1/duration times as fast (`timing.speed`). Where the arms need
    longer than that, the planner slows the motion down further; where they do not, it lasts as asked.
    """
    return replace(
        base,
        name=f"robustness-{task.seed}-{task.index:04d}-{law}",
        seed=task.recording_seed,
        law=law,
        synthetic=replace(base.synthetic, sensor=task.sensor, box_width=task.width_m),
        timing=replace(base.timing, speed=base.timing.speed / task.duration),
        task=replace(base.task, take_offset=list(task.take_offset_m), place_offset=list(task.place_offset_m)),
        box=replace(base.box, mass=task.mass_kg, friction=task.friction),
        reality=replace(base.reality, mass_scale=task.mass_scale, friction_scale=task.friction_scale),
        robustness=RobustnessConfig(),
    )
