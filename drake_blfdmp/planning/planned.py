"""What a plan is, and what the plans of all kinds of tasks need."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from drake_blfdmp.demonstration.hand_orientation import MOST_DISAGREEMENT
from drake_blfdmp.demonstration.timing import TaskMotion
from drake_blfdmp.planning.scenario import Scenario
from drake_blfdmp.planning.sources import Source
from drake_blfdmp.planning.task import Task
from drake_blfdmp.robot.box import BoxParameters, TableParameters
from drake_blfdmp.robot.kinematics import DualArmKinematics
from drake_blfdmp.robot.led_reach import FREE, find_led_reach
from drake_blfdmp.robot.plant import JointLimits
from drake_blfdmp.robot.reach import find_reach
from drake_blfdmp.robot.reach_evaluation import Reach
from drake_blfdmp.robot.retargeting import Retarget, box_pose, common_roll, up_axis
from drake_blfdmp.robot.yaw_rate import RATE, TURN, yaw_rates
from drake_blfdmp.skill.rollout import Rollout

GENTLE_ENOUGH = 1.05
"""How many times faster than `robot.yaw_rate` has it the yaw may be before a plan says so."""

Progress = Callable[[str, float], None]
"""Called with what is being done and the share of it done, 0 to 1."""


@dataclass(frozen=True)
class Plan:
    """Everything known before the simulation starts.

    Attributes:
        scenario, source, task: what it was made from.
        coupled, uncoupled: the skill rolled out with the scenario's law and without any.
        reach: the retargeting, and how well the arms follow it.
        box: the box; None in a motion without one.
        start, goal: (7,) X_WB before the grasp and where the plan puts the box; None without one.
        tables: what it stands on.
        stretch: how much longer than the person's the motion takes.
        notes: sentences on what was adapted, for people.
        squeeze_compliance: by how much nearer the palms must be commanded for a squeeze, m/N; None without a box.
        squeeze_force: planned of each palm, on average while the box is held, N; None without a box.
    """

    scenario: Scenario
    source: Source
    task: Task
    coupled: Rollout
    uncoupled: Rollout
    reach: Reach
    box: BoxParameters | None
    start: np.ndarray | None
    goal: np.ndarray | None
    tables: list[TableParameters]
    stretch: float
    notes: tuple[str, ...]
    squeeze_compliance: float | None = None
    squeeze_force: float | None = None

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

    @property
    def real_box(self) -> BoxParameters | None:
        """The box that is simulated: `box` but for what `scenario.reality` changes; None without one.

        Raises:
            TaskError: nothing is left of its width.
        """
        if self.box is None:
            return None
        reality = self.scenario.reality
        return replace(
            self.box,
            width=self.box.width + reality.width_error,
            mass=self.box.mass * reality.mass_scale,
            friction=self.box.friction * reality.friction_scale,
        )

    @property
    def push_at_s(self) -> float:
        """When `scenario.reality` pushes an arm, s on the simulation's clock."""
        if self.scenario.reality.push_at is not None:
            return self.scenario.reality.push_at
        return float(np.mean((self.settle_s, self.task.skill.tau) if self.box is None else self.task.held))

    def planned_box(self) -> np.ndarray:
        """X_WB the plan has at every time of the coupled rollout: (N, 7); with a box alone."""
        grasped, released = self.task.held
        t = np.clip(self.coupled.t, grasped, released)
        index = np.minimum(np.round(t / self.scenario.simulation.skill_time_step).astype(int), len(t) - 1)
        poses = box_pose(self.coupled.x, self.retarget, self.coupled.turn)
        return BelowPalms(poses, self.scenario.task.grasp_above)[index]


def BelowPalms(pose, above: float) -> np.ndarray:
    """The box's poses (N, 7) when the palms take it `above` its centre, m, from the poses of the palms' middle."""
    lowered = np.array(pose)
    lowered[:, 4:] -= above * up_axis(lowered)
    return lowered


