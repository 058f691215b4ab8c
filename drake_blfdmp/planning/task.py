"""The task's motion, skill and bands, from a source and a scenario."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.interpolate import make_interp_spline

from drake_blfdmp.demonstration.timing import TaskMotion, free_motion, task_motion
from drake_blfdmp.errors import ScenarioError, SkillError
from drake_blfdmp.planning.scenario import Scenario
from drake_blfdmp.planning.sources import Source
from drake_blfdmp.skeleton import HANDS
from drake_blfdmp.skill.bands import Bands, make_bands
from drake_blfdmp.skill.geometry import link_lengths
from drake_blfdmp.skill.laws import law
from drake_blfdmp.skill.laws.follower import PublishedGains
from drake_blfdmp.skill.laws.gams import GamsGains
from drake_blfdmp.skill.learning import learn_skill
from drake_blfdmp.skill.orientation import roll_out_orientation
from drake_blfdmp.skill.profiles import HandDistance, RecordedDistance, smooth_step, softly_at_least
from drake_blfdmp.skill.reshaper import mobility_from_uncertainty
from drake_blfdmp.skill.rollout import Rollout, roll_out
from drake_blfdmp.skill.sampled import Gains
from drake_blfdmp.skill.skill import Skill

DEFAULT_SQUEEZE = 0.012
"""Depth, m, that is planned with before the arms' stiffness is known."""

FARTHEST = 100.0
"""Coordinates, m, beyond which a motion is none of a person's arms."""

APART_BLEND = 0.02
"""Distance, m, over which hands that come closer than the palms can are led to the least distance."""

CLOSING_SHARE = 0.7
"""Share of the dwell at the grasp in which the hands close; the rest is rest on either side."""


@dataclass(frozen=True)
class Task:
    """A skill with its bands.

    Attributes:
        motion: what the skill was learned from.
        skill, bands: to carry out.
        box_width: m; None in a motion without a box.
    """

    motion: TaskMotion
    skill: Skill
    bands: Bands
    box_width: float | None

    @property
    def held(self) -> tuple[float, float]:
        """When the box is squeezed: from the end of closing to the beginning of opening, s; with a box alone."""
        hands = self.bands.hands
        if not isinstance(hands, HandDistance):
            raise TypeError("in a motion without a box nothing is held")
        return float(hands.close_s + hands.duration_s), float(hands.open_s)


def MakeMotion(scenario: Scenario, source: Source) -> TaskMotion:
    """The source's motion on the task's clock.

    Raises:
        ScenarioError: timing out of range, or too short or too long a motion.
    """
    if scenario.task.kind == "motion":
        start, end = np.clip([source.holding.start_s, source.holding.end_s], *source.demonstration.t[[0, -1]])
        return free_motion(source.demonstration, start, end, scenario.timing, scenario.learning.cutoff_hz)
    motion = task_motion(source.demonstration, source.holding, scenario.timing, scenario.learning.cutoff_hz)
    return Centred(motion if scenario.retarget.pitch else replace(motion, turn=None, levelled=0.0, disagreeing=0.0))


def Centred(motion: TaskMotion) -> TaskMotion:
    """The motion with the hands' middle kept in the box's plane of symmetry before the grasp and after the release.

    A person clears a box with each hand on its own; the law opens both hands by the same amount about their middle. So
    the middle's excursion along the box's width is taken out where the hands are open, for all points alike.
    """
    middle = 0.5 * (motion.x[:, 2] + motion.x[:, 5])
    x = motion.x.copy()
    for event, before in (("grasp", True), ("release_end", False)):
        k = int(np.clip(np.searchsorted(motion.t, motion.events[event]), 0, len(motion.t) - 1))
        line = x[k, 5, :2] - x[k, 2, :2]
        line = line / np.linalg.norm(line)
        excursion = (middle[:, :2] - middle[k, :2]) @ line
        excursion[k:] *= not before
        excursion[:k] *= before
        x[:, :, :2] -= excursion[:, None, None] * line
    return replace(motion, x=x)


def Shifted(motion: TaskMotion, shift, window: tuple[float, float]) -> TaskMotion:
    """The motion with all points moved by `shift` (3,), m, smoothly from the window's first time to its second, s."""
    share = smooth_step((motion.t - window[0]) / (window[1] - window[0]))[0]
    return replace(motion, x=motion.x + share[:, None, None] * np.asarray(shift))


def Raised(motion: TaskMotion, height: float, window: tuple[float, float]) -> TaskMotion:
    """The motion with all points raised by `height`, m, in the middle of a window of times, s, and smoothly back."""
    u = np.clip((motion.t - window[0]) / (window[1] - window[0]), 0.0, 1.0)
    bump = smooth_step(3.0 * u)[0] * smooth_step(3.0 * (1.0 - u))[0]
    return replace(motion, x=motion.x + (height * bump)[:, None, None] * np.array([0.0, 0.0, 1.0]))


def Turned(motion: TaskMotion, yaw: float, window: tuple[float, float]) -> TaskMotion:
    """The motion with all points turned by `yaw`, rad, about the vertical through the hands' middle, as `Shifted`.

    Lengths, the hands' middle and the arms' swivel angles stay as they are: the body walks around the box.
    """
    angle = yaw * smooth_step((motion.t - window[0]) / (window[1] - window[0]))[0][:, None]
    middle = 0.5 * (motion.x[:, None, 2] + motion.x[:, None, 5])
    off, c, s = motion.x - middle, np.cos(angle), np.sin(angle)
    turned = np.stack([c * off[..., 0] - s * off[..., 1], s * off[..., 0] + c * off[..., 1], off[..., 2]], axis=-1)
    return replace(motion, x=middle + turned)


