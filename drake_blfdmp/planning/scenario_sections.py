"""The sections of a scenario: what each key means, and its default.

Lengths are in m, times in s, angles in rad, unless a name says otherwise. None means: found in the recording, or
chosen.
"""

from dataclasses import dataclass, field, fields, make_dataclass

from drake_blfdmp.demonstration.cleaning import CleaningOptions
from drake_blfdmp.demonstration.sensors import SENSORS

SENSOR_NAMES = ("steady", *SENSORS)
"""What can film the modelled person."""

TASK_KINDS = ("hold", "motion")
"""What can be done: hold a box and place it, or move both arms alone."""

_CLEANING = [
    (item.name, item.type, field(default=item.default)) for item in fields(CleaningOptions) if item.name != "up"
]


@dataclass
class CleaningConfig(make_dataclass("_Cleaning", _CLEANING)):  # pyright: ignore[reportGeneralTypeIssues]
    """How recordings are cleaned: the fields of `CleaningOptions` but `up`, which stands in `RecordingConfig`."""


@dataclass
class RecordingConfig:
    """Which recordings, and how to read them.

    Attributes:
        file: path; None films the modelled person with the virtual Kinect.
        also: further recordings of the same task; one skill is learned from all. What is said below holds for all of
            them but `frames` and `body`, which mean `file` alone.
        weights: of `file` and then of each in `also`; None counts all alike.
        format: a reader's name; None detects it from the content.
        frames: first and last frame, inclusive.
        joints: a skeleton point's name -> one column stem, or three columns.
        unit: m, cm or mm.
        time_unit: s, ms, us, 100ns, ns or frames.
        rate_hz: frames a second; counts frames instead of reading the file's clock.
        body: the person's id in a file of several people.
        up: the vertical axis of the file, for example "z", "y" or "-y".
        frame: "torso" lets the person walk away from under the motion, "world" keeps the file's frame.
        cleaning: gaps, jumps, the clock.
    """

    file: str | None = None
    also: list[str] = field(default_factory=list)
    weights: list[float] | None = None
    format: str | None = None
    frames: list[int] | None = None
    joints: dict[str, list[str]] = field(default_factory=dict)
    unit: str | None = None
    time_unit: str | None = None
    rate_hz: float | None = None
    body: str | None = None
    up: str | None = None
    frame: str = "torso"
    cleaning: CleaningConfig = field(default_factory=CleaningConfig)


@dataclass
class SyntheticConfig:
    """The modelled person whom the virtual Kinect films when there is no recording.

    Attributes:
        upper_arm, forearm, box_width: lengths.
        sensor: what films, one of `SENSOR_NAMES`; "steady" is the default `VirtualKinect()`, with a Kinect v1's bones
            and no arm that is lost.
        takes: how often it films; each take has errors of its own, and one skill is learned from all.
        box_pitch: how far the person tips the box in the middle of the carry, about the line between the hands, top
            towards the person; other than 0 the film has the hands' orientations.
    """

    upper_arm: float = 0.22
    forearm: float = 0.28
    box_width: float = 0.30
    sensor: str = "steady"
    takes: int = 1
    box_pitch: float = 0.0


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
    """Desired lengths of the bones, half widths of all bands, (13), (20), and how the points share what is to be done.

    Attributes:
        upper_arm, forearm: desired lengths; None takes the person's.
        bone_half_width, hands_half_width, hands_funnel, rate: the bands'.
        mobility: how readily each point gives way to the default law; only the ratios count. None takes its own.
        weigh_by_uncertainty: let the recording's own uncertainty decide that.
    """

    upper_arm: float | None = None
    forearm: float | None = None
    bone_half_width: float = 0.01
    hands_half_width: float = 0.01
    hands_funnel: float = 0.02
    rate: float = 3.0
    mobility: list[float] | None = None
    weigh_by_uncertainty: bool = False


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
    """What is done.

    Attributes:
        kind: "hold" takes a box and places it; "motion" plays the person's arms without a box, and what is said here
            and in `BoxConfig` of a box has no effect.
        held: beginning and end of the held interval on the recording's clock; None finds it. In a motion: what is
            played; None plays all.
        squeeze_force: how hard the palms press on the box, N, on average; the depth follows from the arms' stiffness.
            None takes what the box needs, and 55 N at least.
        force_limit: how hard a palm may press, N; what would need more is refused.
        squeeze: how far each palm is commanded into the box; None takes what gives `squeeze_force`.
        clearance: distance of each palm from the box while it is open.
        grasp_above: how far above the box's centre the palms take it; it then hangs, and the hands clear the table.
        least_lift: a carry whose hands rise less than this, m, above where they take the box is raised in its middle; 0
            leaves the person's.
        take_offset: the box is taken this much away from where the person took it, (x, y, z) in the robots' world.
        place_offset: the box is put down this much away from where the person put it, (x, y, z) in the robots' world.
        place_rotation: the box is put down turned by this (roll, pitch, yaw) from how the person put it; it stands on a
            level table, so roll and pitch must be 0.
        duration_scale: stretches the motion; None slows it down just as far as the arms need.
        tail: time after the motion's end.
    """

    kind: str = "hold"
    held: list[float] | None = None
    squeeze_force: float | None = None
    force_limit: float = 120.0
    squeeze: float | None = None
    clearance: float = 0.05
    grasp_above: float = 0.02
    least_lift: float = 0.12
    take_offset: list[float] = field(default_factory=lambda: [0.0, 0.0, 0.0])
    place_offset: list[float] = field(default_factory=lambda: [0.0, 0.0, 0.0])
    place_rotation: list[float] = field(default_factory=lambda: [0.0, 0.0, 0.0])
    duration_scale: float | None = None
    tail: float = 0.5


