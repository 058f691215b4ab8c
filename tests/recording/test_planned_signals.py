"""The attachment of what a plan knew."""

from dataclasses import fields, replace

import numpy as np
import pytest

from drake_blfdmp.recording.mcap_file import RecorderError
from drake_blfdmp.recording.planned_signals import PlannedSignals, measured_bytes, read_measured, read_planned


@pytest.fixture
def signals():
    """Of a box that turns by half a turn about z, and of several recordings."""
    clock = np.linspace(0.0, 2.0, 41)
    x = np.random.default_rng(2).normal(size=(41, 6, 3))
    half = 0.25 * np.pi * clock
    box = np.column_stack([np.cos(half), 0 * clock, 0 * clock, np.sin(half), clock, 2 * clock, 0 * clock])
    limits = np.arange(14.0)
    return PlannedSignals(clock, x, x + 1.0, 0.1 * np.abs(x), box, -limits, limits, limits, limits)


@pytest.mark.parametrize("left_out", [(), ("spread",), ("box", "spread")])
def test_what_is_written_is_read_in_single_precision(signals, left_out):
    signals = replace(signals, **dict.fromkeys(left_out))
    data = signals.to_bytes()
    assert data == signals.to_bytes()
    found = read_planned(data, "a.mcap")
    for field in fields(PlannedSignals):
        expected, value = getattr(signals, field.name), getattr(found, field.name)
        if expected is None:
            assert value is None
        else:
            np.testing.assert_array_equal(value, expected if field.name == "clock" else np.float32(expected))


def test_between_its_samples_points_lie_on_lines_and_the_box_turns_evenly(signals):
    t = np.array([-1.0, 0.025, 1.0, 9.0])
    points = signals.points_at("uncoupled", t)
    middle = 0.5 * (signals.uncoupled[0] + signals.uncoupled[1])
    np.testing.assert_allclose(points, [signals.uncoupled[0], middle, signals.uncoupled[20], signals.uncoupled[-1]])
    half = 0.25 * np.pi * np.clip(t, 0.0, 2.0)
    np.testing.assert_allclose(signals.box_at(t)[:, 0], np.cos(half), atol=1e-12)
    np.testing.assert_allclose(signals.box_at(t)[:, 4], np.clip(t, 0.0, 2.0), atol=1e-12)
    assert replace(signals, box=None).box_at(t) is None and replace(signals, spread=None).spread_at(t) is None


@pytest.mark.parametrize(
    "change",
    [{"uncoupled": np.zeros((3, 6, 3))}, {"clock": np.zeros(41)}, {"q_lower": np.zeros(7)}, {"effort_limit": None}],
)
def test_shapes_that_do_not_fit_are_refused(signals, change):
    with pytest.raises(RecorderError, match=r"^a\.mcap: the attachment planned\.npz is not what a run has .*; record"):
        read_planned(replace(signals, **change).to_bytes(), "a.mcap")


def test_what_was_measured_comes_back_or_is_refused():
    t, clearance = read_measured(measured_bytes(np.array([0.0, 0.1]), np.array([0.5, 0.25])), "a.mcap")
    assert t.tolist() == [0.0, 0.1] and clearance.tolist() == [0.5, 0.25]
    for data in (b"", b"PK\x03\x04 torn", measured_bytes(np.zeros(2), np.zeros(3))):
        with pytest.raises(RecorderError, match=r"measured\.npz is not what a run has"):
            read_measured(data, "a.mcap")
