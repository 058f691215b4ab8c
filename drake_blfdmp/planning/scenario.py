"""The typed description of a run, from and to YAML.

A scenario file gives only what differs from the defaults here; an unknown key is an error that names it. Lengths are in
m, times in s, angles in rad, unless a name says otherwise. None means: found in the recording, or chosen.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, fields, is_dataclass
from pathlib import Path

import yaml
from pydrake.common.yaml import yaml_dump_typed, yaml_load_typed

from drake_blfdmp.demonstration.timing import Timing
from drake_blfdmp.errors import ScenarioError
from drake_blfdmp.robot.redundancy import REDUNDANCIES
from drake_blfdmp.skill.laws import LAWS
from drake_blfdmp.skill.regression import METHODS

LONGEST_TIME_STEP = 0.01
"""The longest step of the plant, s: at 0.01 the default run still succeeds, at 0.02 the box flies off."""


@dataclass
class RecordingConfig:
    """Which recording, and how to read it.

    Attributes:
        file: path; None films the modelled person with the virtual Kinect.
        format: a reader's name; None detects it from the content.
        frames: first and last frame, inclusive.
        joints: a skeleton point's name -> one column stem, or three columns.
        unit: m, cm or mm.
        up: the vertical axis of the file, for example "z", "y" or "-y".
        frame: "torso" lets the person walk away from under the motion, "world" keeps the file's frame.
    """

    file: str | None = None
    format: str | None = None
    frames: list[int] | None = None
    joints: dict[str, list[str]] = field(default_factory=dict)
    unit: str | None = None
    up: str | None = None
    frame: str = "torso"


@dataclass
class SyntheticConfig:
    """The modelled person whom the virtual Kinect films when there is no recording."""

    upper_arm: float = 0.22
    forearm: float = 0.28
    box_width: float = 0.30


@dataclass
class LearningConfig:
    """How the skill is learned.

    Attributes:
        basis_functions: their number; None takes 5 a second, at least 50.
        method: "ridge" or "lwr".
        cutoff_hz: of the smoothing before differentiation.
        alpha_z: gain of (1); None takes 10 tau.
    """

    basis_functions: int | None = None
    method: str = "ridge"
    cutoff_hz: float = 1.2
    alpha_z: float | None = None


@dataclass
class BandsConfig:
    """Desired lengths of the bones and the half widths of all bands; (13), (20)."""

    upper_arm: float | None = None
    forearm: float | None = None
    bone_half_width: float = 0.01
    hands_half_width: float = 0.01
    hands_funnel: float = 0.02
    rate: float = 3.0


@dataclass
class GainsConfig:
    """Gains of the default law, 1/s."""

    k_1: float = 8.0
    k_2: float = 20.0


@dataclass
class PublishedConfig:
    """Gains of the published laws, see `skill.laws.follower`."""

    k_z: float = 300.0
    d_z: float = 0.2
    k_2: float = 0.0
    largest_rate: float = 150.0


@dataclass
class GamsConfig:
    """Gains of the coupling of Gams et al., see `skill.laws.gams`."""

    c_k: float = 300.0
    c_2: float = 10.0


@dataclass
class BoxConfig:
    """The box; a width of None is the hands' distance in the recording."""

    width: float | None = None
    depth: float = 0.20
    height: float = 0.20
    mass: float = 1.0
    friction: float = 0.8


@dataclass
class TaskConfig:
    """What is done with the box.

    Attributes:
        held: beginning and end of the held interval on the recording's clock; None finds it.
        squeeze_force: how hard the palms press on the box, N, on average; the depth follows from the arms' stiffness.
        squeeze: how far each palm is commanded into the box; None takes what gives `squeeze_force`.
        clearance: distance of each palm from the box while it is open.
        grasp_above: how far above the box's centre the palms take it; it then hangs, and the hands clear the table.
        place_offset: the box is put down this much away from where the person put it, (x, y, z) in the robots' world.
        duration_scale: stretches the motion; None slows it down just as far as the arms need.
        tail: time after the motion's end.
    """

    held: list[float] | None = None
    squeeze_force: float = 55.0
    squeeze: float | None = None
    clearance: float = 0.05
    grasp_above: float = 0.02
    place_offset: list[float] = field(default_factory=lambda: [0.0, 0.0, 0.0])
    duration_scale: float | None = None
    tail: float = 0.5


