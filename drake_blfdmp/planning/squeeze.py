"""How deep the palms must be commanded into the box to press as hard as asked."""

import numpy as np
from pydrake.multibody.plant import MultibodyPlant

from drake_blfdmp.robot.contact import palm_stiffness
from drake_blfdmp.robot.plant import ARMS, DEFAULT_STIFFNESS

LARGEST_FORCE = 70.0
"""Largest planned force of a palm, N: joint 6 carries it on a lever of 0.088 m and has 12 N m."""


def Compliances(plant: MultibodyPlant, postures: np.ndarray) -> np.ndarray:
    """By how much, m/N, both palms together yield along their normals in postures (N, 14): (N,)."""
    context = plant.CreateDefaultContext()
    arms = [plant.GetModelInstanceByName(arm) for arm in ARMS]
    compliance = np.empty(len(postures))
    for k, q in enumerate(postures):
        plant.SetPositions(context, q)
        compliance[k] = sum(1.0 / palm_stiffness(plant, context, arm, DEFAULT_STIFFNESS) for arm in arms)
    return compliance


def SqueezeCompliance(plant: MultibodyPlant, postures: np.ndarray) -> float:
    """The one compliance, m/N, with which a squeeze's force is right on average over postures (N, 14)."""
    return float(1.0 / np.mean(1.0 / Compliances(plant, postures)))


def SqueezeDepth(plant: MultibodyPlant, postures: np.ndarray, force: float) -> float:
    """How deep, m, each palm must be commanded into the box to press with `force`, N, on average over postures (N, 14).

    Both palms yield: the force of a depth d is 2 d / (1/k_left + 1/k_right). Where that would pass LARGEST_FORCE in one
    of the postures, the depth is lowered to it.
    """
    compliance = Compliances(plant, postures)
    return float(min(0.5 * force / np.mean(1.0 / compliance), 0.5 * LARGEST_FORCE * compliance.min()))
