"""A run that someone looks on at and takes part in: pauses it, moves its goal, pushes what is carried."""

import time
from collections.abc import Callable
from dataclasses import replace

import numpy as np
from pydrake.geometry import Meshcat
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Context, DiagramBuilder

from drake_blfdmp.diagrams.hold_and_place import HoldAndPlace, SkillClock
from drake_blfdmp.diagrams.live import AddLive, LiveSystems
from drake_blfdmp.planning.goal_range import GOAL_STEP, GoalRange
from drake_blfdmp.planning.plan import Plan
from drake_blfdmp.viewing.live_controls import LiveControls, Place

PUSH_N = 20.0
"""How hard a button pushes: to be seen, and what the arms endure while they carry (docs/feedback.md)."""

DIRECTIONS = {"+x": (1.0, 0.0, 0.0), "-x": (-1.0, 0.0, 0.0), "+y": (0.0, 1.0, 0.0), "-y": (0.0, -1.0, 0.0)}
"""What the buttons push along, in W."""

WAIT_S = 0.05
"""Wall time between two looks at the controls of a paused run, s."""

PAUSED = "paused in the live view"

Progress = Callable[[str, float], None]


class LiveSession:
    """The controls of one run and what was done with them.

    Attributes:
        events: (what was done, when on the simulation's clock, s), as reported.
    """

    def __init__(self, meshcat: Meshcat, progress: Progress = lambda what, share: None):
        """Of a viewer that is running; `progress` is told of pauses."""
        self._meshcat, self._progress = meshcat, progress
        self._parts: HoldAndPlace | None = None
        self.events: list[tuple[str, float]] = []
        self._report: Callable[[str, float], None] = lambda name, t: None
        self._speed, self._done_s = 0.0, 0.0
        self._wanted = self._told = np.zeros(3)
        self._offset = np.zeros(3)
        self._pushes: list[str] = []

    def AddToBuilder(
        self, builder: DiagramBuilder, parts: HoldAndPlace, report: Callable[[str, float], None]
    ) -> LiveSystems:
        """Add the systems to a run's diagram, and the controls to its viewer.

        Args:
            report: called with every event and its time.
        """
        self._parts, self._report = parts, report
        self._live = AddLive(builder, parts)
        plan = parts.plan
        goal = _final_middle(plan) if plan.goal is None else np.asarray(plan.goal)[4:]
        place = None
        if plan.goal is not None and plan.box is not None:
            table = goal - [0.0, 0.0, 0.5 * plan.box.height]
            q = plan.goal
            yaw = float(np.arctan2(2.0 * (q[0] * q[3] + q[1] * q[2]), 1.0 - 2.0 * (q[2] ** 2 + q[3] ** 2)))
            place = Place(table, yaw, (plan.box.width, plan.box.depth))
        limits = GoalRange(plan) if self._live.goal is not None else np.zeros((0, 2))
        self._controls = LiveControls(
            self._meshcat,
            goal={axis: (float(goal[k]), *map(float, limits[k])) for k, axis in enumerate("xyz"[: len(limits)])},
            step=GOAL_STEP,
            pushes=[f"push {self._live.pushed} {direction}" for direction in DIRECTIONS],
            place=place,
        )
        self._planned_goal, self._axes = goal, "xyz"[: len(limits)]
        return self._live

    def __call__(self, simulator: Simulator) -> float:
        """Do what the controls ask for; returns after a pause only.

        Returns:
            For how long the run stood still, s of wall time.
        """
        waited = self._pause(simulator)
        context = simulator.get_mutable_context()
        t = context.get_time()
        self._move_goal(context, t)
        for label in self._controls.pushed():
            duration = self._plan.scenario.reality.push_duration
            direction = label.split()[-1]
            # Less a moment, so that it is as many steps of the plant wherever rounding puts their times.
            self._live.Push(context, PUSH_N * np.array(DIRECTIONS[direction]), t + duration - 1e-9)
            self._event(f"{self._live.pushed} pushed {direction} {PUSH_N:g} N", t)
            self._pushes.append(f"{direction} at {t:.1f} s")
        speed = self._controls.speed()
        if speed != self._speed or waited > 0.0:
            self._speed = speed
            simulator.set_target_realtime_rate(speed)
            simulator.ResetStatistics()  # Else it makes up for what it lost.
        return waited

    def Finish(self) -> Plan:
        """Take the controls away.

        Returns:
            The plan with its goal where it was moved to and with notes on what was done by hand; where nothing was,
            the plan as it was.
        """
        self._controls.delete()
        plan, notes, offset = self._plan, [], self._offset
        if offset.any():
            moved = ", ".join(f"{1000 * value:+.0f}" for value in offset[: len(self._axes)])
            notes.append(f"goal moved by hand by ({moved}) mm in {', '.join(self._axes)}")
            if plan.goal is not None:
                plan = replace(plan, goal=plan.goal + np.concatenate([np.zeros(4), offset]))
        if self._pushes:
            notes.append(f"{self._live.pushed} pushed by hand with {PUSH_N:g} N: {', '.join(self._pushes)}")
        return replace(plan, notes=(*plan.notes, *notes)) if notes else plan

    @property
    def _plan(self) -> Plan:
        if self._parts is None:
            raise RuntimeError("AddToBuilder comes before everything else")
        return self._parts.plan

    def _event(self, name: str, t: float) -> None:
        self.events.append((name, t))
        self._report(name, t)

    def _pause(self, simulator: Simulator) -> float:
        if not self._controls.paused():
            return 0.0
        t, since = simulator.get_context().get_time(), time.perf_counter()
        self._event("paused", t)
        while self._controls.paused():
            self._progress(PAUSED, 0.0)
            self._controls.goal_offset()  # Its mark follows its sliders.
            time.sleep(WAIT_S)
        self._event("continued", t)
        return time.perf_counter() - since

    def _move_goal(self, context: Context, t: float) -> None:
        window = self._live.window
        if window is None:
            return
        self._offset = self._live.GoalOffset(context)
        before, self._wanted = self._wanted, self._controls.goal_offset()
        if self._parts is not None and SkillClock(self._parts, context) > window[1]:
            if self._controls.movable:
                self._controls.delete_goal(self._offset)
                if self._offset.any():
                    self._event(f"goal stays at {self._place(self._offset)}", t)
            return
        self._live.MoveGoal(context, self._wanted)
        # A slider that is still being dragged says nothing yet.
        if np.array_equal(self._wanted, before) and not np.array_equal(self._wanted, self._told):
            self._told = self._wanted
            self._event(f"goal moved to {self._place(self._wanted)}", t)

    def _place(self, offset: np.ndarray) -> str:
        where = self._planned_goal + offset
        return ", ".join(f"{axis} {where['xyz'.index(axis)]:.3f}" for axis in self._axes) + " m"


def _final_middle(plan: Plan) -> np.ndarray:
    """Where a motion without a box ends: the middle between the palms (3,), m in W."""
    last = plan.coupled.x[-1]
    return plan.retarget.point(0.5 * (last[2] + last[5]))
