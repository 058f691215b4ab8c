"""Capsules' distances against a search over both segments and against Drake where nothing overlaps."""

import numpy as np

from drake_blfdmp.robot.capsules import segment_distances
from drake_blfdmp.robot.clearance import ClearanceChecker
from drake_blfdmp.robot.plant import HOME


def test_segments_against_a_fine_search():
    rng = np.random.default_rng(0)
    ends = rng.uniform(-1.0, 1.0, (200, 4, 3))
    ends[:20, 3] = ends[:20, 2] + ends[:20, 1] - ends[:20, 0]  # Parallel.
    found = segment_distances(*ends.swapaxes(0, 1))
    u = np.linspace(0.0, 1.0, 201)[:, None]
    for (a, b, c, d), distance in zip(ends, found, strict=True):
        one, other = a + u * (b - a), c + u * (d - c)
        searched = np.linalg.norm(one[:, None] - other[None], axis=-1).min()
        assert searched - 0.02 <= distance <= searched + 1e-9


def test_the_nearest_capsules_are_as_far_apart_as_drake_says():
    checker, rng, compared = ClearanceChecker(max_distance=0.5), np.random.default_rng(1), 0
    for _ in range(60):
        q = np.tile(HOME, 2) + rng.uniform(-0.4, 0.4, 14)
        distance, names = checker.min_clearance(q)
        capsules = checker._capsules.distances(checker._plant_context).min()
        if distance > 0.0 and not any("palm" in name or "pedestal" in name for name in names):
            np.testing.assert_allclose(distance, capsules, atol=1e-4)
            compared += 1
        assert capsules >= distance - 1e-4
    assert compared > 5


def test_the_deepest_overlap_is_the_least_of_all_distances():
    checker, rng, overlaps = ClearanceChecker(), np.random.default_rng(2), 0
    for _ in range(40):
        distance, names = checker.min_clearance(np.tile(HOME, 2) + rng.uniform(-0.8, 0.8, 14))
        all_pairs, found = (
            getattr(checker._capsules, name)(checker._plant_context) for name in ("distances", "deepest")
        )
        assert (found is None) == (all_pairs.min() > 0.0)
        if found is not None:
            assert distance == found[0] == all_pairs.min() and all(names)
            overlaps += 1
    assert overlaps > 5


def test_pairs_of_postures_overlap_where_one_after_the_other_does():
    checker, rng = ClearanceChecker(), np.random.default_rng(3)
    left, right = (HOME + rng.uniform(-1.2, 1.2, (count, 7)) for count in (12, 9))
    left[0, [1, 3, 5]] = 1.7, -3.0, 3.7  # Folded into itself.
    found = checker.overlapping(left, right)
    assert found.shape == (12, 9) and found[0].all() and 0.1 < found[1:].mean() < 0.9
    for i, j in np.ndindex(found.shape):
        checker.min_clearance(np.concatenate([left[i], right[j]]))
        assert found[i, j] == (checker._capsules.deepest(checker._plant_context) is not None)
