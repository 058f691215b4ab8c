"""`MakePlan`: from a scenario to every number a diagram needs; here for a box, in `free_plan` for a motion without."""

from dataclasses import replace

import numpy as np

from drake_blfdmp.errors import TaskError
from drake_blfdmp.planning.free_plan import MakeFreePlan
from drake_blfdmp.planning.planned import (
    AdaptationNotes,
    BelowPalms,
    FindReach,
    IndexAt,
    Plan,
    Progress,
    TurnNotes,
)
from drake_blfdmp.planning.scenario import Scenario
from drake_blfdmp.planning.sources import LoadSource
from drake_blfdmp.planning.span import WidestSpan
from drake_blfdmp.planning.squeeze import SqueezeCompliance, SqueezeDepth
from drake_blfdmp.planning.supports import LEVEL_WITHIN, Ends, MakeSupports, ShiftForSupports
from drake_blfdmp.planning.task import DEFAULT_SQUEEZE, MakeMotion, MakeTask, Raised, RollOutTask, Shifted, Task, Turned
from drake_blfdmp.robot.box import BoxParameters
from drake_blfdmp.robot.clearance import ClearanceChecker
from drake_blfdmp.robot.kinematics import DualArmKinematics
from drake_blfdmp.robot.plant import ARMS, MakeKinematicPlant, ReadJointLimits
from drake_blfdmp.robot.reach import Reach, rigid
from drake_blfdmp.robot.retargeting import Retarget, box_pose, hand_line
from drake_blfdmp.robot.swivel import wrap
from drake_blfdmp.skill.rollout import Rollout

CLEARANCE = 0.008
"""Least distance, m, a plan keeps between bodies that must not touch."""

YAW_TOLERANCE = np.deg2rad(2.0)
"""How much less than asked for the box may be turned, rad."""

TRIMS = (1.0, 0.5, 0.0)
"""Shares of the approach and the retreat that are tried, longest first."""


def MakePlan(scenario: Scenario, progress: Progress = lambda what, share: None) -> Plan:
    """Plan the whole run.

    Raises:
        RecordingError, SkillError, ScenarioError, TaskError: one line that says what, where and what to do.
    """
    source = LoadSource(scenario, lambda text: progress(text, 0.0))
    width = source.dimensions.box_width
    if width is None:
        return MakeFreePlan(scenario, source, progress)
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
        notes = plan.notes if source.together is None else (*source.together.notes, *plan.notes)
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
    anchor = IndexAt(coupled, task.held[0])
    same_level = abs(np.subtract(*_heights(coupled, task))) < LEVEL_WITHIN
    yaw = scenario.task.place_rotation[2]
    if yaw:
        before = task, coupled
        motion = Turned(motion, yaw, ShiftWindow(coupled, task, same_level))
        task = MakeTask(scenario, source, motion)
        coupled = RollOutTask(scenario, task)
    reach = FindReach(scenario, coupled, anchor, kinematics, limits, progress)
    if yaw:
        CheckYaw(yaw, *(_yaws(rollout, of, reach.retarget)[1] for of, rollout in (before, (task, coupled))))
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
        window = ShiftWindow(coupled, task, same_level)
        motion = Raised(Shifted(motion, change / scale, window), shift.raise_by / scale, window)
        if shift.sentence and not notes:
            notes.append(shift.sentence)
        task = MakeTask(scenario, source, motion)
        coupled = RollOutTask(scenario, task)
        if not same_level or np.any(scenario.task.place_offset):
            reach = _find_reach_again(scenario, coupled, anchor, kinematics, limits, progress, reach.retarget)
        scenario = replace(scenario, task=replace(scenario.task, place_offset=[0.0, 0.0, 0.0]))
    stretch = scenario.task.duration_scale or reach.stretch
    held = (coupled.t[reach.samples] >= task.held[0]) & (coupled.t[reach.samples] <= task.held[1])
    compliance = SqueezeCompliance(plant, reach.following.q[held])
    if scenario.task.squeeze is None:
        squeeze = SqueezeDepth(plant, reach.following.q[held], scenario.task.squeeze_force)
        scenario = replace(scenario, task=replace(scenario.task, squeeze=squeeze))
        task = MakeTask(scenario, source, motion)
        coupled = RollOutTask(scenario, task)
    notes += [*AdaptationNotes(reach.retarget, stretch), *TurnNotes(motion, coupled, reach.retarget)]
    if stretch != 1.0:
        task = MakeTask(scenario, source, motion, stretch)
        coupled = RollOutTask(scenario, task)
    grasped, released = (IndexAt(coupled, t) for t in task.held)
    # At both ends it stands on a table: turned about the line between the palms by no more than the skill's fit errs.
    poses = BelowPalms(box_pose(coupled.x[[grasped, released]], reach.retarget), scenario.task.grasp_above)
    yaws = _yaws(coupled, task, reach.retarget)
    if same_level:
        poses[1, 6] = poses[0, 6]
    stands = [np.append(pose[4:], yaw) for pose, yaw in zip(poses, yaws, strict=True)]
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
        tables=MakeSupports(*stands, box, same_level),
        stretch=stretch,
        notes=tuple(notes),
        squeeze_compliance=compliance,
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
        first = IndexAt(coupled, scenario.timing.rest_s)
        person = 0.5 * (coupled.x[first:, 0] + coupled.x[first:, 3]).mean(axis=0)
        try:
            return FindReach(
                scenario, coupled, anchor, kinematics, limits, progress, before.scale, before.point(person)
            )
        except TaskError:
            pass  # Out of reach there; another place may do.
    return FindReach(scenario, coupled, anchor, kinematics, limits, progress, before.scale)


