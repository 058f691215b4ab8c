"""`MakePlan`: from a scenario to every number a diagram needs; here for a box, in `free_plan` for a motion without."""

from dataclasses import replace

import numpy as np

from drake_blfdmp.errors import TaskError
from drake_blfdmp.planning.box_path import UpOverDown
from drake_blfdmp.planning.carried_box import CarriedBox
from drake_blfdmp.planning.carry_height import NOTED, KeptUp, RaisedToLift, carried, hands_middle, rise
from drake_blfdmp.planning.free_plan import MakeFreePlan
from drake_blfdmp.planning.held_squeeze import HeldSqueeze, Way
from drake_blfdmp.planning.moved_carry import CarryEnds, EndYaws, FindReachAgain, HandsMiddle, ShiftWindow
from drake_blfdmp.planning.open_palms import ROOM, CheckOpenPalms
from drake_blfdmp.planning.planned import (
    AdaptationNotes,
    IndexAt,
    Plan,
    Progress,
    TurnNotes,
    YawNotes,
)
from drake_blfdmp.planning.scenario import Scenario
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
from drake_blfdmp.planning.supports import Ends, ShiftForSupports
from drake_blfdmp.planning.task import DEFAULT_SQUEEZE, MakeTask, Raised, RollOutTask, Shifted
from drake_blfdmp.planning.unmoved import MakeUnmoved, Unmoved
from drake_blfdmp.robot.box import BoxParameters
from drake_blfdmp.robot.clearance import ClearanceChecker
from drake_blfdmp.robot.kinematics import DualArmKinematics
from drake_blfdmp.robot.plant import ARMS, MakeKinematicPlant, ReadJointLimits
from drake_blfdmp.robot.reach import CALM, SCALES, Reach, rigid
from drake_blfdmp.robot.retargeting import Retarget
from drake_blfdmp.robot.swivel import wrap
from drake_blfdmp.skill.rollout import Rollout

CLEARANCE = 0.008
"""Least distance, m, a plan keeps between bodies that must not touch."""

RAISED = 0.04
"""How much higher, m, a carry becomes that still has too little room over the tables."""

ROOM_NOTES = (
    "carried straight up, over and straight down, as the person's way leads the box against a table",
    f"carry raised by {1000 * RAISED:.0f} mm to clear the tables",
)
"""What is done, one after the other, where the carried box comes too near to a table."""

YAW_TOLERANCE = np.deg2rad(2.0)
"""How much less than asked for the box may be turned, rad."""

FARTHEST = ("reach", "clearance", "force")
"""Why nothing can be planned, the first to be met first."""

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
    tight = None
    arms = plant, kinematics, limits
    unmoved: dict[float, Unmoved] = {}

    def tried(trim: float, scale: float | None, wide: bool = False) -> Plan:
        timing = replace(
            scenario.timing,
            approach_s=trim * scenario.timing.approach_s,
            retreat_s=trim * scenario.timing.retreat_s,
        )
        trimmed = replace(scenario, timing=timing)
        if trim not in unmoved:
            options = {"calms": CALM[-1:], "wide": True} if wide else {}
            unmoved[trim] = MakeUnmoved(trimmed, source, kinematics, limits, progress, **options)
        plan = _plan(trimmed, source, box, arms, progress, (heed_clearance, heed_force), unmoved[trim], scale, wide)
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

    trims = TRIMS[:1] if whole else TRIMS
    for trim in trims:
        try:
            plan = tried(trim, None)
        except TaskError as error:
            failures.append(error)
            continue
        if plan.reach.comfortable:
            return plan
        tight = tight or plan
    if tight is not None:
        return tight
    # Calmer hands need less room on their tables, and a smaller scale leaves more room for what was moved: the box, and
    # how far its places are moved, keep their size in the world. At last, places are looked for farther around.
    shortest = trims[-1]
    for wide in (False, True):
        # Where the arms get through, another place would not make them stronger.
        if wide and (scenario.retarget.world is not None or any(error.reason == "force" for error in failures)):
            break
        for scale in SCALES if scenario.retarget.scale is None else (scenario.retarget.scale,):
            own = unmoved.get(shortest)
            suits = wide if own is None else scale <= own.reach.retarget.scale  # The person's own motion the arms.
            if not suits:
                continue
            try:
                return tried(shortest, scale, wide)
            except TaskError as error:
                failures.append(error)
            if shortest not in unmoved:
                break
    # What got farthest says most.
    raise max(failures, key=lambda error: FARTHEST.index(error.reason) if error.reason in FARTHEST else -1)


