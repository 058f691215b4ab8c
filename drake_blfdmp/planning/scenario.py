"""The typed description of a run, from and to YAML.

A scenario file gives only what differs from the defaults in `scenario_sections`; an unknown key is an error that names
it.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, fields, is_dataclass
from pathlib import Path

import yaml
from pydrake.common.yaml import yaml_dump_typed, yaml_load_typed

from drake_blfdmp.demonstration.timing import Timing
from drake_blfdmp.errors import ScenarioError
from drake_blfdmp.planning.scenario_sections import (
    SENSOR_NAMES,
    TASK_KINDS,
    BandsConfig,
    BoxConfig,
    FeedbackConfig,
    GainsConfig,
    GamsConfig,
    LearningConfig,
    PublishedConfig,
    RealityConfig,
    RecordingConfig,
    RetargetConfig,
    RobustnessConfig,
    SimulationConfig,
    SyntheticConfig,
    TaskConfig,
)
from drake_blfdmp.robot.meshes import VISUALS, RequireMeshes
from drake_blfdmp.robot.redundancy import REDUNDANCIES
from drake_blfdmp.skeleton import POINTS
from drake_blfdmp.skill.laws import LAWS
from drake_blfdmp.skill.regression import METHODS

MOST_YAW = 0.8
"""rad by which a box may be put down turned: two arms that face it from one side turn no farther."""

LONGEST_TIME_STEP = 0.01
"""The longest step of the plant, s: at 0.01 the default run still succeeds, at 0.02 the box flies off."""


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
    feedback: FeedbackConfig = field(default_factory=FeedbackConfig)
    reality: RealityConfig = field(default_factory=RealityConfig)
    simulation: SimulationConfig = field(default_factory=SimulationConfig)
    robustness: RobustnessConfig = field(default_factory=RobustnessConfig)


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
        "synthetic.sensor": (scenario.synthetic.sensor, SENSOR_NAMES),
        "task.kind": (scenario.task.kind, TASK_KINDS),
        "retarget.redundancy": (scenario.retarget.redundancy, REDUNDANCIES),
        "reality.push_arm": (scenario.reality.push_arm, ("left", "right")),
        "simulation.visuals": (scenario.simulation.visuals, VISUALS),
    }
    for key, (value, allowed) in choices.items():
        if value not in allowed:
            raise ScenarioError(f"scenario: {key} is '{value}'; choose one of {', '.join(allowed)}")
    if scenario.simulation.visuals == "meshes":
        RequireMeshes()
    simulation, task, box, reality = scenario.simulation, scenario.task, scenario.box, scenario.reality
    positive = {
        "simulation.time_step": simulation.time_step,
        "simulation.skill_time_step": simulation.skill_time_step,
        "simulation.record_rate_hz": simulation.record_rate_hz,
        "simulation.scene_rate_hz": simulation.scene_rate_hz,
        "task.clearance": task.clearance,
        "task.force_limit": task.force_limit,
        "box.depth": box.depth,
        "box.height": box.height,
        "box.mass": box.mass,
        "box.friction": box.friction,
        "published.k_z": scenario.published.k_z,
        "published.d_z": scenario.published.d_z,
        "published.largest_rate": scenario.published.largest_rate,
        "gams.c_k": scenario.gams.c_k,
        "feedback.rate": scenario.feedback.rate,
        "feedback.largest": scenario.feedback.largest,
        "feedback.contact_force": scenario.feedback.contact_force,
        "feedback.scale": scenario.feedback.scale,
        "reality.mass_scale": reality.mass_scale,
        "reality.friction_scale": reality.friction_scale,
        "reality.stiffness_scale": reality.stiffness_scale,
        "reality.push_duration": reality.push_duration,
        "robustness.timeout_s": scenario.robustness.timeout_s,
    }
    optional = {
        "box.width": box.width,
        "retarget.scale": scenario.retarget.scale,
        "retarget.clearance": scenario.retarget.clearance,
        "task.duration_scale": task.duration_scale,
        "task.squeeze_force": task.squeeze_force,
        "task.squeeze": task.squeeze,
        "bands.upper_arm": scenario.bands.upper_arm,
        "bands.forearm": scenario.bands.forearm,
        "recording.rate_hz": scenario.recording.rate_hz,
    }
    positive |= {key: value for key, value in optional.items() if value is not None}
    for key, values in (
        ("recording.weights", scenario.recording.weights),
        ("bands.mobility", scenario.bands.mobility),
    ):
        positive |= {f"{key}[{i}]": value for i, value in enumerate(values or ())}
    for key, value in positive.items():
        if not 0 < value < float("inf"):
            raise ScenarioError(f"scenario: {key} must be positive and finite, not {value}")
    for key, value in (
        ("task.tail", task.tail),
        ("task.least_lift", task.least_lift),
        ("published.k_2", scenario.published.k_2),
        ("gams.c_2", scenario.gams.c_2),
        ("feedback.slack", scenario.feedback.slack),
        *((("reality.push_at", reality.push_at),) if reality.push_at is not None else ()),
    ):
        if not 0 <= value < float("inf"):
            raise ScenarioError(f"scenario: {key} must not be negative, not {value}")
    for key, values in (("reality.push_force", reality.push_force), ("reality.width_error", [reality.width_error])):
        if not all(abs(value) < float("inf") for value in values):
            raise ScenarioError(f"scenario: {key} must be finite, not {values}")
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
    _check_recordings(scenario)
    _check_mobility(scenario)
    _check_robustness(scenario)
    for key, value, size in (
        ("recording.frames", scenario.recording.frames, 2),
        ("task.held", task.held, 2),
        ("task.take_offset", task.take_offset, 3),
        ("task.place_offset", task.place_offset, 3),
        ("task.place_rotation", task.place_rotation, 3),
        ("retarget.world", scenario.retarget.world, 3),
        ("reality.push_force", reality.push_force, 3),
    ):
        if value is not None and len(value) != size:
            raise ScenarioError(f"scenario: {key} must have {size} numbers, not {len(value)}")
    _check_rotation(task.place_rotation)


def _check_rotation(rotation: Sequence[float]) -> None:
    if any(rotation[:2]):
        raise ScenarioError(
            f"scenario: task.place_rotation is {list(rotation)}, but a box on a level table neither rolls nor pitches; "
            "give [0, 0, yaw]"
        )
    if not -MOST_YAW <= rotation[2] <= MOST_YAW:
        raise ScenarioError(
            f"scenario: task.place_rotation has a yaw of {rotation[2]:g} rad; give {-MOST_YAW:g} to {MOST_YAW:g}"
        )


def _check_recordings(scenario: Scenario) -> None:
    recording, takes = scenario.recording, scenario.synthetic.takes
    if takes < 1:
        raise ScenarioError(f"scenario: synthetic.takes must be at least 1, not {takes}")
    if recording.also and recording.file is None:
        raise ScenarioError(
            "scenario: recording.also goes with recording.file; give that, or synthetic.takes for more films of the "
            "modelled person"
        )
    count = takes if recording.file is None else 1 + len(recording.also)
    if recording.weights is not None and len(recording.weights) != count:
        raise ScenarioError(
            f"scenario: recording.weights must have {count} numbers, one for each recording, not "
            f"{len(recording.weights)}"
        )


def _check_mobility(scenario: Scenario) -> None:
    bands = scenario.bands
    if bands.mobility is None and not bands.weigh_by_uncertainty:
        return
    if bands.mobility is not None and bands.weigh_by_uncertainty:
        raise ScenarioError("scenario: bands.mobility and bands.weigh_by_uncertainty exclude each other; give one")
    if bands.mobility is not None and len(bands.mobility) != len(POINTS):
        raise ScenarioError(
            f"scenario: bands.mobility must have {len(POINTS)} numbers ({', '.join(POINTS)}), not {len(bands.mobility)}"
        )
    if scenario.law != "default":
        key = "bands.weigh_by_uncertainty" if bands.weigh_by_uncertainty else "bands.mobility"
        raise ScenarioError(f"scenario: {key} is for the default law alone; law {scenario.law} has no such weights")


def _check_robustness(scenario: Scenario) -> None:
    tasks = scenario.robustness.tasks
    for law in tasks:
        if law not in LAWS:
            raise ScenarioError(f"scenario: robustness.tasks names the law '{law}'; there are {', '.join(LAWS)}")
    if tasks.get("default", 0) < 1:
        raise ScenarioError("scenario: robustness.tasks.default must be at least 1: its planner says what can be done")
    for key, value in (
        *((f"tasks.{law}", count) for law, count in tasks.items()),
        ("harder", scenario.robustness.harder),
        ("refusals", scenario.robustness.refusals),
    ):
        if value < 0:
            raise ScenarioError(f"scenario: robustness.{key} must not be negative, not {value}")


def _as_drake_reads_it(tree: dict) -> dict:
    """The tree with lists of names in place of lone names, which Drake would take letter by letter, and ids as text."""
    recording = tree.get("recording")
    if not isinstance(recording, dict):
        return tree
    recording = dict(recording)
    if isinstance(joints := recording.get("joints"), dict):
        recording["joints"] = {key: [value] if isinstance(value, str) else value for key, value in joints.items()}
    if isinstance(also := recording.get("also"), str):
        recording["also"] = [also]
    if type(body := recording.get("body")) is int:
        recording["body"] = str(body)
    return {**tree, "recording": recording}


def _parse(text: str, where: str):
    try:
        return yaml.safe_load(text)
    except yaml.YAMLError as error:
        raise ScenarioError(f"{where}: is not YAML ({str(error).splitlines()[0]})") from error
    except RecursionError as error:
        raise ScenarioError(f"{where}: brackets are nested too deeply; write a plain value") from error


def _merge(scenario: Scenario, tree, where: str) -> Scenario:
    if tree is None:
        return scenario
    if not isinstance(tree, dict):
        raise ScenarioError(f"{where}: must hold keys and values")
    _check_keys(scenario, tree, where, "")
    try:
        return yaml_load_typed(schema=Scenario, data=yaml.safe_dump(_as_drake_reads_it(tree)), defaults=scenario)
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