@dataclass
class RetargetConfig:
    """From the person to the arms; None is chosen so that the whole motion is reachable with margin.

    Attributes:
        scale: of the person's motion.
        world: where the shoulders' midpoint goes.
        level: keep the line between the palms horizontal.
        elbow_up: mirror the elbows to above the line from shoulder to wrist.
        redundancy: what the arms' seventh joint is for while they move: "swivel", "none" or "published".
    """

    scale: float | None = None
    world: list[float] | None = None
    level: bool = True
    elbow_up: bool = True
    redundancy: str = "swivel"


@dataclass
class SimulationConfig:
    """Steps and rates: `time_step` of the plant, `skill_time_step` of the skill and the inverse kinematics."""

    time_step: float = 0.002
    skill_time_step: float = 0.004
    record_rate_hz: float = 100.0
    scene_rate_hz: float = 24.0


@dataclass
class Scenario:
    """A whole run."""

    name: str = "hold_and_place"
    seed: int = 0
    law: str = "default"
    recording: RecordingConfig = field(default_factory=RecordingConfig)
    synthetic: SyntheticConfig = field(default_factory=SyntheticConfig)
    learning: LearningConfig = field(default_factory=LearningConfig)
    bands: BandsConfig = field(default_factory=BandsConfig)
    gains: GainsConfig = field(default_factory=GainsConfig)
    published: PublishedConfig = field(default_factory=PublishedConfig)
    gams: GamsConfig = field(default_factory=GamsConfig)
    timing: Timing = field(default_factory=Timing)
    task: TaskConfig = field(default_factory=TaskConfig)
    box: BoxConfig = field(default_factory=BoxConfig)
    retarget: RetargetConfig = field(default_factory=RetargetConfig)
    simulation: SimulationConfig = field(default_factory=SimulationConfig)


def LoadScenario(path: Path, settings: Sequence[str] = ()) -> Scenario:
    """Read a scenario file and apply `key.path=value` settings to it, in order.

    Raises:
        ScenarioError: the file cannot be read, or a key or value is wrong; the message names it.
    """
    try:
        text = Path(path).read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise ScenarioError(f"scenario {path}: cannot be read ({error.__class__.__name__})") from error
    scenario = _merge(Scenario(), _parse(text, f"scenario {path}"), f"scenario {path}")
    for setting in settings:
        scenario = ApplySetting(scenario, setting)
    CheckScenario(scenario)
    return scenario


def ApplySetting(scenario: Scenario, setting: str) -> Scenario:
    """Apply one `key.path=value`; the value is YAML.

    Raises:
        ScenarioError: not of that form, or a key or value is wrong.
    """
    key, equals, value = setting.partition("=")
    if not equals or not key.strip():
        raise ScenarioError(f"--set {setting}: write it as key.path=value, for example box.mass=2")
    tree = _parse(value, f"--set {setting}")
    for part in reversed(key.strip().split(".")):
        tree = {part: tree}
    return _merge(scenario, tree, f"--set {setting}")


def DumpScenario(scenario: Scenario) -> str:
    """The complete scenario as YAML; loading it again gives the same run."""
    return yaml_dump_typed(scenario)  # pyright: ignore[reportReturnType]  None only where it writes a file


