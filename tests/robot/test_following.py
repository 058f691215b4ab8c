"""Paths followed side by side are followed as each alone, and as the running system's tracker follows them."""

import numpy as np

from drake_blfdmp.robot.differential_ik import IkGains
from drake_blfdmp.robot.following import SWIVEL_STEPS, follow, follow_all
from drake_blfdmp.robot.kinematics import DualArmKinematics
from drake_blfdmp.robot.plant import ARMS, JointLimits, MakeKinematicPlant, ReadJointLimits
from drake_blfdmp.robot.posture import palm_rolls, starting_postures
from drake_blfdmp.robot.retargeting import OUTWARD, palm_offsets
from drake_blfdmp.robot.swivel import wrap
from drake_blfdmp.robot.tracking import DualArmTracker

PLANT = MakeKinematicPlant()
LIMITS = ReadJointLimits(PLANT, [PLANT.GetModelInstanceByName(arm) for arm in ARMS])
KINEMATICS = DualArmKinematics(PLANT)
GRASP = np.hstack([palm_offsets(np.zeros(2)), [[-0.15, 0.45, 0.7], [0.15, 0.45, 0.7]]])
ELBOWS = wrap(np.pi - OUTWARD * np.deg2rad(20))


def paths(shifts, samples=8):
    """Starts (M, 14), poses (M, N, 2, 7) and swivels (M, N, 2): palms moved along lines from the grasp."""
    grasps, elbows = np.tile(GRASP, (len(shifts), 1, 1)), np.tile(ELBOWS, (len(shifts), 1))
    starts = np.array(starting_postures(KINEMATICS, LIMITS, grasps, elbows))
    pose = np.tile(grasps[:, None], (1, samples, 1, 1))
    pose[..., :4] = palm_offsets(palm_rolls(KINEMATICS, starts[0], GRASP))
    pose[..., 4:] += np.linspace(0, 1, samples)[:, None, None] * np.asarray(shifts)[:, None, None]
    return starts, pose, np.tile(elbows[:, None], (1, samples, 1))


SHIFTS = [[0.03, 0.05, 0.15], [0.0, 0.6, 0.3], [0.0, 0.0, 0.0], [-0.05, 0.25, 0.45]]


def test_side_by_side_is_as_alone():
    starts, pose, swivel = paths(SHIFTS)
    together = follow_all(KINEMATICS, LIMITS, starts, pose, swivel, give_up=0.02)
    for k, one in enumerate(together):
        alone = follow(KINEMATICS, LIMITS, starts[k], pose[k], swivel[k], give_up=0.02)
        np.testing.assert_allclose(one.q, alone.q, atol=1e-9)
        np.testing.assert_allclose(one.pose_error, alone.pose_error, atol=1e-9)
    assert together[0].pose_error < 1e-4 and together[1].pose_error > 0.02


def test_the_steps_are_the_trackers():
    """Also where limits bind: an arm asked for more than its reach."""
    newton = IkGains(pose=1.0, swivel=1.0, swivel_rate=0.3, limit_gain=1.0, velocity_share=1.0)
    still = JointLimits(LIMITS.lower, LIMITS.upper, np.full(14, np.inf), LIMITS.acceleration, LIMITS.effort)
    tracker = DualArmTracker(KINEMATICS, still, newton)
    starts, pose, swivel = paths([[0.0, 0.35, 0.5], [0.0, 0.6, 0.3]], samples=3)
    for start, poses, swivels in zip(starts, pose, swivel, strict=True):
        found = follow(KINEMATICS, LIMITS, start, poses, swivels, substeps=SWIVEL_STEPS - 1)
        q = start.copy()
        for k in range(len(poses)):
            for _ in range(SWIVEL_STEPS - 1):
                if k:  # The first pose is met already.
                    q = q + tracker.velocity(q, poses[k], np.zeros((2, 6)), swivels[k], np.zeros(2)).velocity
            np.testing.assert_allclose(found.q[k], q, atol=2e-5 if k == 0 else 1e-4)
