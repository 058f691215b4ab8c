import numpy as np
import pytest
from scipy.interpolate import make_interp_spline

from drake_blfdmp.demonstration.cleaning import clean
from drake_blfdmp.demonstration.holding import Holding
from drake_blfdmp.demonstration.modelled_person import hold_and_place
from drake_blfdmp.demonstration.timing import Timing, rest_to_rest, task_motion
from drake_blfdmp.demonstration.torso_frame import to_torso_frame
from drake_blfdmp.demonstration.virtual_kinect import record_hold_and_place
from drake_blfdmp.errors import SkillError
from drake_blfdmp.skill.basis import activations, centers_and_widths
from drake_blfdmp.skill.canonical import DEFAULT_GAMMA, phase_at
from drake_blfdmp.skill.learning import learn_skill
from drake_blfdmp.skill.regression import locally_weighted, ridge
from drake_blfdmp.skill.rollout import roll_out
from drake_blfdmp.skill.transformation import target_forcing


def rest_to_rest_motion():
    """(t, x): the modelled person's 6 s on a clock that starts and stops smoothly; a primitive starts at rest."""
    t, x = hold_and_place(rate_hz=100.0, duration_s=6.0)
    clock = np.linspace(0.0, 6.6, 661)
    return clock, make_interp_spline(t, x)(rest_to_rest(clock, 6.0, 0.6)[0])


T, X = rest_to_rest_motion()


def error_mm(skill, time_step=0.002):
    r = roll_out(skill, time_step=time_step)
    x = r.x[:: round(0.01 / time_step)]
    return 1e3 * np.sqrt(np.mean(np.sum((x - X) ** 2, axis=-1)))


def test_ridge_recovers_the_weights_that_made_the_target():
    c, h = centers_and_widths(20, DEFAULT_GAMMA)
    s = phase_at(np.linspace(0.0, 1.0, 400), 1.0)
    weights = np.random.default_rng(0).normal(size=(20, 3))
    found = ridge(s, activations(s, c, h) @ weights, c, h, relative_penalty=1e-12)
    np.testing.assert_allclose(found, weights, atol=1e-6)


def test_a_large_penalty_shrinks_the_weights():
    c, h = centers_and_widths(20, DEFAULT_GAMMA)
    s = phase_at(np.linspace(0.0, 1.0, 400), 1.0)
    target = np.sin(9.0 * s)[:, None]
    sizes = [np.linalg.norm(ridge(s, target, c, h, penalty)) for penalty in (1e-9, 1.0, 1e3)]
    assert sizes[0] > 1.2 * sizes[1] > 100 * sizes[2] > 0


def test_locally_weighted_regression_minimises_each_weighted_error():
    c, h = centers_and_widths(10, DEFAULT_GAMMA)
    s = phase_at(np.linspace(0.0, 1.0, 300), 1.0)
    target = np.cos(5.0 * s)[:, None]
    found = locally_weighted(s, target, c, h)
    for k in range(10):
        phi = np.exp(-h[k] * (s - c[k]) ** 2)
        residual = target[:, 0] - found[k, 0] * s
        assert abs(np.sum(phi * s * residual)) < 1e-10  # The derivative of (3) with respect to the weight.


def test_a_rollout_reproduces_the_demonstration():
    assert error_mm(learn_skill(T, X, basis_functions=50)) < 0.15
    assert error_mm(learn_skill(T, X, basis_functions=60)) < 0.08


@pytest.mark.parametrize("seed", range(10))
def test_the_skill_of_the_virtual_kinects_recording_reproduces_its_motion_within_a_tenth_of_a_millimetre(seed):
    recording, _ = record_hold_and_place(seed=seed)
    motion = task_motion(to_torso_frame(clean(recording)), Holding(1.95, 6.1, 0.3), Timing())
    r = roll_out(learn_skill(motion.t, motion.x), time_step=0.002)
    error = r.x[::5][: len(motion.t)] - motion.x
    assert 1e3 * np.sqrt(np.mean(np.sum(error**2, axis=-1))) < 0.1


def test_ridge_reproduces_far_better_than_locally_weighted_regression():
    assert error_mm(learn_skill(T, X)) < 0.05 * error_mm(learn_skill(T, X, method="lwr"))


def test_more_functions_reproduce_better():
    errors = [error_mm(learn_skill(T, X, basis_functions=n)) for n in (10, 20, 40)]
    assert errors[0] > 2 * errors[1] > 4 * errors[2]