def FindReach(
    scenario: Scenario,
    coupled: Rollout,
    anchor: int,
    kinematics: DualArmKinematics,
    limits: JointLimits,
    progress: Progress,
    scale: float | None = None,
    world: np.ndarray | None = None,
    *,
    every: int = 1,
    wide: bool = False,
    led: bool = False,
    **options: Any,
) -> Reach:
    """The reach of a rolled-out task, as the scenario's `retarget` asks for it.

    Args:
        anchor: index in the rollout at which the palms' rolls are chosen.
        scale, world: used where the scenario does not give its own.
        every: only each so-manieth sample of the rollout is looked at.
        wide: as of `find_reach`.
        led: the elbows may be led another way than the person's (`find_led_reach`); takes many seconds a scale.
        options: further ones of `find_reach`, or of the other.

    Returns:
        The reach, its samples counted in the rollout.

    Raises:
        TaskError: nothing fits.
    """
    config = scenario.retarget
    # The arms join in when the initial errors have vanished; see `Plan.settle_s`.
    first = IndexAt(coupled, scenario.timing.rest_s)
    if not led:
        options |= {"wide": wide, "keep_yaw": scenario.task.place_rotation[2] != 0.0, "elbow_up": config.elbow_up}
    reach = (find_led_reach if led else find_reach)(
        coupled.t[first::every],
        coupled.x[first::every],
        (anchor - first) // every,
        kinematics=kinematics,
        limits=limits,
        scale=config.scale if config.scale is not None else scale,
        world=world if config.world is None else np.array(config.world),
        level=config.level,
        turn=None if coupled.turn is None else coupled.turn[first::every],
        progress=lambda share: progress("leading the elbows" if led else "finding a reachable place", share),
        **options,
    )
    return replace(reach, samples=every * reach.samples + first)


def IndexAt(rollout: Rollout, t: float) -> int:
    """The index of a rollout's first sample at time t, s, or later."""
    return int(np.clip(np.searchsorted(rollout.t, t), 0, len(rollout.t) - 1))


def AdaptationNotes(retarget: Retarget, stretch: float) -> list[str]:
    """What was taken from the person's motion so that the arms can follow, in sentences."""
    notes, swing, share = [], np.rad2deg(retarget.swing_out[1]), retarget.yaw_share
    if retarget.swing_out == FREE:
        pass  # Said with how the elbows are led.
    elif swing < 69.0:
        most = "" if share == 1.0 else f"{share:.0%} of the person's, at most "
        yaw = f"the hands' yaw to {most}{np.rad2deg(retarget.yaw[1]):.0f}" if share else "the hands' yaw left aside"
        notes.append(f"elbows' swing limited to {swing:.0f} degrees and {yaw}, to stay in reach")
    elif share < 1.0:
        notes.append(f"{share:.0%} of the hands' yaw taken: in the recording it is thrown about")
    if stretch > 1.005:
        notes.append(f"slowed down {stretch:.2f} times, to stay within the joints' speed and acceleration")
    return notes


def YawNotes(coupled: Rollout, retarget: Retarget, stretch: float, since: float) -> list[str]:
    """That the palms' line turns faster than is gentle (`robot.yaw_rate`), in a sentence.

    It does where the arms cannot do with less of the hands' yaw, or where more is asked for.

    Args:
        coupled: the motion at its planned speed.
        retarget: it is mapped by.
        stretch: of the plan, by which the recording is slowed down already.
        since: s, from when on the arms move.
    """
    moving = coupled.t >= since
    rate, turn = yaw_rates(coupled.t[moving], coupled.x[moving], retarget)
    over = max(rate / RATE, np.sqrt(turn / TURN))
    if over <= GENTLE_ENOUGH:
        return []
    return [
        f"the line between the palms turns by up to {rate:.1f} rad/s, changing by up to {turn:.0f} rad/s^2, which "
        f"throws about what they hold; task.duration_scale={stretch * over:.2g} makes it gentle"
    ]


def TurnNotes(motion: TaskMotion, coupled: Rollout, retarget: Retarget) -> list[str]:
    """What was taken from the way the person's hands turned the box, in sentences."""
    if coupled.turn is None and motion.disagreeing > MOST_DISAGREEMENT:
        apart = np.rad2deg(motion.disagreeing)
        return [f"orientations left aside: the hands differ by {apart:.0f} degrees on average in how they turn the box"]
    if coupled.turn is None:
        return []
    notes = []
    if abs(motion.levelled) > np.deg2rad(1.0):
        notes.append(
            f"the hands put the box down turned by {np.rad2deg(motion.levelled):+.0f} degrees about the line between "
            "them; taken out, for it stands on a level table"
        )
    free = replace(retarget, pitch=(np.pi, 2.0 * np.pi))
    asked, kept = (np.abs(common_roll(coupled.turn, np.zeros(3), limits)[0]).max() for limits in (free, retarget))
    if asked - kept > np.deg2rad(1.0):
        notes.append(
            f"the box's turn about the line between the hands limited to {np.rad2deg(kept):.0f} of "
            f"{np.rad2deg(asked):.0f} degrees, to stay in the wrists' reach"
        )
    return notes
