"""The scenario's recording: read or filmed, cleaned, with its held interval, in the frame that is retargeted."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from drake_blfdmp.demonstration.bones import estimate_bone_lengths
from drake_blfdmp.demonstration.cleaning import CleaningOptions, clean
from drake_blfdmp.demonstration.demonstration import Demonstration, Recording
from drake_blfdmp.demonstration.formats import read_recording
from drake_blfdmp.demonstration.grasp import grasp_and_release
from drake_blfdmp.demonstration.holding import Holding, find_holding
from drake_blfdmp.demonstration.modelled_person import ModelledPerson
from drake_blfdmp.demonstration.torso_frame import to_torso_frame
from drake_blfdmp.demonstration.virtual_kinect import record_hold_and_place
from drake_blfdmp.errors import ScenarioError
from drake_blfdmp.planning.scenario import Scenario


@dataclass(frozen=True)
class Dimensions:
    """The person's bones and the box's width, m."""

    upper_arm: float
    forearm: float
    box_width: float


@dataclass(frozen=True)
class Source:
    """A demonstration ready for learning.

    Attributes:
        recording: as it stands in the file.
        demonstration: cleaned, in the torso frame or the world frame.
        holding: when the box is held, on the demonstration's clock.
        dimensions: bones and box width, each the scenario's, else known beforehand, else estimated, m.
        estimated: names of the dimensions that were estimated.
    """

    recording: Recording
    demonstration: Demonstration
    holding: Holding
    dimensions: Dimensions
    estimated: tuple[str, ...]


def LoadSource(scenario: Scenario, progress: Callable[[str], None] = lambda text: None) -> Source:
    """Read or film the scenario's recording and prepare it.

    Raises:
        RecordingError: it cannot be read, cleaned, or holds no two-handed holding.
        ScenarioError: a held interval outside the recording.
    """
    config = scenario.recording
    if config.file is None:
        progress("filming the modelled person (synthetic)")
        person = ModelledPerson(
            upper_arm=scenario.synthetic.upper_arm,
            forearm=scenario.synthetic.forearm,
            box_width=scenario.synthetic.box_width,
        )
        recording, _ = record_hold_and_place(person=person, seed=scenario.seed)
    else:
        progress(f"reading {config.file}")
        recording = read_recording(
            config.file,
            format=config.format,
            frames=(config.frames[0], config.frames[1]) if config.frames else None,
            joints={key: value[0] if len(value) == 1 else value for key, value in config.joints.items()} or None,
            unit=config.unit,
        )
    progress("cleaning")
    world = clean(recording, CleaningOptions(up=config.up))
    held = scenario.task.held
    demonstration = to_torso_frame(world) if config.frame == "torso" else world
    if held is None:
        holding = grasp_and_release(demonstration, find_holding(world), scenario.learning.cutoff_hz)
    else:
        if not 0 <= held[0] < held[1] <= demonstration.duration_s:
            raise ScenarioError(
                f"task.held: {held[0]:g} to {held[1]:g} s is not an interval of the recording, which lasts "
                f"{demonstration.duration_s:.2f} s"
            )
        holding = Holding(held[0], held[1], _median_hand_distance(world, held))
    return Source(recording, demonstration, holding, *_dimensions(scenario, world, holding))


def _median_hand_distance(demonstration: Demonstration, held) -> float:
    inside = (demonstration.t >= held[0]) & (demonstration.t <= held[1])
    x = demonstration.x[inside]
    return float(np.median(np.linalg.norm(x[:, 5] - x[:, 2], axis=-1)))


def _dimensions(
    scenario: Scenario, demonstration: Demonstration, holding: Holding
) -> tuple[Dimensions, tuple[str, ...]]:
    upper_arm, forearm = estimate_bone_lengths(demonstration.x)
    known = demonstration.known
    wanted = {
        "upper_arm": (scenario.bands.upper_arm, known.upper_arm, upper_arm),
        "forearm": (scenario.bands.forearm, known.forearm, forearm),
        "box_width": (scenario.box.width, known.box_width, holding.hand_distance),
    }
    estimated = tuple(name for name, (given, before, _) in wanted.items() if given is None and before is None)
    chosen = {
        name: float(given if given is not None else before if before is not None else estimate)
        for name, (given, before, estimate) in wanted.items()
    }
    return Dimensions(**chosen), estimated
