"""(14)-(17) and Remark 2: intervals, their common result, and who follows whom."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from drake_blfdmp.skeleton import ELBOWS, HANDS, SHOULDERS, WRISTS
from drake_blfdmp.skill.bands import make_bands
from drake_blfdmp.skill.geometry import link_lengths
from drake_blfdmp.skill.laws.follower import PublishedGains, follower_acceleration
from drake_blfdmp.skill.laws.primitive import Primitive
from drake_blfdmp.skill.laws.published import as_follower, published
from drake_blfdmp.skill.laws.published_lagged import as_lagged, published_lagged
from drake_blfdmp.skill.laws.published_loop import as_loop, published_loop
from drake_blfdmp.skill.laws.rounds import (
    BETWEEN_HANDS,
    FOREARMS,
    OTHER_WRISTS,
    UPPER_ARMS,
    Interval,
    common,
    interval,
    two_rounds,
)
from drake_blfdmp.skill.profiles import ConstantDistance

# Arms straight ahead, bones exact, hands 0.30 m apart: all five conditions hold in their middle.
FITTING = np.array(
    [[-0.15, 0, 1.4], [-0.15, 0.22, 1.4], [-0.15, 0.5, 1.4], [0.15, 0, 1.4], [0.15, 0.22, 1.4], [0.15, 0.5, 1.4]]
)
BANDS = make_bands(0.22, 0.28, ConstantDistance(0.3)).evaluate(100.0)
GAINS, TAU = PublishedGains(), 4.0
STILL = np.zeros((6, 3))
# The same, turned so that every axis has its share of every link, and a hair off the middle, so that no two bounds tie.
TURNED = Rotation.from_euler("xyz", [0.6, -0.5, 0.7]).apply(FITTING) + 1e-9 * np.random.default_rng(0).normal(
    size=(6, 3)
)


def random_state(seed, batch=()):
    rng = np.random.default_rng(seed)
    x = FITTING + 0.02 * rng.normal(size=(*batch, 6, 3))
    return x, *(scale * rng.normal(size=(*batch, 6, 3)) for scale in (0.2, 1.0, 1.0))


def given(x, velocity, nominal, previous, reading=as_follower, bands=BANDS):
    return two_rounds(x, velocity, nominal, previous, bands, TAU, GAINS, reading)


@pytest.mark.parametrize(
    ("own", "partner", "link", "length"),
    [
        (WRISTS, ELBOWS, FOREARMS, 0.28),
        (ELBOWS, SHOULDERS, UPPER_ARMS, 0.22),
        (WRISTS, OTHER_WRISTS, BETWEEN_HANDS, 0.3),
    ],
)
def test_an_interval_is_the_distance_decomposed_to_axes(own, partner, link, length):
    """x_partner - d n +- sigma / sqrt(3); a point in the middle of all three has the desired distance."""
    x, velocity, acceleration, _ = random_state(1, (4,))
    bounds = interval(own, partner, link, x, velocity, acceleration, BANDS)
    np.testing.assert_allclose(bounds.upper - bounds.lower, 2 * 0.01 / np.sqrt(3), rtol=1e-9)
    middle = 0.5 * (bounds.lower + bounds.upper)
    np.testing.assert_allclose(np.linalg.norm(x[:, partner] - middle, axis=-1), length, rtol=1e-12)
    np.testing.assert_array_equal(bounds.velocity, velocity[:, partner])
    np.testing.assert_array_equal(bounds.acceleration, acceleration[:, partner])


def test_the_decomposition_is_sufficient_for_the_distance():
    """Fact 4: any own point inside the three intervals of a direction n has its distance inside d +- sigma."""
    rng = np.random.default_rng(2)
    n = rng.normal(size=(5000, 3))
    n /= np.linalg.norm(n, axis=-1, keepdims=True)
    own = -0.28 * n + 0.01 / np.sqrt(3) * rng.uniform(-1, 1, size=(5000, 3))
    assert np.abs(np.linalg.norm(own, axis=-1) - 0.28).max() <= 0.01 + 1e-12


def one(lower, upper, velocity, acceleration=0.0):
    return Interval(*(np.array([[[value] * 3] * 2]) for value in (lower, upper, velocity, acceleration)))


def first_of(bounds):
    return [float(value[0, 0, 0]) for value in (bounds.lower, bounds.upper, bounds.velocity, bounds.acceleration)]


def test_the_common_result_is_the_overlap_carried_by_those_who_bound_it():
    bounds, empty = common(one(0.0, 1.0, 2.0, 6.0), one(0.4, 1.7, 4.0, 8.0), widen=True)
    assert first_of(bounds) == [0.4, 1.0, 3.0, 7.0] and not empty.any()
    bounds, _ = common(one(0.0, 1.0, 2.0), one(0.4, 0.7, 4.0), widen=True)
    assert first_of(bounds) == [0.4, 0.7, 4.0, 0.0]


@pytest.mark.parametrize(("second", "half"), [((1.5, 1.9), [0.5, 1.0]), ((-2.0, -0.2), [0.0, 0.5])])
def test_without_overlap_the_hands_band_is_widened_and_the_bone_stays(second, half):
    bounds, empty = common(one(0.0, 1.0, 2.0), one(*second, 4.0), widen=True)
    assert first_of(bounds)[:3] == [*half, 3.0] and empty.all()


@pytest.mark.parametrize("second", [(1.5, 1.9), (-2.0, -0.2)])
def test_without_overlap_two_bones_meet_in_the_gap(second):
    bounds, empty = common(one(0.0, 1.0, 2.0), one(*second, 4.0), widen=False)
    gap = [1.0, 1.5] if second[0] > 1 else [-0.2, 0.0]
    assert first_of(bounds)[:3] == [*gap, 3.0] and empty.all()


def test_where_all_conditions_hold_everybody_moves_as_one():
    """In the middle of every interval, all points at one velocity: the followers take their partners' acceleration."""
    velocity = np.tile([0.3, -0.1, 0.2], (6, 1))
    together = np.tile([0.5, 0.2, -0.7], (6, 1))
    np.testing.assert_allclose(given(FITTING, velocity, together, STILL), together, atol=1e-12)


