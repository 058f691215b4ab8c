"""Where the hands come to rest with the feedback of Gams et al. alone, from simulations of the paper's Fig. 10.

Goals 0.40 m apart, d_d = 0.30 m: "around 0.305 m". `skill.laws.gams.resting_distance` is the closed form.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder

from drake_blfdmp.diagrams.skill import AddSkill
from drake_blfdmp.evaluation.study import Table
from drake_blfdmp.planning.task import Task
from drake_blfdmp.skeleton import HANDS, LINKS
from drake_blfdmp.skill.bands import Bands
from drake_blfdmp.skill.geometry import link_lengths
from drake_blfdmp.skill.laws import gams
from drake_blfdmp.skill.laws.gams import GamsGains, resting_distance
from drake_blfdmp.skill.learning import learn_skill
from drake_blfdmp.skill.profiles import ConstantDistance
from drake_blfdmp.skill.rollout import steps
from drake_blfdmp.skill.skill import Skill

DESIRED, GOALS_APART = 0.3, 0.4
"""d_d and dg, m."""

LASTING = 5.0
"""Simulated time by tau: by then the forcing has decayed to 1e-10 of its weights."""


def pulled_apart(task: Task, alpha_z: float = 48.0) -> tuple[Skill, Bands]:
    """The task's motion learned with this alpha_z, its hands' goals 0.40 m apart, and bands with d_d constant."""
    skill = learn_skill(task.motion.t, task.motion.x, alpha_z=alpha_z)
    goal, left, right = skill.goal.copy(), LINKS[HANDS].a, LINKS[HANDS].b
    middle, line = 0.5 * (goal[left] + goal[right]), goal[right] - goal[left]
    reach = 0.5 * GOALS_APART * line / np.linalg.norm(line)
    goal[left], goal[right] = middle - reach, middle + reach
    return skill.with_goal(goal), replace(task.bands, hands=ConstantDistance(DESIRED))


def resting_distance_simulated(
    task: Task, *, c_k: float = 100.0, alpha_z: float = 48.0, accuracy: float = 1e-8
) -> float:
    """The hands' distance at the end of a simulation of the continuous diagram, m.

    Args:
        c_k: c k; alpha_z: four times beta_z.
        accuracy: of Drake's integrator, which chooses its own steps.
    """
    skill, bands = pulled_apart(task, alpha_z)
    builder = DiagramBuilder()
    systems = AddSkill(builder, skill, bands, law="gams", gains=GamsGains(c_k, 0.0), time_step=0.0)
    simulator = Simulator(builder.Build())
    simulator.get_mutable_integrator().set_target_accuracy(accuracy)
    simulator.AdvanceTo(LASTING * skill.tau)
    context = systems.transformation.GetMyContextFromRoot(simulator.get_context())
    x = systems.transformation.GetOutputPort("position").Eval(context)
    return float(link_lengths(x.reshape(6, 3))[HANDS])


def resting_distance_sampled(task: Task, time_step: float, *, c_k: float = 100.0, alpha_z: float = 48.0) -> float:
    """The same with the discrete systems' arithmetic at this step, s.

    Its offset from the closed form is proportional to the step: the coupling is held beside spring and damper.
    """
    skill, bands = pulled_apart(task, alpha_z)
    samples = round(LASTING * skill.tau / time_step) + 1
    gains = GamsGains(c_k, 0.0)
    last = skill.start
    for sample in steps(skill, time_step=time_step, samples=samples, bands=bands, law=gams, gains=gains):
        last = sample.x
    return float(link_lengths(last)[HANDS])


def resting_distances(task: Task, *, time_steps: Sequence[float], accuracy: float = 1e-8) -> Table:
    """The closed form with beta_z = 12 and c k = 100, the continuous simulation, and a sampled one a step, s."""
    formula = resting_distance(DESIRED, GOALS_APART, 12.0, 100.0)
    sampled = [resting_distance_sampled(task, h) for h in time_steps]
    values = [formula, resting_distance_simulated(task, accuracy=accuracy), *sampled]
    return Table(
        {
            "what": ["closed form", "continuous", *(f"sampled at {1e3 * h:g} ms" for h in time_steps)],
            "resting_distance_m": values,
            "off_the_closed_form_m": [value - formula for value in values],
        }
    )