def MakeTask(
    scenario: Scenario, source: Source, motion: TaskMotion, stretch: float = 1.0, least_apart: float = 0.0
) -> Task:
    """Learn the motion and lay the bands around it.

    Args:
        stretch: the skill takes this much longer than the motion.
        least_apart: in a motion without a box the hands' desired distance is no less, m.

    Raises:
        SkillError, ScenarioError: settings that learning or the bands refuse.
    """
    learning, bands = scenario.learning, scenario.bands
    skill = learn_skill(
        motion.t,
        motion.x,
        basis_functions=learning.basis_functions,
        method=learning.method,
        alpha_z=learning.alpha_z,
        events={name: float(t) for name, t in motion.events.items()},
        source=source.demonstration.source,
        spread=MotionSpread(source, motion),
        mobility=Mobility(scenario, source),
        turn=motion.turn,
    )
    if stretch != 1.0:
        skill = replace(skill.with_duration(skill.tau * stretch), alpha_z=skill.alpha_z, beta_z=skill.beta_z)
    width = source.dimensions.box_width
    if width is None:
        hands = RecordedDistance(motion.t * stretch, DesiredApart(motion, least_apart))
    else:
        hands = BoxHands(scenario, skill, width)
    funnel = make_bands(
        source.dimensions.upper_arm,
        source.dimensions.forearm,
        hands,
        bone_half_width=bands.bone_half_width,
        hands_half_width=bands.hands_half_width,
        hands_funnel=bands.hands_funnel,
        rate=bands.rate,
    ).opened_to(skill.start)
    return Task(motion=motion, skill=skill, bands=funnel, box_width=width)


def BoxHands(scenario: Scenario, skill: Skill, width: float) -> HandDistance:
    """Hands that close on a box of a width, m, in the dwell at the grasp and open in that at the release."""
    events = skill.events
    squeeze = DEFAULT_SQUEEZE if scenario.task.squeeze is None else scenario.task.squeeze
    closing = CLOSING_SHARE * (events["grasp_end"] - events["grasp"])
    wait = 0.5 * (events["grasp_end"] - events["grasp"] - closing)
    return HandDistance(
        open_m=width + 2.0 * scenario.task.clearance,
        closed_m=width - 2.0 * squeeze,
        close_s=events["grasp"] + wait,
        open_s=events["release"] + wait,
        duration_s=closing,
    )


def DesiredApart(motion: TaskMotion, least: float) -> np.ndarray:
    """The person's own distance between the hands (N,), m, smoothly kept at `least` or above."""
    return softly_at_least(link_lengths(motion.x)[:, HANDS], least, APART_BLEND)


def MotionSpread(source: Source, motion: TaskMotion) -> np.ndarray | None:
    """Standard deviation over several recordings at the motion's times (N, 6, 3), m; None with one recording."""
    if source.together is None:
        return None
    t, spread = source.demonstration.t, source.together.spread
    return make_interp_spline(t, spread, k=1)(np.clip(motion.recorded, t[0], t[-1]))


def Mobility(scenario: Scenario, source: Source) -> np.ndarray | None:
    """How readily the points give way (6,): given, by the recording's uncertainty, or None: the law's own.

    Raises:
        ScenarioError: the recording's uncertainty is asked for and there is none.
    """
    if scenario.bands.mobility is not None:
        return np.array(scenario.bands.mobility)
    if not scenario.bands.weigh_by_uncertainty:
        return None
    if source.demonstration.uncertainty is None:
        raise ScenarioError(
            "bands.weigh_by_uncertainty: cleaning found no uncertainty of the points; give bands.mobility"
        )
    return mobility_from_uncertainty(source.demonstration.uncertainty)


def LawGains(scenario: Scenario) -> Any:
    """The gains of the scenario's law; None for `none`."""
    if scenario.law == "default":
        return Gains(scenario.gains.k_1, scenario.gains.k_2)
    if scenario.law.startswith("published"):
        return PublishedGains(**vars(scenario.published))
    if scenario.law == "gams":
        return GamsGains(**vars(scenario.gams))
    return None


def RollOutTask(scenario: Scenario, task: Task, *, coupled: bool = True) -> Rollout:
    """The task's skill at the scenario's time step, with the scenario's law or uncoupled, with the tail after it.

    Raises:
        ScenarioError: the gains are not safe at this time step.
        SkillError: the coupled motion grows without bound, as it can with another law than the default.
    """
    step = scenario.simulation.skill_time_step
    gains = LawGains(scenario)
    if isinstance(gains, Gains):
        gains.check(step)
    with np.errstate(over="ignore", invalid="ignore"):  # Said below, in one line.
        rollout = roll_out(
            task.skill,
            time_step=step,
            duration=task.skill.tau + scenario.task.tail,
            bands=task.bands if coupled else None,
            law=law(scenario.law),
            gains=gains if coupled else None,
        )
    near = np.abs(rollout.x).max(axis=(1, 2)) < FARTHEST
    if not near.all():
        raise SkillError(
            f"law {scenario.law}: the coupled motion grows without bound, past {FARTHEST:g} m at "
            f"{rollout.t[np.argmin(near)]:.2f} s; use another law, or other gains or a shorter "
            "simulation.skill_time_step"
        )
    if task.skill.orientation is None:
        return rollout
    turn, turn_rate = roll_out_orientation(task.skill, time_step=step, samples=len(rollout.t))
    return replace(rollout, turn=turn, turn_rate=turn_rate)
