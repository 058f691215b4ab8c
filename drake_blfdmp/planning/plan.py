"""`MakePlan`: from a scenario to every number a diagram needs."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from drake_blfdmp.errors import TaskError
from drake_blfdmp.planning.scenario import Scenario
from drake_blfdmp.planning.sources import LoadSource, Source
from drake_blfdmp.planning.span import WidestSpan
from drake_blfdmp.planning.squeeze import SqueezeDepth
from drake_blfdmp.planning.supports import LEVEL_WITHIN, Ends, MakeSupports, ShiftForSupports
from drake_blfdmp.planning.task import DEFAULT_SQUEEZE, MakeMotion, MakeTask, Raised, RollOutTask, Shifted, Task
from drake_blfdmp.robot.box import BoxParameters, TableParameters
from drake_blfdmp.robot.clearance import ClearanceChecker
from drake_blfdmp.robot.kinematics import DualArmKinematics
from drake_blfdmp.robot.plant import ARMS, MakeKinematicPlant, ReadJointLimits
from drake_blfdmp.robot.reach import Reach, find_reach, rigid
from drake_blfdmp.robot.retargeting import Retarget, box_pose, hand_line, up_axis
from drake_blfdmp.skill.rollout import Rollout

Progress = Callable[[str, float], None]
"""Called with what is being done and the share of it done, 0 to 1."""

CLEARANCE = 0.008
"""Least distance, m, a plan keeps between bodies that must not touch."""

TRIMS = (1.0, 0.5, 0.0)
"""Shares of the approach and the retreat that are tried, longest first."""


@dataclass(frozen=True)
class Plan:
    """Everything known before the simulation starts.

    Attributes:
        scenario, source, task: what it was made from.
        coupled, uncoupled: the skill rolled out with the scenario's law and without any.
        reach: the retargeting, and how well the arms follow it.
        box: the box.
        start, goal: (7,) X_WB before the grasp and where the plan puts the box.
        tables: what it stands on.
        stretch: how much longer than the person's the motion takes.
        notes: sentences on what was adapted, for people.
    """

    scenario: Scenario
    source: Source
    task: Task
    coupled: Rollout
    uncoupled: Rollout
    reach: Reach
    box: BoxParameters
    start: np.ndarray
    goal: np.ndarray
    tables: list[TableParameters]
    stretch: float
    notes: tuple[str, ...]

    @property
    def retarget(self) -> Retarget:
        """The map from the person to the arms."""
        return self.reach.retarget

    @property
    def settle_s(self) -> float:
        """How long the arms wait at the start, s: the rest in which the skill's initial errors vanish."""
        return self.scenario.timing.rest_s * self.stretch

    @property
    def duration_s(self) -> float:
        """Length of the run, s."""
        return float(self.coupled.t[-1])

    def planned_box(self) -> np.ndarray:
        """X_WB the plan has at every time of the coupled rollout: (N, 7)."""
        grasped, released = self.task.held
        t = np.clip(self.coupled.t, grasped, released)
        index = np.minimum(np.round(t / self.scenario.simulation.skill_time_step).astype(int), len(t) - 1)
        return BelowPalms(box_pose(self.coupled.x, self.retarget), self.scenario.task.grasp_above)[index]


def BelowPalms(pose, above: float) -> np.ndarray:
    """The box's poses (N, 7) when the palms take it `above` its centre, m, from the poses of the palms' middle."""
    lowered = np.array(pose)
    lowered[:, 4:] -= above * up_axis(lowered)
    return lowered