def CheckYaw(asked: float, before: float, after: float) -> None:
    """Refuse a turn of the place that the palms' line does not take, rad."""
    reached = float(wrap(after - before))
    if abs(reached - asked) > YAW_TOLERANCE:
        raise TaskError(
            f"task.place_rotation: a yaw of {asked:.2f} rad was asked for, the palms can turn the box by {reached:.2f} "
            "rad of it from where the person puts it; ask for less, or for the other way round"
        )


def _middle(rollout: Rollout) -> np.ndarray:
    return 0.5 * (rollout.x[:, 2] + rollout.x[:, 5])


def _heights(rollout: Rollout, task: Task):
    middle = _middle(rollout)
    return tuple(float(middle[IndexAt(rollout, t), 2]) for t in task.held)


def _ends(rollout: Rollout, task: Task, retarget: Retarget) -> Ends:
    first, last = (IndexAt(rollout, t) for t in task.held)
    middle = retarget.point(_middle(rollout)[first : last + 1])
    return Ends(grasp=middle[0], release=middle[-1], top=float(middle[:, 2].max()))


def _yaws(rollout: Rollout, task: Task, retarget: Retarget) -> tuple[float, float]:
    x = rollout.x[[IndexAt(rollout, t) for t in task.held]]
    yaw = hand_line(x, np.zeros_like(x), retarget)[4]
    return float(yaw[0]), float(yaw[1])


def ShiftWindow(rollout: Rollout, task: Task, same_level: bool) -> tuple[float, float]:
    """When the release may be shifted: the whole carry, or only while the box is above both tables, if it ever is."""
    first, last = (IndexAt(rollout, t) for t in task.held)
    events = task.skill.events
    if same_level:
        return events["grasp_end"], events["release"]
    z = _middle(rollout)[first : last + 1, 2]
    higher = max(z[0], z[-1])
    above = np.flatnonzero(z > higher + 0.5 * (z.max() - higher)) + first
    if len(above) == 0:
        return events["grasp_end"], events["release"]
    start, end = float(rollout.t[above[0]]), float(rollout.t[above[-1]])
    return max(start, events["grasp_end"]), min(max(end, start + 0.5), events["release"])