def test_who_follows_whom():
    """From rest in the middle: wrists follow elbows and each other, elbows shoulders and wrists, shoulders elbows."""
    nominal = np.zeros((6, 3))
    nominal[0] = [1.0, 2.0, 3.0]  # Only the left shoulder has somewhere to go; it is a follower, too.
    a = given(TURNED, STILL, nominal, STILL)
    np.testing.assert_allclose(a[WRISTS], 0.0, atol=1e-3)
    np.testing.assert_allclose(a[1], 0.5 * nominal[0], atol=1e-3)  # Between the shoulder and the resting wrist.
    np.testing.assert_allclose(a[0], a[1], atol=1e-3)
    np.testing.assert_allclose(a[3:5], 0.0, atol=1e-3)


def test_the_second_round_follows_what_the_first_gave_the_other_hand():
    nominal = np.zeros((6, 3))
    nominal[4] = [0.0, 0.0, 2.0]  # The right elbow.
    a = given(TURNED, STILL, nominal, STILL)
    # Round 1: the right wrist takes the elbow's 2. Round 2: the left wrist is between its still elbow and that wrist,
    # the right wrist between its elbow and the left wrist, which round 1 left still.
    np.testing.assert_allclose(a[2], [0.0, 0.0, 1.0], atol=1e-3)
    np.testing.assert_allclose(a[5], [0.0, 0.0, 1.0], atol=1e-3)


