"""`MakePlan`: from a scenario to every number a diagram needs; here for a box, in `free_plan` for a motion without."""

from dataclasses import replace

import numpy as np

from drake_blfdmp.errors import TaskError
from drake_blfdmp.planning.carry import Carry, CarryPlanner
from drake_blfdmp.planning.followed import DoubtOf
from drake_blfdmp.planning.free_plan import MakeFreePlan
from drake_blfdmp.planning.held_squeeze import HeldSqueeze, Way
from drake_blfdmp.planning.led_elbows import SceneOf, TeachElbows
from drake_blfdmp.planning.moved_carry import EndYaws, FindReachAgain
from drake_blfdmp.planning.open_palms import ROOM, CheckOpenPalms
from drake_blfdmp.planning.planned import (
    AdaptationNotes,
    Plan,
    Progress,
    TurnNotes,
    YawNotes,
)
from drake_blfdmp.planning.scenario import Scenario
from drake_blfdmp.planning.searches import LED, NEAR, SEARCHES, MayBe, Search
from drake_blfdmp.planning.sources import LoadSource
from drake_blfdmp.planning.span import WidestSpan
from drake_blfdmp.planning.squeeze import (
    EVEN,
    UNEVEN,
    AskedSqueeze,
    ChooseSqueeze,
    Compliances,
    RefuseForce,
    SqueezeCompliance,
    Strengths,
)
from drake_blfdmp.planning.steadied_task import MakeSteadiedTask
from drake_blfdmp.planning.task import DEFAULT_SQUEEZE, RollOutTask, Task
from drake_blfdmp.planning.unmoved import MakeUnmoved, Unmoved
from drake_blfdmp.robot.box import BoxParameters
from drake_blfdmp.robot.clearance import ClearanceChecker
from drake_blfdmp.robot.kinematics import DualArmKinematics
from drake_blfdmp.robot.plant import ARMS, MakeKinematicPlant, ReadJointLimits
from drake_blfdmp.robot.reach import SCALES
from drake_blfdmp.robot.reach_evaluation import Reach
from drake_blfdmp.robot.rigid import rigid
from drake_blfdmp.robot.swivel import wrap
from drake_blfdmp.skill.rollout import Rollout

CLEARANCE = 0.008
"""Least distance, m, a plan keeps between bodies that must not touch."""

YAW_TOLERANCE = np.deg2rad(2.0)
"""How much less than asked for the box may be turned, rad."""

FARTHEST = ("reach", "clearance", "force")
"""Why nothing can be planned, the first to be met first."""

LIFT_KEPT = 0.9
"""Of task.least_lift, what must be left of a carry's rise when its hands are steadied."""

WORTH = 0.6
"""Of the scale of a plan whose arms may be held up, that a smaller motion must have to be taken in its place."""

TRIMS = (1.0, 0.5, 0.0)
"""Shares of the approach and the retreat that are tried, longest first."""