@dataclass
class FeedbackConfig:
    """What the robot's state changes in its motion (`robot.palm_feedback`, `systems.phase_stopping`).

    Attributes:
        hands: close the default law's loop on the hands around the palms' real distance and force.
        rate: of the filter of that, 1/s.
        largest: errors of the distance beyond it count as it, m.
        contact_force: from which on the palms count as touching, N.
        tempo: slow the skill's clock where the joints' limits ask for it.
        phase_stopping: slow it where the palms are off their way.
        slack, scale: tracking error that costs no time, and by how much more the tempo is halved, m.
    """

    hands: bool = True
    rate: float = 12.0
    largest: float = 0.03
    contact_force: float = 10.0
    tempo: bool = True
    phase_stopping: bool = True
    slack: float = 0.006
    scale: float = 0.01


@dataclass
class RealityConfig:
    """How the simulated world differs from what the plan believes; by default in nothing.

    Attributes:
        mass_scale, friction_scale: of the box.
        width_error: how much wider the box is.
        stiffness_scale: of the arms' joint PD; its damping changes with the square root.
        push_arm: "left" or "right": whose palm is pushed.
        push_force: (x, y, z) in the robots' world, N; 0 pushes nothing.
        push_at: when, on the simulation's clock; None: halfway through the hold or, without a box, through the motion.
        push_duration: for how long.
    """

    mass_scale: float = 1.0
    friction_scale: float = 1.0
    width_error: float = 0.0
    stiffness_scale: float = 1.0
    push_arm: str = "left"
    push_force: list[float] = field(default_factory=lambda: [0.0, 0.0, 0.0])
    push_at: float | None = None
    push_duration: float = 0.2


@dataclass
class RetargetConfig:
    """From the person to the arms; None is chosen so that the whole motion is reachable with margin.

    Attributes:
        scale: of the person's motion.
        world: where the shoulders' midpoint goes.
        level: keep the line between the palms horizontal.
        pitch: turn what is held about the line between the hands as the recording's hand orientations say, if any do.
        elbow_up: mirror the elbows to above the line from shoulder to wrist.
        redundancy: what the arms' seventh joint is for while they move: "swivel", "none" or "published".
        clearance: distance that the moving arms keep from themselves and each other, m; None: not looked at.
    """

    scale: float | None = None
    world: list[float] | None = None
    level: bool = True
    pitch: bool = True
    elbow_up: bool = True
    redundancy: str = "swivel"
    clearance: float | None = 0.01


@dataclass
class RobustnessConfig:
    """The study of success under variation; without effect elsewhere.

    Attributes:
        tasks: law -> how many of the random tasks it is tried on, the first ones of the seed.
        harder: how many tasks from wider ranges, in which much cannot be done, are planned for a sample of refusals.
        refusals: how many refused tasks, at most, are looked at once more, whether the refusal was right.
        timeout_s: wall time after which a trial is given up.
        results: file of results, which are added to, and not made again where they are there; None: a new one in the
            study's folder.
    """

    tasks: dict[str, int] = field(default_factory=lambda: {"default": 24, "published": 6, "gams": 6, "none": 6})
    harder: int = 0
    refusals: int = 6
    timeout_s: float = 900.0
    results: str | None = None


@dataclass
class SimulationConfig:
    """Steps and rates: `time_step` of the plant, `skill_time_step` of the skill and the inverse kinematics.

    `visuals`: what the arms look like, one of `robot.meshes.VISUALS`.
    """

    time_step: float = 0.002
    skill_time_step: float = 0.004
    record_rate_hz: float = 100.0
    scene_rate_hz: float = 24.0
    visuals: str = "primitive"