def _plan(scenario, source, box, arms, progress, heed, unmoved: Unmoved, scale: float | None, wide: bool) -> Plan:
    plant, kinematics, limits = arms
    heed_clearance, heed_force = heed
    motion, task, coupled, reach = unmoved.motion, unmoved.task, unmoved.coupled, unmoved.reach
    anchor, same_level, notes = unmoved.anchor, unmoved.same_level, []
    calm = {} if scale is None else {"calms": CALM[-1:], "wide": wide}
    if scale is not None:
        reach = unmoved.at_scale(scenario, kinematics, limits, progress, scale, **calm)
    if yaw := scenario.task.place_rotation[2]:
        turned = (unmoved.not_turned, (task, coupled))
        CheckYaw(yaw, *(EndYaws(rollout, of, reach.retarget)[1] for of, rollout in turned))
    moved = bool(np.any([scenario.task.take_offset, scenario.task.place_offset]))

    def again(coupled: Rollout, before: Retarget, stay: bool) -> Reach:
        return FindReachAgain(scenario, coupled, anchor, kinematics, limits, progress, before, stay=stay, **calm)

    def carried_box(retarget: Retarget) -> CarriedBox:
        return CarriedBox(box, retarget, scenario.task.grasp_above, same_level)

    # The shift is known in the world; the skill needs it in the person's frame, so it depends on the scale.
    take, place = (np.asarray(offset) for offset in (scenario.task.take_offset, scenario.task.place_offset))
    least, raised_by, kept_up = scenario.task.least_lift, 0.0, 0.0
    for trial in range(2):
        ends = CarryEnds(coupled, task, reach.retarget)
        if same_level:
            place[2] = take[2]  # The table's height is the grasp's.
        asked = Ends(ends.grasp + take, ends.release + place, ends.top + max(take[2], place[2]))
        shift = ShiftForSupports(asked, box, EndYaws(coupled, task, reach.retarget), same_level)
        change = shift.release + place - take
        # The law lifts the hands a little more or less than they are taught.
        way = HandsMiddle(coupled)[slice(*(IndexAt(coupled, t) for t in task.held))]
        added = rise(way) - rise(hands_middle(motion)[slice(*carried(motion))])
        scale, window = reach.retarget.scale, ShiftWindow(coupled, task, same_level)
        changed = np.any(np.abs(np.append(change, take)) > 1e-5) or shift.raise_by > 0
        if changed:
            motion = replace(motion, x=motion.x + take / scale)  # And from there to the place, while it is carried.
            motion = Raised(Shifted(motion, change / scale, window), shift.raise_by / scale, window)
        if shift.sentence and trial == 0:
            notes.append(shift.sentence)
        motion, lifted = RaisedToLift(motion, least / scale - added if least else 0.0)
        raised_by += scale * lifted
        if not changed and lifted == 0.0:
            break
        task = MakeTask(scenario, source, motion)
        coupled = RollOutTask(scenario, task)
        if not same_level or moved or lifted * scale > NOTED:
            reach = again(coupled, reach.retarget, moved or trial > 0)
        take, place = np.zeros(3), np.zeros(3)
    if raised_by > NOTED:
        notes.append(f"carry raised by {1000 * raised_by:.0f} mm, to lift the box clearly (task.least_lift)")
    for trial in range(len(ROOM_NOTES) + 1):
        for _ in range(2):  # The skill follows what it is taught not quite.
            held = slice(*(IndexAt(coupled, t) for t in task.held))
            way = reach.retarget.point(HandsMiddle(coupled)[held])
            motion, more = KeptUp(motion, coupled.t[held], way, reach.retarget.scale)
            if more == 0.0:
                break
            kept_up = max(kept_up, more)
            task = MakeTask(scenario, source, motion)
            coupled = RollOutTask(scenario, task)
            reach = again(coupled, reach.retarget, True)
        lacking = carried_box(reach.retarget).lacking_room(task, coupled)
        worst = int(np.argmax(lacking))
        if lacking[worst] <= 0.0 or (trial == len(ROOM_NOTES) and not heed_clearance):
            break
        if trial == len(ROOM_NOTES):
            raise TaskError(
                f"clearance: the carried box would be {1000 * lacking[worst]:.0f} mm too near to a table "
                f"{100 * worst / len(lacking):.0f} % of the way; choose another place with task.place_offset, or a "
                "part that lifts it higher with task.held",
                reason="clearance",
            )
        if trial == 0:
            motion = UpOverDown(motion, ShiftWindow(coupled, task, False))
        else:
            carry = motion.events["grasp_end"], motion.events["release"]
            motion = Raised(motion, RAISED / reach.retarget.scale, carry)
        notes.append(ROOM_NOTES[trial])
        task = MakeTask(scenario, source, motion)
        coupled = RollOutTask(scenario, task)
        reach = again(coupled, reach.retarget, moved)
    if kept_up:
        notes.append(f"carry kept above the tables near its ends, by up to {1000 * kept_up:.0f} mm higher than it was")
    stretch = scenario.task.duration_scale or reach.stretch
    held = (coupled.t[reach.samples] >= task.held[0]) & (coupled.t[reach.samples] <= task.held[1])
    postures = reach.following.q[held]
    compliances = Compliances(plant, postures)
    in_palms = carried_box(reach.retarget)
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
    task, coupled = MakeSteadiedTask(scenario, source, motion, stretch, in_palms.has_room)
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
