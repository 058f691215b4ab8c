"""Elbows' ways: the cheapest chain of postures, with margin, without a jump, clear of each other and of what stands."""

from itertools import product

import numpy as np
import pytest

from drake_blfdmp.robot import elbow_paths
from drake_blfdmp.robot.box import BoxParameters, TableParameters
from drake_blfdmp.robot.clearance import ClearanceChecker
from drake_blfdmp.robot.elbow_paths import ElbowPaths, Scene
from drake_blfdmp.robot.kinematics import DualArmKinematics
from drake_blfdmp.robot.plant import ARMS, JOINTS_PER_ARM, MakeKinematicPlant, ReadJointLimits
from drake_blfdmp.robot.reach_evaluation import JOINT_MARGIN, kept_limits
from drake_blfdmp.robot.retargeting import palm_offsets
from drake_blfdmp.robot.rigid import rigid
from drake_blfdmp.robot.tracking import rotation_matrix

PLANT = MakeKinematicPlant()
LIMITS = ReadJointLimits(PLANT, [PLANT.GetModelInstanceByName(arm) for arm in ARMS])
KINEMATICS = DualArmKinematics(PLANT)
CLEARANCE = 0.03
COUNT = 25
EASY = np.array([0.0, 0.47, 0.80])


@pytest.fixture(scope="module")
def paths():
    return ElbowPaths(KINEMATICS, kept_limits(LIMITS, KINEMATICS), ClearanceChecker(max_distance=0.1), CLEARANCE)


def way(first, by, apart=0.3, count=COUNT):
    """Palms (count, 2, 7) that face each other about a straight way."""
    pose = np.empty((count, 2, 7))
    pose[..., :4] = palm_offsets(np.zeros(2))
    middles = np.linspace(first, np.add(first, by), count)
    for arm, sign in ((0, -1.0), (1, 1.0)):
        pose[:, arm, 4:] = middles + sign * 0.5 * np.array([apart, 0.0, 0.0])
    return pose


UP = np.full((COUNT, 2), np.pi)  # Elbows straight up.


def evaluated(q):
    return KINEMATICS.chains.evaluate(np.tile([0, 1], len(q)), q.reshape(-1, JOINTS_PER_ARM))


def test_the_palms_are_carried_with_margin_and_clear_without_a_jump(paths):
    pose = way(EASY, [0.1, 0.0, 0.25])
    q = paths.find(pose, UP)
    assert q.shape == (COUNT, 14)
    rotation, position, *_ = evaluated(q)
    np.testing.assert_allclose(position.reshape(-1, 2, 3), pose[..., 4:], atol=1e-9)
    normals = rotation_matrix(pose[..., :4].reshape(-1, 4).T)[:, 2].T
    np.testing.assert_allclose(rotation[..., 2], normals, atol=1e-9)
    assert np.all(q[:, [6, 13]] == 0.0)
    assert np.minimum(q - LIMITS.lower, LIMITS.upper - q).min() >= JOINT_MARGIN
    assert np.abs(np.diff(q, axis=0)).max() < 0.6
    checker = ClearanceChecker(max_distance=0.1)
    assert min(checker.min_clearance(one)[0] for one in q) >= 0.02


def test_elbows_are_near_the_persons_where_they_may(paths, monkeypatch):
    pose = way(EASY, [0.0, 0.0, 0.1])
    asked = np.array([np.pi - 0.5, np.pi + 0.7])
    monkeypatch.setattr(elbow_paths, "AS_THE_PERSON", 10.0)
    psi = evaluated(paths.find(pose, np.tile(asked, (COUNT, 1))))[3].reshape(-1, 2)
    assert np.abs((psi - asked + np.pi) % (2.0 * np.pi) - np.pi).max() < 0.2


def test_palms_out_of_reach_and_arms_that_overlap_have_none(paths):
    out = way(EASY, [0.0, 1.2, 0.0])
    through = way(EASY, np.zeros(3), apart=-0.12)  # The palms behind each other.
    easy = way(EASY, [0.1, 0.0, 0.2])
    for pose in (out, through, out):
        assert paths.find(pose, UP) is None
        assert paths.find(easy, UP) is not None  # Where another failed says nothing of it.
    np.testing.assert_array_equal(paths.may_be(np.array([out, easy, through])), [False, True, True])


