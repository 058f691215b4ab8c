"""How far apart two arms' palms can be while they face each other: a bound that needs no search."""

import numpy as np
from pydrake.multibody.plant import MultibodyPlant

from drake_blfdmp.robot.plant import ARMS, JointLimits, ReadJointLimits


def WidestSpan(plant: MultibodyPlant, limits: JointLimits | None = None) -> float:
    """No posture has its palms farther apart than this while they face each other, m.

    Each wrist lies behind its palm by a length d along the palm's normal and no farther from its shoulder than the
    straightest elbow allows, L; the shoulders are s apart. So the palms' distance is at most s + 2 L - 2 d.

    Args:
        plant: both arms and nothing else that moves, finalized.
        limits: of their joints.
    """
    context = plant.CreateDefaultContext()
    arms = [plant.GetModelInstanceByName(arm) for arm in ARMS]
    limits = limits or ReadJointLimits(plant, arms)
    straight = np.zeros(14)
    straight[[3, 10]] = limits.upper[[3, 10]]  # The fourth joint alone decides how far the wrist is from the shoulder.
    plant.SetPositions(context, straight)
    shoulders, span = [], 0.0
    for arm in arms:
        palm, wrist, shoulder = (
            plant.GetFrameByName(name, arm).CalcPoseInWorld(context) for name in ("palm", "wrist", "shoulder")
        )
        behind = np.asarray((palm.inverse() @ wrist).translation())[2]  # The normal is the palm's z axis.
        span += float(np.linalg.norm((shoulder.inverse() @ wrist).translation())) + float(behind)
        shoulders.append(np.asarray(shoulder.translation()))
    return span + float(np.linalg.norm(shoulders[1] - shoulders[0]))