def MakePlan(
    scenario: Scenario,
    progress: Progress = lambda what, share: None,
    *,
    heed_clearance: bool = True,
    heed_force: bool = True,
) -> Plan:
    """Plan the whole run.

    Args:
        scenario: what is to be done.
        progress: called with what is being done and the share of it done.
        heed_clearance: False plans what comes too near to the tables, too, to show what would become of it.
        heed_force: False squeezes as hard as is asked, whatever palms and motors bear, for the same reason.

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
    if heed_force:
        RefuseForce(scenario.task, box)
    plant = MakeKinematicPlant()
    kinematics = DualArmKinematics(plant)
    limits = ReadJointLimits(plant, [plant.GetModelInstanceByName(arm) for arm in ARMS])
    opened, widest = width + 2.0 * scenario.task.clearance, WidestSpan(plant, limits)
    if opened > widest:
        raise TaskError(
            f"box: {width:.2f} m wide, the palms must open to {opened:.2f} m and can be {widest:.2f} m apart at most; "
            "use a narrower box",
            reason="reach",
        )
    # Where the whole recording is held there is nothing to trim.
    whole = source.holding.start_s < 0.1 and source.holding.end_s > source.demonstration.t[-1] - 0.1
    failures: list[TaskError] = []
    tight: Plan | None = None
    doubtful: Plan | None = None
    arms = plant, kinematics, limits
    unmoved: dict[float, Unmoved] = {}

    def tried(trim: float, scale: float | None, search: Search = NEAR) -> Plan:
        timing = replace(
            scenario.timing,
            approach_s=trim * scenario.timing.approach_s,
            retreat_s=trim * scenario.timing.retreat_s,
        )
        trimmed = replace(scenario, timing=timing)
        if trim not in unmoved:
            options = {} if scale is None else SEARCHES[search]
            unmoved[trim] = MakeUnmoved(trimmed, source, kinematics, limits, progress, **options)
        plan = _plan(trimmed, source, box, arms, progress, (heed_clearance, heed_force), unmoved[trim], scale, search)
        if heed_clearance and not whole:
            # There is nothing behind the last trim: it may come near, but not touch.
            last = trim == TRIMS[-1]
            if scenario.law != "none":  # What comes of hands that nothing keeps apart is to be seen.
                CheckOpenPalms(plan, 0.0 if last else ROOM)
            _check_clearance(plan, 0.0 if last else CLEARANCE)
        notes = plan.notes if source.together is None else (*source.together.notes, *plan.notes)
        if trim < 1.0 and scenario.timing.approach_s + scenario.timing.retreat_s > 0:
            notes = (
                f"only {timing.approach_s:.1f} s before the grasp and {timing.retreat_s:.1f} s after the release are "
                "kept: the rest is out of the arms' easy reach, or leads them against the box or a table",
                *notes,
            )
        return replace(plan, notes=notes, scenario=scenario)

    def sure(plan: Plan) -> bool:
        """Whether the arms get along it without a throw; the first plan with which they may not is kept."""
        nonlocal doubtful
        doubt = "" if plan.reach.comfortable else DoubtOf(plan, kinematics, limits)
        if doubt and doubtful is None:
            doubtful = replace(plan, notes=(*plan.notes, doubt))
        return not doubt

    trims = TRIMS[:1] if whole else TRIMS
    for trim in trims:
        try:
            plan = tried(trim, None)
        except TaskError as error:
            failures.append(error)
            continue
        if plan.reach.comfortable:
            return plan
        if sure(plan):
            tight = tight or plan
    if tight is not None:
        return tight
    # Calmer hands need less room on their tables, and a smaller scale leaves more room for what was moved: the box, and
    # how far its places are moved, keep their size in the world. Then places are looked for farther around, and at last
    # elbows are led another way than the person's.
    shortest = trims[-1]
    for search in SEARCHES:
        # Where the arms get through, another place would not make them stronger.
        forced = any(error.reason == "force" for error in failures)
        if search != NEAR and (doubtful is not None or forced):
            break
        if not MayBe(search, scenario):
            continue
        for scale in SCALES if scenario.retarget.scale is None else (scenario.retarget.scale,):
            if doubtful is not None and scale < WORTH * doubtful.retarget.scale:
                break
            own = unmoved.get(shortest)
            if own is None and search == NEAR:
                continue
            if own is not None and search != LED and scale > own.reach.retarget.scale:
                continue  # The person's own motion would not suit the arms.
            try:
                plan = tried(shortest, scale, search)
                if sure(plan):
                    return plan
            except TaskError as error:
                failures.append(error)
            if shortest not in unmoved:
                break
    if doubtful is not None:
        return doubtful
    # What got farthest says most.
    raise max(failures, key=lambda error: FARTHEST.index(error.reason) if error.reason in FARTHEST else -1)


def _plan(scenario, source, box, arms, progress, heed, unmoved: Unmoved, scale: float | None, search: Search) -> Plan:
    plant, kinematics, limits = arms
    heed_clearance, heed_force = heed
    motion, task, coupled, reach = unmoved.motion, unmoved.task, unmoved.coupled, unmoved.reach
    anchor, same_level = unmoved.anchor, unmoved.same_level
    options = {} if scale is None else SEARCHES[search]
    if scale is not None:
        reach = unmoved.at_scale(scenario, kinematics, limits, progress, scale, **options)
    if yaw := scenario.task.place_rotation[2]:
        turned = (unmoved.not_turned, (task, coupled))
        CheckYaw(yaw, *(EndYaws(rollout, of, reach.retarget)[1] for of, rollout in turned))

    def again(carry: Carry, stay: bool) -> Reach:
        arms, before = (kinematics, limits), carry.reach.retarget
        around = {"scene": SceneOf(planner, carry, scenario.timing.rest_s)} if search == LED else {}
        return FindReachAgain(scenario, carry.coupled, anchor, *arms, progress, before, stay=stay, **options, **around)

    planner = CarryPlanner(scenario, source, box, same_level, again)
    carry = planner.moved(Carry(motion, task, coupled, reach))
    carry = planner.with_room(carry, heed_clearance)
    if not carry.reach.sound:  # Its place was only assumed, and nothing was changed since (`Unreached`).
        carry = planner.reached(carry, True)
    carry = TeachElbows(planner, carry, scenario.timing.rest_s, kinematics, limits)
    motion, task, coupled, reach, notes = carry.motion, carry.task, carry.coupled, carry.reach, list(carry.notes)
    stretch = scenario.task.duration_scale or reach.stretch
    held = (coupled.t[reach.samples] >= task.held[0]) & (coupled.t[reach.samples] <= task.held[1])
    postures = reach.following.q[held]
    compliances = Compliances(plant, postures)
    in_palms = planner.in_palms(reach.retarget)
    acceleration = in_palms.largest_acceleration(task, coupled) / stretch**2
    if heed_force:
        strengths = [Strengths(plant, postures, box.mass, share) for share in (EVEN, UNEVEN)]
        planned_depth = DEFAULT_SQUEEZE if scenario.task.squeeze is None else scenario.task.squeeze
        evened = compliances if scenario.feedback.hands and scenario.law == "default" else None
        way = Way(plant, postures, planned_depth, scenario.task.grasp_above, acceleration, evened)
        held_squeeze = HeldSqueeze(way, box, scenario.task.force_limit)
        squeeze = ChooseSqueeze(scenario.task, box, compliances, *strengths, acceleration, held_squeeze)
    else:
        squeeze = AskedSqueeze(scenario.task, compliances)
    scenario = replace(scenario, task=replace(scenario.task, squeeze=squeeze.depth))
    notes += squeeze.notes
    notes += [*AdaptationNotes(reach.retarget, stretch), *TurnNotes(motion, coupled, reach.retarget)]

    def lifted(task: Task, coupled: Rollout) -> bool:
        return in_palms.rise(task, coupled) >= LIFT_KEPT * scenario.task.least_lift

    task, coupled = MakeSteadiedTask(scenario, source, motion, stretch, (in_palms.has_room, lifted))
    notes += YawNotes(coupled, reach.retarget, stretch, stretch * scenario.timing.rest_s)
    poses, tables = in_palms.standing(task, coupled)
    for pose, what in zip(poses, ("grasp", "release"), strict=True):
        if pose[6] < 0.5 * box.height + 0.05:
            raise TaskError(
                f"supports: the box would stand below the floor at the {what}; set retarget.world higher",
                reason="clearance",
            )
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
        tables=tables,
        stretch=stretch,
        notes=tuple(notes),
        squeeze_compliance=SqueezeCompliance(compliances),
        squeeze_force=squeeze.force,
    )


def _check_clearance(plan: Plan, least: float) -> None:
    """Refuse a plan whose arms come nearer than `least`, m, to a table or to the box, before it is carried out."""
    checker = ClearanceChecker(plan.tables, plan.box, max_distance=0.05)
    box = plan.planned_box()
    # The samples were taken before the motion was slowed down; their share of the whole is the same.
    samples = np.minimum((plan.reach.samples * plan.stretch).astype(int), len(box) - 1)
    for k, q in zip(samples, plan.reach.following.q, strict=True):
        distance, names = checker.min_clearance(q, rigid(box[k]))
        if distance < least:
            raise TaskError(
                f"clearance: {names[0]} and {names[1]} come within {1000 * distance:.0f} mm at "
                f"{plan.coupled.t[k]:.1f} s; shorten timing.approach_s and timing.retreat_s, or raise task.grasp_above",
                reason="clearance",
            )


def CheckYaw(asked: float, before: float, after: float) -> None:
    """Refuse a turn of the place that the palms' line does not take, rad."""
    reached = float(wrap(after - before))
    if abs(reached - asked) > YAW_TOLERANCE:
        raise TaskError(
            f"task.place_rotation: a yaw of {asked:.2f} rad was asked for, the palms can turn the box by {reached:.2f} "
            "rad of it from where the person puts it; ask for less, or for the other way round",
            reason="reach",
        )