def test_a_branch_is_not_left(paths, monkeypatch):
    pose = way(EASY, [0.1, 0.0, 0.2], count=3)
    assert paths.find(pose, UP[:3]) is not None
    monkeypatch.setattr(elbow_paths, "TURN", -1)
    assert paths.find(pose, UP[:3]) is None


@pytest.mark.parametrize("what", ["table", "box"])
def test_what_stands_around_is_kept_clear_of(paths, what):
    """A table, or a box, right where an elbow would be."""
    pose, room = way(EASY, [0.0, 0.0, 0.05]), 0.02
    elbow = np.array([-0.367, 0.043, 1.01])
    there, away = np.tile([1.0, 0, 0, 0, *elbow], (COUNT, 1)), np.tile([1.0, 0, 0, 0, 0.0, 3.0, 3.0], (COUNT, 1))
    table = TableParameters(name="table", top_center=(*elbow[:2], elbow[2] + 0.02), size=(0.1, 0.1))
    box, tables = BoxParameters(width=0.1, depth=0.1, height=0.1), [table] if what == "table" else []
    around, poses = ClearanceChecker(tables, box, among_arms=False), away if what == "table" else there

    def nearest(q):
        return min(around.link_clearances(one, rigid(X))[0] for one, X in zip(q, poses, strict=True))

    assert nearest(paths.find(pose, UP)) < 0.0
    led = paths.find(pose, UP, lambda: Scene(tables, box, poses, room))
    assert nearest(led) >= room
    assert np.abs(np.diff(led, axis=0)).max() < 0.6


def brute_force(samples):
    """The cost of the cheapest chain, of all there are."""
    best = np.inf
    pairs = [list(np.argwhere(sample.free)) for sample in samples]
    for chain in product(*pairs):
        cost = 0.0
        for k, (i, j) in enumerate(chain):
            sample = samples[k]
            cost += sample.costs[0][i] + sample.costs[1][j]
            if k:
                for arm, (a, b) in enumerate(zip(chain[k - 1], (i, j), strict=True)):
                    before = samples[k - 1]
                    turned = abs(before.places[arm][a, 0] - sample.places[arm][b, 0])
                    turned = min(turned, elbow_paths.ANGLES - turned)
                    if turned > elbow_paths.TURN or before.places[arm][a, 1] != sample.places[arm][b, 1]:
                        cost = np.inf
                        break
                    moved = before.postures[arm][a] - sample.postures[arm][b]
                    if np.abs(moved).max() >= np.pi:  # By way of a limit.
                        cost = np.inf
                        break
                    cost += np.sum(moved**2)
        best = min(best, cost)
    return best


def cost_of(samples, chain):
    total = 0.0
    for k, pair in enumerate(chain):
        for arm in (0, 1):
            total += samples[k].costs[arm][pair[arm]]
            if k:
                step = samples[k - 1].postures[arm][chain[k - 1][arm]] - samples[k].postures[arm][pair[arm]]
                total += step @ step
    return total


@pytest.mark.parametrize("seed", range(12))
def test_the_chain_is_the_cheapest(seed):
    rng = np.random.default_rng(seed)
    samples = []
    for _ in range(4):
        counts = rng.integers(2, 5, 2)
        places = [np.stack([rng.integers(0, 6, n), rng.integers(0, 2, n)], axis=-1) for n in counts]
        samples.append(
            elbow_paths._Sample(
                [rng.normal(size=(n, JOINTS_PER_ARM)) for n in counts],
                places,
                [rng.uniform(size=n) for n in counts],
                rng.uniform(size=counts) < 0.7,
            )
        )
    best, chain = brute_force(samples), elbow_paths._chain(samples)
    if np.isinf(best):
        assert len(chain) < len(samples)
    else:
        assert all(elbow_paths._passable(samples, arm) for arm in (0, 1))
        assert all(samples[k].free[pair] for k, pair in enumerate(chain))
        assert cost_of(samples, chain) == pytest.approx(best)


def test_an_arm_that_does_not_get_along_alone_is_found_without_the_other(paths, monkeypatch):
    """Its palm leaves its reach for one sample; the pairs are not even looked at."""
    broken = way(EASY, [0.1, 0.0, 0.25])
    broken[7, 1, 4:] += [0.0, 0.0, 1.5]
    samples = paths._samples(broken, UP)
    assert elbow_paths._passable(samples, 0) and not elbow_paths._passable(samples, 1)
    monkeypatch.setattr(ElbowPaths, "_parted", None)
    assert paths.find(broken, UP) is None