def MakePlan(scenario: Scenario, progress: Progress = lambda what, share: None) -> Plan:
    """Plan the whole run.

    Raises:
        RecordingError, SkillError, ScenarioError, TaskError: one line that says what, where and what to do.
    """
    source = LoadSource(scenario, lambda text: progress(text, 0.0))
    width = source.dimensions.box_width
    squeeze = DEFAULT_SQUEEZE if scenario.task.squeeze is None else scenario.task.squeeze
    if width - 2.0 * squeeze <= 0.02:
        raise TaskError(f"box: {width:.3f} m is too narrow to be squeezed by {squeeze:.3f} m on each side")
    box = BoxParameters(
        width=width,
        depth=scenario.box.depth,
        height=scenario.box.height,
        mass=scenario.box.mass,
        friction=scenario.box.friction,
    )
    plant = MakeKinematicPlant()
    kinematics = DualArmKinematics(plant)
    limits = ReadJointLimits(plant, [plant.GetModelInstanceByName(arm) for arm in ARMS])
    opened, widest = width + 2.0 * scenario.task.clearance, WidestSpan(plant, limits)
    if opened > widest:
        raise TaskError(
            f"box: {width:.2f} m wide, the palms must open to {opened:.2f} m and can be {widest:.2f} m apart at most; "
            "use a narrower box"
        )
    failure, tight = None, None
    # Where the whole recording is held there is nothing to trim.
    whole = source.holding.start_s < 0.1 and source.holding.end_s > source.demonstration.t[-1] - 0.1
    for trim in TRIMS[:1] if whole else TRIMS:
        timing = replace(
            scenario.timing,
            approach_s=trim * scenario.timing.approach_s,
            retreat_s=trim * scenario.timing.retreat_s,
        )
        try:
            plan = _plan(replace(scenario, timing=timing), source, box, plant, kinematics, limits, progress)
            if trim > TRIMS[-1] and not whole:
                _check_clearance(plan)
        except TaskError as error:
            failure = failure or error
            continue
        notes = plan.notes
        if trim < 1.0 and scenario.timing.approach_s + scenario.timing.retreat_s > 0:
            notes = (
                f"only {timing.approach_s:.1f} s before the grasp and {timing.retreat_s:.1f} s after the release are "
                "kept: the rest is out of the arms' easy reach",
                *notes,
            )
        plan = replace(plan, notes=notes, scenario=scenario)
        if plan.reach.comfortable:
            return plan
        tight = tight or plan
    if tight is not None:
        return tight
    raise failure or TaskError("plan: nothing was tried")


def _plan(scenario, source, box, plant, kinematics, limits, progress) -> Plan:
    notes: list[str] = []
    motion = MakeMotion(scenario, source)
    progress("learning the skill", 0.0)
    task = MakeTask(scenario, source, motion)
    progress("learning the skill", 1.0)
    coupled = RollOutTask(scenario, task)
    anchor = _index(coupled, task.held[0])
    same_level = abs(np.subtract(*_heights(coupled, task))) < LEVEL_WITHIN
    reach = _find_reach(scenario, coupled, anchor, kinematics, limits, progress)
    # The shift is known in the world; the skill needs it in the person's frame, so it depends on the scale found.
    for _ in range(2):
        shift = ShiftForSupports(
            _ends(coupled, task, reach.retarget), box, _yaws(coupled, task, reach.retarget), same_level
        )
        change = shift.release + np.asarray(scenario.task.place_offset)
        if same_level:
            change[2] = shift.release[2]
        if not (np.any(np.abs(change) > 1e-5) or shift.raise_by):
            break
        scale = reach.retarget.scale
        window = _shift_window(coupled, task, same_level)
        motion = Raised(Shifted(motion, change / scale, window), shift.raise_by / scale, window)
        if shift.sentence and not notes:
            notes.append(shift.sentence)
        task = MakeTask(scenario, source, motion)
        coupled = RollOutTask(scenario, task)
        if not same_level or np.any(scenario.task.place_offset):
            reach = _find_reach_again(scenario, coupled, anchor, kinematics, limits, progress, reach.retarget)
        scenario = replace(scenario, task=replace(scenario.task, place_offset=[0.0, 0.0, 0.0]))
    stretch = scenario.task.duration_scale or reach.stretch
    if scenario.task.squeeze is None:
        held = (coupled.t[reach.samples] >= task.held[0]) & (coupled.t[reach.samples] <= task.held[1])
        squeeze = SqueezeDepth(plant, reach.following.q[held], scenario.task.squeeze_force)
        scenario = replace(scenario, task=replace(scenario.task, squeeze=squeeze))
        task = MakeTask(scenario, source, motion)
        coupled = RollOutTask(scenario, task)
    swing = np.rad2deg(reach.retarget.swing_out[1])
    if swing < 69.0:
        yaw = np.rad2deg(reach.retarget.yaw[1])
        notes.append(f"elbows' swing limited to {swing:.0f} degrees and the hands' yaw to {yaw:.0f}, to stay in reach")
    if stretch > 1.005:
        notes.append(f"slowed down {stretch:.2f} times, to stay within the joints' speed and acceleration")
    if stretch != 1.0:
        task = MakeTask(scenario, source, motion, stretch)
        coupled = RollOutTask(scenario, task)
    grasped, released = (_index(coupled, t) for t in task.held)
    poses = BelowPalms(box_pose(coupled.x[[grasped, released]], reach.retarget), scenario.task.grasp_above)
    yaws = _yaws(coupled, task, reach.retarget)
    if same_level:
        poses[1, 6] = poses[0, 6]
    ends = [np.append(pose[4:], yaw) for pose, yaw in zip(poses, yaws, strict=True)]
    for pose, what in zip(poses, ("grasp", "release"), strict=True):
        if pose[6] < 0.5 * box.height + 0.05:
            raise TaskError(f"supports: the box would stand below the floor at the {what}; set retarget.world higher")
    return Plan(
        scenario=scenario,
        source=source,
        task=task,
        coupled=coupled,
        uncoupled=RollOutTask(scenario, task, coupled=False),
        reach=reach,
        box=box,
        start=poses[0],
        goal=poses[1],
        tables=MakeSupports(*ends, box, same_level),
        stretch=stretch,
        notes=tuple(notes),
    )