def test_the_forearm_alone_is_the_law_on_its_axes():
    """With the hands' band wide open, (14) and (15) are `follower_acceleration` towards the elbow."""
    x, velocity, nominal, previous = random_state(3)
    bands = BANDS.copy()
    bands[0, HANDS], bands[1, HANDS] = -50.0, 50.0
    a = given(x, velocity, nominal, previous, bands=bands)
    r = x[4] - x[5]
    middle = x[4] - 0.28 * r / np.linalg.norm(r)
    half = 0.01 / np.sqrt(3)
    expected = follower_acceleration(
        x[5], velocity[5], middle - half, middle + half, velocity[4], nominal[4], TAU, GAINS
    )
    np.testing.assert_allclose(a[5], expected, rtol=1e-9)


LAW_AND_READING = [(published, as_follower), (published_loop, as_loop), (published_lagged, as_lagged)]


@pytest.mark.parametrize(("law", "reading"), LAW_AND_READING)
def test_a_law_is_its_reading_less_the_nominal_acceleration(law, reading):
    x, velocity, nominal, previous = random_state(4, (3,))
    coupling = law(x, velocity, nominal, previous, BANDS, Primitive(TAU, 10 * TAU), GAINS)
    np.testing.assert_allclose(coupling, given(x, velocity, nominal, previous, reading) - nominal)


@pytest.mark.parametrize(("law", "_"), LAW_AND_READING)
def test_the_laws_broadcast_over_batches_of_states_gains_and_durations(law, _):
    x, velocity, nominal, previous = random_state(5, (7,))
    rng = np.random.default_rng(6)
    k_z, tau = rng.uniform(50, 500, (7, 1, 1)), rng.uniform(1, 9, (7, 1, 1))
    together = law(x, velocity, nominal, previous, BANDS, Primitive(tau, 50.0), PublishedGains(k_z=k_z))
    for i in range(7):
        gains = PublishedGains(k_z=float(k_z[i, 0, 0]))
        alone = law(x[i], velocity[i], nominal[i], previous[i], BANDS, Primitive(float(tau[i, 0, 0]), 50.0), gains)
        np.testing.assert_allclose(together[i], alone, rtol=1e-10, atol=1e-10)


def test_the_primitive_cancels_in_published_and_not_in_the_loop():
    """Fact 3: the wrists' own nominal acceleration has no say; in the loop it has half of it."""
    x, velocity, nominal, previous = random_state(7)
    other = nominal.copy()
    other[WRISTS] += [3.0, -2.0, 1.0]
    np.testing.assert_allclose(
        given(x, velocity, nominal, previous)[WRISTS], given(x, velocity, other, previous)[WRISTS]
    )
    loop, moved = (given(x, velocity, n, previous, as_loop) for n in (nominal, other))
    assert np.abs(moved - loop)[WRISTS].max() > 1.0


def test_the_lagged_sum_is_what_the_reading_controls():
    _, _, nominal, previous = random_state(8)
    wanted = np.random.default_rng(9).normal(size=(2, 3))
    taken = as_lagged(wanted, nominal[WRISTS], previous[WRISTS])
    np.testing.assert_allclose(taken + previous[WRISTS], nominal[WRISTS] + wanted)


def test_the_fitting_skeleton_fits():
    np.testing.assert_allclose(link_lengths(FITTING), [0.22, 0.28, 0.3, 0.28, 0.22])


@pytest.mark.parametrize("damping_times_step", [1e-3, 0.1, 1.0, 10.0])
def test_the_lagged_loop_is_unstable_for_any_gain_and_step(damping_times_step):
    """a_k = -a_(k-1) - c v_k, v_(k+1) = v_k + dt a_k: an eigenvalue below -1, by the package's own reading."""
    c, dt = damping_times_step / 0.01, 0.01

    def step(v, previous):
        a = float(as_lagged(np.array(-c * v), np.array(0.0), np.array(previous)))
        return v + dt * a, a

    matrix = np.array([step(1.0, 0.0), step(0.0, 1.0)]).T
    eigenvalues = np.sort(np.linalg.eigvals(matrix).real)
    assert eigenvalues[0] < -1.0
    assert eigenvalues[0] == pytest.approx(-0.5 * c * dt - np.sqrt(1.0 + (0.5 * c * dt) ** 2))
