"""The phases of a carry from forces, heights and speeds made by hand."""

import numpy as np
import pytest

from drake_blfdmp.robot.box import TableParameters
from drake_blfdmp.robot.carry_phases import DEFAULT_THRESHOLDS, PHASES, height_above, next_state, transitions

DT = 0.02
T = np.arange(0.0, 10.0, DT)
IN_ORDER = ["contact", "lift", "carry", "lower", "release", "placed"]


def ramp(start, end, first=0.0, last=1.0):
    """From `first` to `last`, smoothly, between two times."""
    u = np.clip((T - start) / (end - start), 0.0, 1.0)
    return first + (last - first) * u**3 * (10 - 15 * u + 6 * u**2)


FORCE = 60.0 * (ramp(1.0, 1.4) - ramp(8.0, 8.4))
HEIGHT = 0.25 * (ramp(2.0, 4.0) - ramp(5.0, 7.0))


def recognise(force=FORCE, height=HEIGHT, sideways=0.0):
    """Names and times for a squeeze (N,) or (N, 2), N, and a height above the support (N,), m."""
    force = np.broadcast_to(np.reshape(force, (len(T), -1)), (len(T), 2))
    vertical = np.gradient(np.where(np.isfinite(height), height, 0.25), DT)
    state, phases = np.zeros(4), [0.0]
    for k, t in enumerate(T):
        state = next_state(state, t, force[k], height[k], [sideways, 0.0, vertical[k]])
        phases.append(state[0])
    return transitions(np.append(T, T[-1] + DT), phases)


def names(*args, **options):
    return [name for name, _ in recognise(*args, **options)]


def test_a_whole_carry_has_every_phase_once_and_in_order():
    found = dict(recognise())
    assert list(found) == IN_ORDER
    for name, about in (
        ("contact", 1.1),
        ("lift", 2.5),
        ("carry", 3.9),
        ("lower", 5.3),
        ("release", 8.25),
        ("placed", 8.4),
    ):
        assert found[name] == pytest.approx(about, abs=0.2), name


def test_without_contact_there_is_free_space_alone():
    assert names(force=0.0 * T, height=0.0 * T) == []
    assert names(force=0.4 * np.ones_like(T), height=0.0 * T) == []


def test_one_palm_alone_touches_but_does_not_lift():
    assert names(force=np.stack([FORCE, 0 * FORCE], axis=-1), height=0.0 * T) == ["contact", "free_space"]


def test_noise_on_forces_and_speeds_does_not_chatter():
    rng = np.random.default_rng(0)
    force = np.maximum(FORCE[:, None] + np.where(FORCE[:, None] > 1.0, rng.normal(0.0, 4.0, (len(T), 2)), 0.0), 0.0)
    height = HEIGHT + np.where(HEIGHT > 0.01, rng.normal(0.0, 1e-4, len(T)), 0.0)  # 3.5 mm/s of noise.
    assert names(force=force, height=height) == IN_ORDER


def test_contact_that_comes_and_goes_every_sample_is_none():
    chatter = np.where(np.arange(len(T)) % 2, 5.0, 0.0)
    assert names(force=chatter, height=0.0 * T) == []


def test_a_force_between_the_thresholds_changes_nothing():
    middle = 0.5 * (DEFAULT_THRESHOLDS.touch_n + DEFAULT_THRESHOLDS.free_n)
    force = np.where(T < 2.0, 0.0, np.where(T < 4.0, 10.0, middle))
    assert names(force=force, height=0.0 * T) == ["contact"]


def test_a_box_that_is_dropped_is_said_to_be_and_can_be_caught_again():
    force = np.where((T > 4.4) & (T < 4.6), 0.0, FORCE)
    found = names(force=force)
    assert found[:4] == ["contact", "lift", "carry", "dropped"]
    assert found[4] == "lift" and found[-2:] == ["release", "placed"]
    lost = np.where(T > 4.4, 0.0, FORCE)
    assert names(force=lost) == ["contact", "lift", "carry", "dropped"]
    slipping = np.stack([FORCE, lost], axis=-1)
    assert "dropped" in names(force=slipping)


def test_a_box_carried_beside_the_table_is_in_the_air():
    height = np.where((T > 4.2) & (T < 4.8), np.inf, HEIGHT)
    assert names(height=height) == IN_ORDER


def test_a_box_that_still_slides_is_not_placed():
    assert names(sideways=0.05)[-1] == "release"


def test_a_second_carry_begins_with_contact():
    force = FORCE + 60.0 * (ramp(9.0, 9.2))
    assert names(force=force) == [*IN_ORDER, "contact"]


def test_a_phase_counts_from_when_it_has_lasted():
    step = np.where(T >= 3.0 - 1e-9, 10.0, 0.0)
    ((name, t),) = recognise(force=step, height=0.0 * T)
    assert name == "contact"
    assert t == pytest.approx(3.0 + DEFAULT_THRESHOLDS.dwell_s + DT)  # Seen one sample after the update.


def test_the_height_is_above_the_table_beneath():
    tables = [TableParameters("low", (0.0, 0.5, 0.4), (0.2, 0.2)), TableParameters("high", (0.5, 0.5, 0.7), (0.2, 0.2))]
    assert height_above(tables, [0.05, 0.45, 0.6], 0.1) == pytest.approx(0.1)
    assert height_above(tables, [0.55, 0.45, 0.8], 0.1) == pytest.approx(0.0)
    assert height_above(tables, [0.3, 0.5, 0.8], 0.1) == np.inf
    assert height_above([], [0.0, 0.0, 1.0], 0.1) == np.inf


def test_transitions_name_what_is_entered():
    assert transitions([0.0, 1.0, 2.0, 3.0], [0, 1, 1, 2]) == ((PHASES[1], 1.0), (PHASES[2], 3.0))
    assert transitions([0.0, 1.0], [0, 0]) == ()
