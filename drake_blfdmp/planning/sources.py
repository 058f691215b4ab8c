"""The scenario's recordings: read or filmed, cleaned, with their held intervals, in the frame that is retargeted.

Several recordings of one task become one demonstration: their weighted mean on a common clock (`alignment`).
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from drake_blfdmp.demonstration.alignment import Alignment, align, weighted_mean, weighted_spread
from drake_blfdmp.demonstration.bones import estimate_bone_lengths
from drake_blfdmp.demonstration.cleaning import CleaningOptions, clean
from drake_blfdmp.demonstration.demonstration import Demonstration, Recording
from drake_blfdmp.demonstration.formats import read_recording
from drake_blfdmp.demonstration.grasp import grasp_and_release
from drake_blfdmp.demonstration.hand_orientation import mean_orientations
from drake_blfdmp.demonstration.holding import Holding, find_holding
from drake_blfdmp.demonstration.modelled_person import ModelledPerson
from drake_blfdmp.demonstration.sensors import SENSORS
from drake_blfdmp.demonstration.torso_frame import to_torso_frame
from drake_blfdmp.demonstration.virtual_kinect import record_hold_and_place
from drake_blfdmp.errors import RecordingError, ScenarioError
from drake_blfdmp.planning.scenario import Scenario

LEAST_AGREEMENT = 0.7
"""Share of the others' motion of the hands below which a recording is said to differ; noise leaves 0.85 and more."""


MOTION_HINT = "or play the motion without a box with --set task.kind=motion"


@dataclass(frozen=True)
class Dimensions:
    """The person's bones and the box's width, m; no width in a motion without a box."""

    upper_arm: float
    forearm: float
    box_width: float | None


@dataclass(frozen=True)
class Together:
    """How several recordings became one demonstration.

    Attributes:
        sources: the n recordings, each as if it were the only one.
        weights: (n,) of sum 1.
        alignment: their times on the demonstration's clock.
        spread: (N, 6, 3) standard deviation over the smoothed recordings, on the demonstration's clock, m.
    """

    sources: tuple["Source", ...]
    weights: np.ndarray
    alignment: Alignment
    spread: np.ndarray

    @property
    def notes(self) -> tuple[str, ...]:
        """A sentence on every recording whose hands do something else than the others'."""
        return tuple(
            f"{source.recording.source} shares only {100 * share:.0f} % of the hands' motion in the other recordings; "
            "if it is another task, leave it out"
            for source, share in zip(self.sources, self.alignment.agreement, strict=True)
            if share < LEAST_AGREEMENT
        )


@dataclass(frozen=True)
class Source:
    """A demonstration ready for learning.

    Attributes:
        recording: as it stands in the file; of several the first.
        demonstration: cleaned, in the torso frame or the world frame; of several their mean.
        holding: when the box is held, on the demonstration's clock; in a motion without a box, what is played.
        dimensions: bones and box width, each the scenario's, else known beforehand, else estimated, m.
        estimated: names of the dimensions that were estimated.
        together: None for one recording.
    """

    recording: Recording
    demonstration: Demonstration
    holding: Holding
    dimensions: Dimensions
    estimated: tuple[str, ...]
    together: Together | None = None


def LoadSource(scenario: Scenario, progress: Callable[[str], None] = lambda text: None) -> Source:
    """Read or film the scenario's recordings and prepare them.

    Raises:
        RecordingError: one cannot be read, cleaned, or holds no two-handed holding where one is asked for.
        ScenarioError: a held interval outside the recording.
    """
    return MakeSource(scenario, ReadRecordings(scenario, progress), progress)


def ReadRecordings(scenario: Scenario, progress: Callable[[str], None] = lambda text: None) -> list[Recording]:
    """The recordings as they stand in the scenario's files, or the takes of the virtual Kinect.

    Raises:
        RecordingError: one cannot be read.
    """
    config, synthetic = scenario.recording, scenario.synthetic
    if config.file is None:
        progress("filming the modelled person (synthetic)")
        person = ModelledPerson(
            upper_arm=synthetic.upper_arm,
            forearm=synthetic.forearm,
            box_width=synthetic.box_width,
            box_pitch=synthetic.box_pitch,
        )
        seeds = range(scenario.seed, scenario.seed + synthetic.takes)
        sensor = SENSORS.get(synthetic.sensor)  # None, of the steady one, films with the default.
        return [record_hold_and_place(person=person, sensor=sensor, seed=seed)[0] for seed in seeds]
    recordings = []
    for file in (config.file, *config.also):
        progress(f"reading {file}")
        first = not recordings
        recordings.append(
            read_recording(
                file,
                format=config.format,
                frames=(config.frames[0], config.frames[1]) if config.frames and first else None,
                joints={key: value[0] if len(value) == 1 else value for key, value in config.joints.items()} or None,
                unit=config.unit,
                time_unit=config.time_unit,
                rate_hz=config.rate_hz,
                body=config.body if first else None,
            )
        )
    return recordings