def _check_clearance(plan: Plan) -> None:
    """Refuse a plan whose arms come too close to a table or to the box, before it is carried out."""
    checker = ClearanceChecker(plan.tables, plan.box, max_distance=0.05)
    box = plan.planned_box()
    # The samples were taken before the motion was slowed down; their share of the whole is the same.
    samples = np.minimum((plan.reach.samples * plan.stretch).astype(int), len(box) - 1)
    for k, q in zip(samples, plan.reach.following.q, strict=True):
        distance, names = checker.min_clearance(q, rigid(box[k]))
        if distance < CLEARANCE:
            raise TaskError(
                f"clearance: {names[0]} and {names[1]} come within {1000 * distance:.0f} mm at "
                f"{plan.coupled.t[k]:.1f} s; shorten timing.approach_s and timing.retreat_s, or raise task.grasp_above"
            )


def _find_reach_again(scenario, coupled, anchor, kinematics, limits, progress, before: Retarget) -> Reach:
    """The reach of a motion whose release was moved: the grasp stays where it was if the arms can do that."""
    if np.any(scenario.task.place_offset):
        first = _index(coupled, scenario.timing.rest_s)
        person = 0.5 * (coupled.x[first:, 0] + coupled.x[first:, 3]).mean(axis=0)
        try:
            return _find_reach(
                scenario, coupled, anchor, kinematics, limits, progress, before.scale, before.point(person)
            )
        except TaskError:
            pass  # Out of reach there; another place may do.
    return _find_reach(scenario, coupled, anchor, kinematics, limits, progress, before.scale)


def _find_reach(scenario, coupled, anchor, kinematics, limits, progress, scale=None, world=None) -> Reach:
    config = scenario.retarget
    # The arms join in when the initial errors have vanished; see `Plan.settle_s`.
    first = _index(coupled, scenario.timing.rest_s)
    reach = find_reach(
        coupled.t[first:],
        coupled.x[first:],
        anchor - first,
        kinematics=kinematics,
        limits=limits,
        scale=config.scale if config.scale is not None else scale,
        world=world if config.world is None else np.array(config.world),
        level=config.level,
        elbow_up=config.elbow_up,
        progress=lambda share: progress("finding a reachable place", share),
    )
    return replace(reach, samples=reach.samples + first)


def _index(rollout: Rollout, t: float) -> int:
    return int(np.clip(np.searchsorted(rollout.t, t), 0, len(rollout.t) - 1))


def _middle(rollout: Rollout) -> np.ndarray:
    return 0.5 * (rollout.x[:, 2] + rollout.x[:, 5])


def _heights(rollout: Rollout, task: Task):
    middle = _middle(rollout)
    return tuple(float(middle[_index(rollout, t), 2]) for t in task.held)


def _ends(rollout: Rollout, task: Task, retarget: Retarget) -> Ends:
    first, last = (_index(rollout, t) for t in task.held)
    middle = retarget.point(_middle(rollout)[first : last + 1])
    return Ends(grasp=middle[0], release=middle[-1], top=float(middle[:, 2].max()))


def _yaws(rollout: Rollout, task: Task, retarget: Retarget) -> tuple[float, float]:
    x = rollout.x[[_index(rollout, t) for t in task.held]]
    yaw = hand_line(x, np.zeros_like(x), retarget)[4]
    return float(yaw[0]), float(yaw[1])


def _shift_window(rollout: Rollout, task: Task, same_level: bool) -> tuple[float, float]:
    """When the release may be shifted: the whole carry, or only while the box is above both tables."""
    first, last = (_index(rollout, t) for t in task.held)
    events = task.skill.events
    if same_level:
        return events["grasp_end"], events["release"]
    z = _middle(rollout)[first : last + 1, 2]
    higher = max(z[0], z[-1])
    above = np.flatnonzero(z > higher + 0.5 * (z.max() - higher)) + first
    start, end = float(rollout.t[above[0]]), float(rollout.t[above[-1]])
    return max(start, events["grasp_end"]), min(max(end, start + 0.5), events["release"])
