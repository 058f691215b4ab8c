"""Wiring of what someone who looks on may do to a run: move its goal, push what is carried."""

from dataclasses import dataclass

import numpy as np
from pydrake.multibody.plant import ExternallyAppliedSpatialForceMultiplexer
from pydrake.systems.framework import Context, DiagramBuilder, System

from drake_blfdmp.diagrams.hold_and_place import HoldAndPlace
from drake_blfdmp.planning.goal_range import GoalWindow
from drake_blfdmp.robot.contact import palm_bodies
from drake_blfdmp.systems.live_goal import LiveGoal
from drake_blfdmp.systems.live_push import LivePush

GOAL_RATE = 0.1
"""How fast the goal may move, m/s: a slider that jumps then asks the arms for less than the carry itself."""


@dataclass(frozen=True)
class LiveSystems:
    """The systems that `AddLive` added; without values at their inputs they change nothing.

    Attributes:
        push: on what is carried or, in a motion without a box, on the palm that `scenario.reality` names.
        pushed: what that is, for people.
        goal: None where there is no time at which the goal may move.
        window: when it may, on the skill's clock, s.
    """

    push: System
    pushed: str
    goal: System | None
    window: tuple[float, float] | None

    def Push(self, context: Context, force, until: float) -> None:
        """Let a force (3,) in W, N, act from now on until a time, s; `context` is the whole diagram's."""
        mine = self.push.GetMyMutableContextFromRoot(context)
        self.push.GetInputPort("push").FixValue(mine, np.append(force, until))

    def MoveGoal(self, context: Context, offset) -> None:
        """Ask for the goal to be an offset (3,), m in W, away from where the plan has it."""
        if self.goal is not None:
            self.goal.GetInputPort("wanted_offset").FixValue(self.goal.GetMyMutableContextFromRoot(context), offset)

    def GoalOffset(self, context: Context) -> np.ndarray:
        """How far the goal is away from where the plan has it: (3,), m in W."""
        if self.goal is None:
            return np.zeros(3)
        return np.array(self.goal.GetOutputPort("offset").Eval(self.goal.GetMyContextFromRoot(context)))


def AddLive(builder: DiagramBuilder, parts: HoldAndPlace) -> LiveSystems:
    """Add a goal that moves between the planned one and the skill, and a push beside what pushes the plant already."""
    plan, skill, plant = parts.plan, parts.skill, parts.plant
    window, goal = GoalWindow(plan), None
    if window is not None:
        goal = builder.AddNamedSystem(
            "live_goal",
            LiveGoal(
                scale=plan.retarget.scale,
                window=window,
                rate=GOAL_RATE,
                tau=plan.task.skill.tau,
                gamma=plan.task.skill.gamma,
                time_step=plan.scenario.simulation.skill_time_step,
            ),
        )
        planned, wanting = skill.goal.get_output_port(), skill.transformation.GetInputPort("goal")
        builder.Disconnect(planned, wanting)
        builder.Connect(planned, goal.GetInputPort("planned_goal"))
        builder.Connect(skill.canonical.GetOutputPort("phase"), goal.GetInputPort("phase"))
        builder.Connect(goal.GetOutputPort("goal"), wanting)
    arm = plan.scenario.reality.push_arm
    body = parts.box or palm_bodies(plant, parts.arms)[("left", "right").index(arm)]
    push = builder.AddNamedSystem("live_push", LivePush(body=body))
    pushes, forces = [push.get_output_port()], plant.get_applied_spatial_force_input_port()
    if builder.HasSubsystemNamed("push"):
        planned_push = builder.GetSubsystemByName("push").get_output_port()
        builder.Disconnect(planned_push, forces)
        pushes.insert(0, planned_push)
    both = builder.AddNamedSystem("pushes", ExternallyAppliedSpatialForceMultiplexer(num_inputs=len(pushes)))
    for i, port in enumerate(pushes):
        builder.Connect(port, both.get_input_port(i))
    builder.Connect(both.get_output_port(), forces)
    return LiveSystems(push, "box" if parts.box is not None else f"{arm} palm", goal, window)