def MakeSource(
    scenario: Scenario, recordings: Sequence[Recording], progress: Callable[[str], None] = lambda text: None
) -> Source:
    """Clean recordings of one task and make one demonstration of them.

    Raises:
        RecordingError: one cannot be cleaned, or holds no two-handed holding where one is asked for; it is named.
        ScenarioError: a held interval outside the first recording.
    """
    progress("cleaning")
    if len(recordings) == 1:
        return _make_source(scenario, recordings[0], scenario.task.held)
    sources = []
    for recording in recordings:
        try:
            sources.append(_make_source(scenario, recording, None if sources else scenario.task.held))
        except RecordingError as error:
            if recording.source in str(error):
                raise
            raise RecordingError(f"{recording.source}: {error}") from error
    progress(f"aligning {len(sources)} recordings")
    return _learn_together(scenario, sources)


def CleanRecording(scenario: Scenario, recording: Recording) -> Demonstration:
    """The recording cleaned as the scenario says, in the world frame.

    Raises:
        RecordingError: it cannot be.
    """
    config = scenario.recording
    return clean(recording, CleaningOptions(up=config.up, **vars(config.cleaning)))


def _make_source(scenario: Scenario, recording: Recording, held: Sequence[float] | None) -> Source:
    """One recording alone, with the held interval that is given or found."""
    world = CleanRecording(scenario, recording)
    demonstration = to_torso_frame(world) if scenario.recording.frame == "torso" else world
    if held is None and scenario.task.kind == "motion":
        held = (0.0, demonstration.duration_s)
    if held is None:
        holding = grasp_and_release(demonstration, _found_holding(world), scenario.learning.cutoff_hz)
    else:
        if not 0 <= held[0] < held[1] <= demonstration.duration_s:
            raise ScenarioError(
                f"task.held: {held[0]:g} to {held[1]:g} s is not an interval of the recording, which lasts "
                f"{demonstration.duration_s:.2f} s"
            )
        holding = Holding(held[0], held[1], _median_hand_distance(world, held))
    return Source(recording, demonstration, holding, *_dimensions(scenario, world, holding))


def _found_holding(world: Demonstration) -> Holding:
    try:
        return find_holding(world)
    except RecordingError as error:
        raise RecordingError(f"{error}, {MOTION_HINT}") from error


def _learn_together(scenario: Scenario, sources: Sequence[Source]) -> Source:
    """The weighted mean of several sources; frames are put on each other as they are, origin on origin."""
    weights = np.array(scenario.recording.weights or np.ones(len(sources)), dtype=float)
    weights = weights / weights.sum()
    demonstrations = [source.demonstration for source in sources]
    cutoff_hz = scenario.learning.cutoff_hz
    alignment = align(
        demonstrations,
        [source.holding for source in sources],
        weights,
        lead_s=scenario.timing.approach_s,
        trail_s=scenario.timing.retreat_s,
        cutoff_hz=cutoff_hz,
    )

    def mean(name: str) -> float:
        return float(weights @ [getattr(source.dimensions, name) for source in sources])

    widths = [source.dimensions.box_width for source in sources]
    # Either all hold a box or none does.
    width = None if None in widths else float(np.median(widths))
    apart = float(np.median([source.holding.hand_distance for source in sources])) if width is None else width
    uncertainties = [one.uncertainty for one in demonstrations]
    repairs = [one.repairs for one in demonstrations]
    names = dict.fromkeys(name for one in repairs for name in one)
    x = weighted_mean(alignment.shown(demonstrations), weights)
    demonstration = replace(
        demonstrations[0],
        t=alignment.t,
        x=x,
        orientations=mean_orientations(x, demonstrations, alignment.recorded, _starts(sources), weights),
        source=f"mean of {len(sources)}: {'; '.join(source.recording.source for source in sources)}",
        synthetic=any(one.synthetic for one in demonstrations),
        repairs={name: sum(one.get(name, 0) for one in repairs) for name in names},
        # Of a mean of independent errors.
        uncertainty=None
        if any(one is None for one in uncertainties)
        else np.sqrt(np.sum([(w * one) ** 2 for w, one in zip(weights, uncertainties, strict=True)], axis=0)),
        notes=tuple(f"{source.recording.source}: {note}" for source in sources for note in source.demonstration.notes),
    )
    return Source(
        recording=sources[0].recording,
        demonstration=demonstration,
        holding=Holding(alignment.start_s, alignment.end_s, apart),
        dimensions=Dimensions(upper_arm=mean("upper_arm"), forearm=mean("forearm"), box_width=width),
        estimated=tuple(dict.fromkeys(name for source in sources for name in source.estimated)),
        together=Together(
            tuple(sources), weights, alignment, weighted_spread(alignment.shown(demonstrations, cutoff_hz), weights)
        ),
    )


def _starts(sources: Sequence[Source]) -> list[float]:
    return [source.holding.start_s for source in sources]


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
    }
    if scenario.task.kind == "hold":
        wanted["box_width"] = (scenario.box.width, known.box_width, holding.hand_distance)
    estimated = tuple(name for name, (given, before, _) in wanted.items() if given is None and before is None)
    chosen = {
        name: float(given if given is not None else before if before is not None else estimate)
        for name, (given, before, estimate) in wanted.items()
    }
    return Dimensions(**{"box_width": None, **chosen}), estimated
