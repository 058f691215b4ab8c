"""The plan of a motion without a box: the person's arms, played in one go, as far as two arms with palms can follow.

Nothing is held, so nothing fixes the hands' distance: it is the person's own, or the person's own at the scale of the
motion, whichever the arms reach better. Only where palms would touch it is wider.
"""

import numpy as np

from drake_blfdmp.demonstration.timing import TaskMotion
from drake_blfdmp.planning.planned import AdaptationNotes, FindReach, IndexAt, Plan, Progress, YawNotes
from drake_blfdmp.planning.scenario import Scenario
from drake_blfdmp.planning.sources import Source
from drake_blfdmp.planning.task import APART_BLEND, DesiredApart, MakeMotion, MakeTask, RollOutTask
from drake_blfdmp.robot.kinematics import DualArmKinematics
from drake_blfdmp.robot.plant import ARMS, MakeKinematicPlant, ReadJointLimits
from drake_blfdmp.robot.reach_evaluation import CLEARANCE
from drake_blfdmp.skeleton import HANDS, WRISTS
from drake_blfdmp.skill.geometry import link_lengths
from drake_blfdmp.skill.rollout import Rollout

TRACKING = 0.01
"""How much nearer than planned palms that face each other may come, m."""

ROLLOUT_RATE_HZ, FOLLOWED_RATE_HZ = 50.0, 10.0
"""Samples a second on which reach is looked for, and on which it must have been followed."""

REMEDY = "choose a calmer part with task.held=[begin, end], or give retarget.scale"


def MakeFreePlan(scenario: Scenario, source: Source, progress: Progress = lambda what, share: None) -> Plan:
    """Plan a motion without a box.

    Raises:
        SkillError, ScenarioError, TaskError: one line that says what, where and what to do.
    """
    motion = MakeMotion(scenario, source)
    plant = MakeKinematicPlant()
    limits = ReadJointLimits(plant, [plant.GetModelInstanceByName(arm) for arm in ARMS])
    kinematics = DualArmKinematics(plant)

    scale, hands_scale = None, 1.0
    while True:
        least = LeastApart(scenario, hands_scale)
        progress("learning the skill", 0.0)
        coupled = RollOutTask(scenario, MakeTask(scenario, source, motion, least_apart=least))
        progress("learning the skill", 1.0)
        reach = FindReach(
            scenario,
            coupled,
            CentralSample(coupled, scenario.timing.rest_s),
            kinematics,
            limits,
            progress,
            scale,
            every=max(1, round(1.0 / (ROLLOUT_RATE_HZ * scenario.simulation.skill_time_step))),
            shrink_hands=True,
            sample_rate_hz=FOLLOWED_RATE_HZ,
            remedy=REMEDY,
        )
        # Palms that go a shorter way than the hands clear each other only where the hands stay farther apart.
        if reach.retarget.hands_scale >= hands_scale or NarrowestApart(motion) >= APART_BLEND + LeastApart(
            scenario, reach.retarget.hands_scale
        ):
            break
        scale, hands_scale = reach.retarget.scale, reach.retarget.hands_scale
    stretch = scenario.task.duration_scale or reach.stretch
    progress("learning the skill", 0.0)
    task = MakeTask(scenario, source, motion, stretch, least)
    coupled, uncoupled = RollOutTask(scenario, task), RollOutTask(scenario, task, coupled=False)
    progress("learning the skill", 1.0)
    return Plan(
        scenario=scenario,
        source=source,
        task=task,
        coupled=coupled,
        uncoupled=uncoupled,
        reach=reach,
        box=None,
        start=None,
        goal=None,
        tables=[],
        stretch=stretch,
        notes=(
            *(() if source.together is None else source.together.notes),
            *HandNotes(motion, least, reach.retarget.hands_scale),
            *AdaptationNotes(reach.retarget, stretch),
            *YawNotes(coupled, reach.retarget, stretch, stretch * scenario.timing.rest_s),
        ),
    )


def LeastApart(scenario: Scenario, hands_scale: float) -> float:
    """The hands' least desired distance, m, at which the palms clear each other on their band's lower edge.

    The palms' frames lie on their faces, so palms that face each other clear each other by their distance.
    """
    return (CLEARANCE + TRACKING) / hands_scale + scenario.bands.hands_half_width


def NarrowestApart(motion: TaskMotion) -> float:
    """The person's least distance between the hands, m."""
    return float(link_lengths(motion.x)[:, HANDS].min())


def CentralSample(rollout: Rollout, since: float) -> int:
    """The sample from the time `since`, s, on whose hands are nearest to their median places."""
    first = IndexAt(rollout, since)
    hands = rollout.x[first:, WRISTS]
    off = np.linalg.norm(hands - np.median(hands, axis=0), axis=-1)
    return first + int(np.argmin(off.max(axis=-1)))


def HandNotes(motion: TaskMotion, least: float, hands_scale: float) -> list[str]:
    """What was done to the hands' distance, in sentences."""
    notes, narrowest = [], NarrowestApart(motion)
    raised = float(np.min(DesiredApart(motion, least)))
    if raised > narrowest + 5e-4:
        notes.append(
            f"hands kept at least {raised:.3f} m apart, where the person's come to {narrowest:.3f} m: palms must clear "
            "each other"
        )
    if hands_scale != 1.0:
        notes.append(f"the hands' distance is scaled, too: the palms' is {hands_scale:g} of the person's")
    return notes
