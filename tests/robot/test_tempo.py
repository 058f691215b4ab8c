"""The tempo: where it settles, that it neither overshoots nor chatters, its floor."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from drake_blfdmp.robot.tempo import next_tempo, tempo_towards

STEP, FALL, RISE, FLOOR = 0.004, 0.02, 0.5, 0.05
CONSTANTS = STEP, FALL, RISE, FLOOR


def run(capacity, tempo=1.0, steps=1000):
    """The loop: limits that let `capacity` of the full speed through, asked for `tempo` of it."""
    history = [tempo]
    for _ in range(steps):
        tempo = next_tempo(tempo, min(1.0, capacity / tempo), *CONSTANTS)
        history.append(tempo)
    return np.array(history)


@given(st.floats(0.1, 1.0), st.floats(0.06, 1.0))
def test_it_settles_at_what_the_limits_allow_from_one_side_and_stays(capacity, start):
    history = run(capacity, start)
    up, down = -np.expm1(-STEP / RISE), -np.expm1(-STEP / FALL)
    assert history[-1] == pytest.approx((up + down * capacity) / (up + down), abs=1e-3)
    assert -1e-3 <= history[-1] - capacity <= 0.05
    # No overshoot: it comes from one side.
    assert np.all(np.diff(history) * np.sign(history[-1] - start) >= -1e-12)


@given(st.lists(st.floats(0.0, 1.0), min_size=1, max_size=60))
def test_whatever_the_shares_it_stays_between_floor_and_one_and_moves_by_little(shares):
    tempo = 1.0
    for share in shares:
        last, tempo = tempo, next_tempo(tempo, share, *CONSTANTS)
        assert FLOOR <= tempo <= 1.0
        assert -STEP / FALL <= tempo - last <= STEP / RISE


def test_nothing_to_hold_back_is_tempo_one_to_the_bit():
    assert next_tempo(1.0, 1.0, *CONSTANTS) == 1.0


def test_it_comes_back_and_never_stops_for_good():
    tempo = 1.0
    for _ in range(200):
        tempo = next_tempo(tempo, 0.0, *CONSTANTS)
    assert tempo == FLOOR
    for _ in range(int(5 * RISE / STEP)):
        tempo = next_tempo(tempo, 1.0, *CONSTANTS)
    assert tempo > 0.99


@pytest.mark.parametrize(("start", "wanted", "constant"), [(1.0, 0.3, FALL), (0.3, 1.0, RISE)])
def test_towards_a_wanted_tempo_it_goes_exponentially_quick_down_and_slow_up(start, wanted, constant):
    tempo = start
    for _ in range(20):
        tempo = tempo_towards(tempo, wanted, STEP, FALL, RISE)
    assert tempo == pytest.approx(wanted + (start - wanted) * np.exp(-20 * STEP / constant), rel=1e-12)
    assert tempo_towards(wanted, wanted, STEP, FALL, RISE) == wanted
