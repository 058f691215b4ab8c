"""Where the person's elbows bring the arms into each other's way led ones carry the palms, or they are refused."""

import numpy as np
import pytest
from lifted import ANCHOR, TIME, lift_and_carry

from drake_blfdmp.errors import TaskError
from drake_blfdmp.robot.clearance import ClearanceChecker
from drake_blfdmp.robot.elbow_paths import Scene
from drake_blfdmp.robot.kinematics import DualArmKinematics
from drake_blfdmp.robot.led_reach import FREE, find_led_reach, reach_of_led
from drake_blfdmp.robot.plant import ARMS, MakeKinematicPlant, ReadJointLimits
from drake_blfdmp.robot.reach import CENTRE, find_reach
from drake_blfdmp.robot.retargeting import retarget_motion

PLANT = MakeKinematicPlant()
LIMITS = ReadJointLimits(PLANT, [PLANT.GetModelInstanceByName(arm) for arm in ARMS])
KINEMATICS = DualArmKinematics(PLANT)
SEARCH = {"kinematics": KINEMATICS, "limits": LIMITS}
SCALE = 0.7
NARROW = lift_and_carry(width=0.12)


def place(x, shift):
    """Where the person stands so that the middle of the motion is so far, m, from the middle of the arms' space."""
    person, hands = 0.5 * (x[:, 0] + x[:, 3]).mean(axis=0), 0.5 * (x[:, 2] + x[:, 5])
    return CENTRE + shift - SCALE * (0.5 * (hands.min(axis=0) + hands.max(axis=0)) - person)


IN_THE_WAY = place(NARROW, [0.0, -0.35, 0.4])


@pytest.fixture(scope="module")
def led():
    shares = []
    reach = find_led_reach(TIME, NARROW, ANCHOR, scale=SCALE, world=IN_THE_WAY, progress=shares.append, **SEARCH)
    return reach, shares


def test_the_persons_own_elbows_are_in_the_way():
    with pytest.raises(TaskError, match="clearance -0.* m between the arms") as error:
        find_reach(TIME, NARROW, ANCHOR, scale=SCALE, world=IN_THE_WAY, calms=(0.2,), **SEARCH)
    assert error.value.reason == "clearance"


def test_led_ones_are_not_and_the_palms_do_the_same(led):
    reach, shares = led
    assert reach.sound and reach.retarget.scale == SCALE
    np.testing.assert_array_equal(reach.retarget.world, IN_THE_WAY)
    assert (reach.retarget.swing_out, reach.retarget.swing_in) == (FREE, FREE)
    assert shares[-1] == 1.0 and sorted(shares) == shares
    swung = reach.swings.of(TIME, NARROW)[reach.samples]
    assert np.abs(swung - NARROW[reach.samples])[:, [1, 4]].max() > 0.05
    pose, _, swivel, _ = retarget_motion(swung, np.zeros_like(swung), reach.retarget)
    own_pose = retarget_motion(NARROW[reach.samples], np.zeros_like(swung), reach.retarget)[0]
    np.testing.assert_allclose(pose, own_pose, atol=1e-12)
    checker = ClearanceChecker(max_distance=0.1)
    for q, palms, psi in zip(reach.following.q, pose, swivel, strict=True):
        assert checker.min_clearance(q)[0] >= 0.02
        for state, palm, angle in zip(KINEMATICS.evaluate(q), palms, psi, strict=True):
            np.testing.assert_allclose(state.position, palm[4:], atol=2e-3)
            assert abs((state.swivel - angle + np.pi) % (2 * np.pi) - np.pi) < 0.05


def test_without_a_place_and_a_scale_both_are_looked_for():
    reach = find_led_reach(TIME, lift_and_carry(), ANCHOR, **SEARCH)
    assert reach.sound and reach.retarget.scale == 1.0


def test_out_of_reach_is_refused_in_one_line():
    far = place(NARROW, [0.0, 0.9, 0.0])
    with pytest.raises(TaskError, match="no place at scale 0.7 lets arms whose elbows are led") as error:
        find_led_reach(TIME, NARROW, ANCHOR, scale=SCALE, world=far, **SEARCH)
    assert error.value.reason == "reach" and "\n" not in str(error.value)
    with pytest.raises(TaskError, match="no scale from 1 to 0.3"):
        find_led_reach(TIME, lift_and_carry(width=1.9), ANCHOR, **SEARCH)


def test_the_scene_of_each_place_is_asked_for_and_counts(led):
    asked = []

    class Full(Scene):
        """Leaves no room at all."""

        def __init__(self):
            pass

        def cleared(self, k, sample):
            return sample._replace(free=np.zeros_like(sample.free))

    def scene(retarget, samples):
        asked.append((retarget.world, samples))
        return Full()

    with pytest.raises(TaskError):
        find_led_reach(TIME, NARROW, ANCHOR, scale=SCALE, world=IN_THE_WAY, scene=scene, **SEARCH)
    [(world, samples)] = asked
    np.testing.assert_array_equal(world, IN_THE_WAY)
    assert samples[0] == 0 and samples[-1] == len(TIME) - 1 and ANCHOR in samples


def test_another_motion_than_the_one_that_was_led_is_looked_at_anew(led):
    """The person's own elbows, from the same posture: the arms are in each other's way again."""
    reach, _ = led
    grasp = reach.following.q[np.searchsorted(reach.samples, ANCHOR)].copy()
    grasp[[6, 13]] = 0.0
    args = ANCHOR, reach.retarget, grasp, KINEMATICS, LIMITS, None
    assert reach_of_led(TIME, reach.swings.of(TIME, NARROW), *args) is not None
    assert reach_of_led(TIME, NARROW, *args) is None
