"""The most probable skeleton with given bone lengths."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from synthetic_carry import BOX, FOREARM, UPPER_ARM, carry, recording

from drake_blfdmp.demonstration.bones import BONES, link_lengths
from drake_blfdmp.demonstration.cleaning import CleaningOptions, clean
from drake_blfdmp.demonstration.skeleton_fit import chain_covariance, fit_skeleton
from drake_blfdmp.demonstration.uncertainty import SensorError
from drake_blfdmp.demonstration.virtual_kinect import record_hold_and_place
from drake_blfdmp.skeleton import HANDS, WRISTS
from drake_blfdmp.skill.projection import nearest_skeleton

T, X = carry(duration=2.0)
VARIANCES = np.array([1e-4, 7e-4, 13e-4])  # A chain.
ERROR = SensorError(VARIANCES[:, None] * np.ones(len(T)), VARIANCES[:2], np.zeros(2))
LENGTHS = np.array([UPPER_ARM, FOREARM, BOX, FOREARM, UPPER_ARM])


def noisy(seed, size=0.03):
    return X + size * np.random.default_rng(seed).normal(size=X.shape)


@settings(max_examples=20, deadline=None)
@given(seed=st.integers(0, 1000), held=st.booleans())
def test_lengths_are_met_and_free_links_left(seed, held):
    lengths = np.tile(LENGTHS, (len(T), 1))
    if not held:
        lengths[:, HANDS] = np.nan
    y = fit_skeleton(noisy(seed), lengths, chain_covariance(ERROR))
    kept = np.isfinite(lengths)
    np.testing.assert_allclose(link_lengths(y)[kept], lengths[kept], atol=1e-6)


def test_with_errors_of_their_own_it_is_the_nearest_skeleton():
    mobility = np.array([0.2, 0.5, 1.0, 0.2, 0.5, 1.0])
    lengths = np.tile(LENGTHS, (len(T), 1))
    y = fit_skeleton(noisy(1), lengths, np.diag(mobility))
    np.testing.assert_allclose(y, nearest_skeleton(noisy(1), lengths, mobility), atol=1e-5)


def test_it_is_the_most_probable_one():
    """The change is a combination of what lengthens links: no small step along the constraint is more probable."""
    covariance, x = chain_covariance(ERROR), noisy(2)
    y = fit_skeleton(x, np.tile(LENGTHS, (len(T), 1)), covariance)
    force = np.einsum("pq,nqc->npc", np.linalg.inv(covariance), y - x)
    frame, step = 30, 1e-6
    gradient = np.stack(
        [
            (link_lengths(y[frame] + step * e) - link_lengths(y[frame] - step * e)) / (2 * step)
            for e in np.eye(18).reshape(18, 6, 3)
        ]
    )
    _, left, *_ = np.linalg.lstsq(gradient, force[frame].ravel(), rcond=None)
    assert left < 1e-6 * np.sum(force[frame] ** 2)


def test_what_hangs_on_a_bone_moves_with_it():
    x = X.copy()
    x[:, 1:3] -= 0.2 * (X[:, 1] - X[:, 0])[:, None]  # A left upper arm that is a fifth short.
    lengths = link_lengths(X)
    y = fit_skeleton(x, lengths, chain_covariance(ERROR))
    assert np.abs(y - X).max() < 0.5 * np.abs(x - X).max()


def test_contradictions_and_coinciding_points_stay_finite():
    x = X.copy()
    x[3, 1] = x[3, 0]
    lengths = np.tile(LENGTHS, (len(T), 1))
    lengths[:, HANDS] = 5.0
    assert np.isfinite(fit_skeleton(x, lengths, chain_covariance(ERROR))).all()


def test_clean_restores_bones_and_the_hold(person):
    t, truth = person
    gains = []
    for seed in range(3):
        filmed, _ = record_hold_and_place(seed=seed)
        raw = clean(filmed)
        restored = clean(filmed, CleaningOptions(restore_bones=True, restore_hold=True))
        bones = np.broadcast_to([0.22, 0.28, 0.28, 0.22], (len(restored.t), 4))
        np.testing.assert_allclose(link_lengths(restored.x)[:, BONES], bones, atol=1e-6)
        held = (restored.t > 2.6) & (restored.t < 5.5)
        np.testing.assert_allclose(link_lengths(restored.x)[held, HANDS], 0.3, atol=1e-6)
        assert restored.repairs["points_restored"] > 0
        assert "bones restored: upper arms 0.220 m" in " ".join(restored.notes)
        exact = np.stack([np.interp(raw.t, t, c) for c in truth.reshape(len(t), -1).T], -1).reshape(-1, 6, 3)
        before, after = (np.sqrt(np.mean((x - exact)[:, WRISTS] ** 2)) for x in (raw.x, restored.x))
        gains.append(before / after)
    assert np.mean(gains) > 1.2


def test_without_a_hold_it_says_so():
    x, angle = np.repeat(X[:1], 90, axis=0), np.arange(90) / 9.0
    x[:, 5] = x[:, 4] + FOREARM * np.stack([np.sin(angle), np.cos(angle), np.zeros(90)], axis=-1)  # One hand waves.
    demonstration = clean(recording(np.arange(90) / 30.0, x), CleaningOptions(restore_bones=True, restore_hold=True))
    assert "no hold was found" in " ".join(demonstration.notes)


def test_the_covariance_of_a_chain_and_of_a_perfect_sensor():
    covariance = chain_covariance(ERROR)
    near = np.minimum.outer(VARIANCES, VARIANCES)
    np.testing.assert_allclose(covariance[:3, :3], near, atol=2e-8)
    np.testing.assert_allclose(covariance[:3, 3:], 0.0)
    perfect = SensorError(np.zeros((3, 9)), np.zeros(2), np.zeros(2))
    assert np.linalg.eigvalsh(chain_covariance(perfect)).min() > 0