def test_the_number_of_functions_grows_with_the_duration():
    assert len(learn_skill(T, X).centers) == 50
    assert len(learn_skill(T * 2.0, X).centers) == 66  # 5 a second of 13.2 s.


def test_few_samples_and_many_functions_do_not_swing_between_the_samples():
    skill = learn_skill(T[::66], X[::66], basis_functions=50)  # 11 samples.
    r = roll_out(skill, time_step=0.01)
    assert np.abs(r.x - X).max() < 0.2


def test_learning_does_not_depend_on_where_time_begins():
    late = learn_skill(T + 100.0, X)
    np.testing.assert_allclose(late.weights, learn_skill(T, X).weights, rtol=1e-5, atol=1e-5)


def test_events_source_start_and_goal_are_kept():
    skill = learn_skill(T, X, events={"grasp": 1.5}, source="here")
    assert skill.events == {"grasp": 1.5} and skill.source == "here"
    np.testing.assert_array_equal(skill.start, X[0])
    np.testing.assert_array_equal(skill.goal, X[-1])
    assert skill.alpha_z == 4 * skill.beta_z == pytest.approx(66.0)


def test_the_fit_of_the_mean_is_the_weighted_fit_of_all():
    """Forcing targets of three motions on one clock, each with its own goal, stacked into one weighted regression."""
    rng = np.random.default_rng(0)
    smooth = [np.sin(2 * np.pi * rng.uniform(0.1, 0.5) * T + rng.uniform(0, 6)) for _ in range(3)]
    motions = [X + 0.03 * wave[:, None, None] * rng.normal(size=(6, 3)) for wave in smooth]
    weights = np.array([0.5, 0.2, 0.3])
    mean = learn_skill(T, np.average(motions, axis=0, weights=weights))
    each = [learn_skill(T, x, alpha_z=mean.alpha_z) for x in motions]

    # The stacked problem, solved by itself: rows times the root of their weight.
    u = np.linspace(0.0, T[-1], len(T))
    design = activations(phase_at(u, mean.tau), mean.centers, mean.widths)
    targets = []
    for x, skill in zip(motions, each, strict=True):
        p, v, a = (make_interp_spline(T, x.reshape(len(T), 18), k=5)(u, order) for order in range(3))
        targets.append(target_forcing(p, v, a, skill.goal.reshape(18), mean.tau, mean.alpha_z, mean.beta_z))
    root = np.sqrt(weights)
    stacked = np.linalg.lstsq(
        np.concatenate([r * design for r in root]),
        np.concatenate([r * target for r, target in zip(root, targets, strict=True)]),
    )[0]
    np.testing.assert_allclose(
        design @ stacked, design @ mean.weights.reshape(-1, 18), atol=2e-3 * np.abs(targets).max()
    )
    np.testing.assert_allclose(mean.start, np.average([s.start for s in each], axis=0, weights=weights), atol=1e-12)
    np.testing.assert_allclose(mean.goal, np.average([s.goal for s in each], axis=0, weights=weights), atol=1e-12)
    average = np.average([s.weights for s in each], axis=0, weights=weights)
    np.testing.assert_allclose(mean.weights, average, atol=1e-6 * np.abs(average).max())


def test_the_spread_is_kept_ten_times_a_second():
    spread = 0.01 * (1.0 + np.sin(T))[:, None, None] * np.ones((6, 3))
    skill = learn_skill(T, X, spread=spread)
    assert skill.spread.shape == (101, 6, 3)
    np.testing.assert_allclose(skill.spread_at(T), spread, atol=1e-5)
    assert len(learn_skill(4.0 * T, X, spread=spread).spread) == 265  # 10 a second of 26.4 s, and one.
    with pytest.raises(SkillError, match="the spread has shape"):
        learn_skill(T, X, spread=spread[:-1])


@pytest.mark.parametrize(
    ("t", "x", "options", "message"),
    [
        (T, X, {"method": "magic"}, "unknown method 'magic'; there are ridge, lwr"),
        (T, X, {"basis_functions": 1}, "at least 2 basis functions"),
        (T[:5], X[:5], {}, "at least 8 samples"),
        (T, X[:, :5], {}, "6 points"),
        (T[::-1], X, {}, "time must increase"),
        (T, np.where(X > 1.0, np.nan, X), {}, "finite"),
    ],
)
def test_bad_input_is_refused(t, x, options, message):
    with pytest.raises(SkillError, match=message):
        learn_skill(t, x, **options)