def CheckScenario(scenario: Scenario) -> None:
    """Refuse values that no later stage would name as clearly.

    Raises:
        ScenarioError: names the key, the value and what is allowed.
    """
    choices = {
        "law": (scenario.law, tuple(LAWS)),
        "learning.method": (scenario.learning.method, tuple(METHODS)),
        "recording.frame": (scenario.recording.frame, ("torso", "world")),
        "retarget.redundancy": (scenario.retarget.redundancy, REDUNDANCIES),
    }
    for key, (value, allowed) in choices.items():
        if value not in allowed:
            raise ScenarioError(f"scenario: {key} is '{value}'; choose one of {', '.join(allowed)}")
    simulation, task, box = scenario.simulation, scenario.task, scenario.box
    positive = {
        "simulation.time_step": simulation.time_step,
        "simulation.skill_time_step": simulation.skill_time_step,
        "simulation.record_rate_hz": simulation.record_rate_hz,
        "simulation.scene_rate_hz": simulation.scene_rate_hz,
        "task.clearance": task.clearance,
        "task.squeeze_force": task.squeeze_force,
        "box.depth": box.depth,
        "box.height": box.height,
        "box.mass": box.mass,
        "box.friction": box.friction,
        "published.k_z": scenario.published.k_z,
        "published.d_z": scenario.published.d_z,
        "published.largest_rate": scenario.published.largest_rate,
        "gams.c_k": scenario.gams.c_k,
    }
    optional = {
        "box.width": box.width,
        "retarget.scale": scenario.retarget.scale,
        "task.duration_scale": task.duration_scale,
        "task.squeeze": task.squeeze,
        "bands.upper_arm": scenario.bands.upper_arm,
        "bands.forearm": scenario.bands.forearm,
    }
    positive |= {key: value for key, value in optional.items() if value is not None}
    for key, value in positive.items():
        if not 0 < value < float("inf"):
            raise ScenarioError(f"scenario: {key} must be positive and finite, not {value}")
    for key, value in (
        ("task.tail", task.tail),
        ("published.k_2", scenario.published.k_2),
        ("gams.c_2", scenario.gams.c_2),
    ):
        if not 0 <= value < float("inf"):
            raise ScenarioError(f"scenario: {key} must not be negative, not {value}")
    if simulation.time_step > LONGEST_TIME_STEP:
        raise ScenarioError(
            f"scenario: simulation.time_step is {simulation.time_step:g} s; contact needs at most "
            f"{LONGEST_TIME_STEP:g} s"
        )
    if not abs(task.grasp_above) < 0.5 * box.height - 0.04:
        raise ScenarioError(
            f"scenario: task.grasp_above is {task.grasp_above:g} m, but palms of 0.045 m radius must fit on the side "
            f"of a box {box.height:g} m high"
        )
    if scenario.learning.basis_functions is not None and scenario.learning.basis_functions < 2:
        raise ScenarioError(
            f"scenario: learning.basis_functions must be at least 2, not {scenario.learning.basis_functions}"
        )
    for key, value, size in (
        ("recording.frames", scenario.recording.frames, 2),
        ("task.held", task.held, 2),
        ("task.place_offset", task.place_offset, 3),
        ("retarget.world", scenario.retarget.world, 3),
    ):
        if value is not None and len(value) != size:
            raise ScenarioError(f"scenario: {key} must have {size} numbers, not {len(value)}")


def _listed_joints(tree: dict) -> dict:
    """The tree with every joint's columns in a list: Drake's loader would take a lone name letter by letter."""
    recording = tree.get("recording")
    if not isinstance(recording, dict) or not isinstance(joints := recording.get("joints"), dict):
        return tree
    listed = {key: [value] if isinstance(value, str) else value for key, value in joints.items()}
    return {**tree, "recording": {**recording, "joints": listed}}


def _parse(text: str, where: str):
    try:
        return yaml.safe_load(text)
    except yaml.YAMLError as error:
        raise ScenarioError(f"{where}: is not YAML ({str(error).splitlines()[0]})") from error


def _merge(scenario: Scenario, tree, where: str) -> Scenario:
    if tree is None:
        return scenario
    if not isinstance(tree, dict):
        raise ScenarioError(f"{where}: must hold keys and values")
    _check_keys(scenario, tree, where, "")
    try:
        return yaml_load_typed(schema=Scenario, data=yaml.safe_dump(_listed_joints(tree)), defaults=scenario)
    except Exception as error:  # Drake's loader raises bare errors of several types
        raise ScenarioError(f"{where}: {str(error).splitlines()[0]}") from error


def _check_keys(target, tree: dict, where: str, prefix: str) -> None:
    known = [item.name for item in fields(target)]
    for key, value in tree.items():
        if key not in known:
            raise ScenarioError(f"{where}: unknown key '{prefix}{key}'; there are {', '.join(known)}")
        child = getattr(target, key)
        if is_dataclass(child):
            if not isinstance(value, dict):
                raise ScenarioError(f"{where}: '{prefix}{key}' holds keys of its own, not a single value")
            _check_keys(child, value, where, f"{prefix}{key}.")
