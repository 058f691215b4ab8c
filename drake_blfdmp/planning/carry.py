"""A box's carry on the way to its plan: its ends brought to where the box shall stand, and led clear of the tables."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from drake_blfdmp.demonstration.timing import TaskMotion
from drake_blfdmp.errors import TaskError
from drake_blfdmp.planning.box_path import LedOver, UpOverDown
from drake_blfdmp.planning.carried_box import CarriedBox
from drake_blfdmp.planning.carry_height import NOTED, KeptUp, RaisedToLift, carried, hands_middle, rise
from drake_blfdmp.planning.moved_carry import AboveBoth, CarryEnds, EndYaws, HandsMiddle, ShiftWindow
from drake_blfdmp.planning.planned import IndexAt
from drake_blfdmp.planning.scenario import Scenario
from drake_blfdmp.planning.sources import Source
from drake_blfdmp.planning.supports import Ends, RaiseSentence, ShiftForSupports
from drake_blfdmp.planning.task import MakeTask, Raised, RollOutTask, Shifted, Task
from drake_blfdmp.robot.box import BoxParameters
from drake_blfdmp.robot.reach_evaluation import Reach
from drake_blfdmp.robot.retargeting import Retarget
from drake_blfdmp.skill.rollout import Rollout

RAISED = 0.04
"""How much higher, m, a carry becomes that has too little room over the tables all the same; and how high over the
higher end a box is led over that gets above it nowhere else."""

ROOM_NOTES = (
    "carried straight up, over and straight down, as the person's way leads the box against a table",
    f"carry raised by {1000 * RAISED:.0f} mm to clear the tables",
)
"""What is done, one after the other, where the carried box comes too near to a table."""


@dataclass(frozen=True)
class Carry:
    """A carry so far.

    Attributes:
        motion, task, coupled: what is taught, what is learned from it, and that rolled out.
        reach: of the rollout.
        notes: what was changed, for people.
    """

    motion: TaskMotion
    task: Task
    coupled: Rollout
    reach: Reach
    notes: tuple[str, ...] = ()

    def noted(self, *notes: str) -> "Carry":
        """The same with further notes."""
        return replace(self, notes=(*self.notes, *notes))

    def held_middle(self) -> np.ndarray:
        """The middle between the hands while the box is held (N, 3), m in the torso frame."""
        return HandsMiddle(self.coupled)[self._held()]

    def held_times(self) -> np.ndarray:
        """Its times (N,), s."""
        return self.coupled.t[self._held()]

    def _held(self) -> slice:
        return slice(*(IndexAt(self.coupled, t) for t in self.task.held))


class CarryPlanner:
    """Changes what is taught, and learns and rolls it out anew.

    The shift is known in the world; the skill needs it in the person's frame, so it depends on the scale.
    """

    def __init__(
        self,
        scenario: Scenario,
        source: Source,
        box: BoxParameters,
        same_level: bool,
        find_again: Callable[[Carry, bool], Reach],
    ):
        """Plan carries of a box.

        Args:
            scenario: what is asked.
            source: the recording.
            box: the box.
            same_level: one table serves both ends.
            find_again: `FindReachAgain` of a carry's rollout, and whether it shall stay where its reach has it.
        """
        self._scenario, self._source, self._box, self._same_level = scenario, source, box, same_level
        self._find_again = find_again
        self._moved = bool(np.any([scenario.task.take_offset, scenario.task.place_offset]))

    def in_palms(self, retarget: Retarget) -> CarriedBox:
        """The box in the palms of a retargeted task."""
        return CarriedBox(self._box, retarget, self._scenario.task.grasp_above, self._same_level)

    def taught(self, carry: Carry, motion: TaskMotion) -> Carry:
        """The carry learned from another motion; its reach is still that of the former."""
        task = MakeTask(self._scenario, self._source, motion)
        return replace(carry, motion=motion, task=task, coupled=RollOutTask(self._scenario, task))

    def reached(self, carry: Carry, stay: bool) -> Carry:
        """The carry with the reach of its rollout.

        Raises:
            TaskError: out of reach.
        """
        return replace(carry, reach=self._find_again(carry, stay))

    def moved(self, carry: Carry) -> Carry:
        """The carry with its ends where they are asked for and where the tables have room, lifted as asked.

        Raises:
            TaskError: out of reach.
        """
        scenario, raised_by, raised = self._scenario, 0.0, False
        take, place = (np.asarray(offset) for offset in (scenario.task.take_offset, scenario.task.place_offset))
        for trial in range(2):
            motion, scale = carry.motion, carry.reach.retarget.scale
            ends = CarryEnds(carry.coupled, carry.task, carry.reach.retarget)
            if self._same_level:
                place[2] = take[2]  # The table's height is the grasp's.
            asked = Ends(ends.grasp + take, ends.release + place, ends.top + max(take[2], place[2]))
            yaws = EndYaws(carry.coupled, carry.task, carry.reach.retarget)
            shift = ShiftForSupports(asked, self._box, yaws, self._same_level)
            change = shift.release + place - take
            added = self._rise_added(carry)
            changed = np.any(np.abs(np.append(change, take)) > 1e-5) or shift.raise_by > 0
            if changed:
                window = ShiftWindow(carry.coupled, carry.task, self._same_level)
                motion = replace(motion, x=motion.x + take / scale)  # And from there to the place, while it is carried.
                motion = Raised(Shifted(motion, change / scale, window), shift.raise_by / scale, window)
            if trial == 0 and shift.sentence:
                carry = carry.noted(shift.sentence)
            elif shift.raise_by > NOTED:
                carry = carry.noted(RaiseSentence(shift.raise_by, more=raised))
            raised = shift.raise_by > 0
            least = scenario.task.least_lift
            motion, lifted = RaisedToLift(motion, least / scale - added if least else 0.0)
            raised_by += scale * lifted
            if not changed and lifted == 0.0:
                break
            carry = self.taught(carry, motion)
            if not self._same_level or self._moved or lifted * scale > NOTED:
                carry = self.reached(carry, self._moved or trial > 0)
            take, place = np.zeros(3), np.zeros(3)
        if raised_by > NOTED:
            carry = carry.noted(f"carry raised by {1000 * raised_by:.0f} mm, to lift the box clearly (task.least_lift)")
        return carry

    def _rise_added(self, carry: Carry) -> float:
        """By how much the law lifts the hands more than they are taught, m at the person's scale."""
        return rise(carry.held_middle()) - rise(hands_middle(carry.motion)[slice(*carried(carry.motion))])

    def with_room(self, carry: Carry, heed_clearance: bool) -> Carry:
        """The carry that keeps off the tables: first kept up near its ends, then as `ROOM_NOTES` have it.

        Args:
            carry: the carry.
            heed_clearance: False leaves it as it is where that does not help.

        Raises:
            TaskError: it comes too near all the same, or is out of reach.
        """
        kept_up = 0.0
        for trial in range(len(ROOM_NOTES) + 1):
            for _ in range(2):  # The skill follows what it is taught not quite.
                retarget = carry.reach.retarget
                way = retarget.point(carry.held_middle())
                motion, more = KeptUp(carry.motion, carry.held_times(), way, retarget.scale)
                if more == 0.0:
                    break
                kept_up = max(kept_up, more)
                carry = self.reached(self.taught(carry, motion), True)
            lacking = self.in_palms(carry.reach.retarget).lacking_room(carry.task, carry.coupled)
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
                motion, window = carry.motion, AboveBoth(carry.coupled, carry.task)
                if window is None:
                    motion, window = LedOver(motion, RAISED / carry.reach.retarget.scale)
                motion = UpOverDown(motion, window)
            else:
                window = carry.motion.events["grasp_end"], carry.motion.events["release"]
                motion = Raised(carry.motion, RAISED / carry.reach.retarget.scale, window)
            carry = self.reached(self.taught(carry, motion).noted(ROOM_NOTES[trial]), self._moved)
        if kept_up:
            carry = carry.noted(
                f"carry kept above the tables near its ends, by up to {1000 * kept_up:.0f} mm higher than it was"
            )
        return carry
