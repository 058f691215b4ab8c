"""Drawings of the studies of the laws: what is drawn is what was handed over."""

import numpy as np
import pytest

from drake_blfdmp.skill.bands import make_bands
from drake_blfdmp.skill.laws import LAWS
from drake_blfdmp.skill.profiles import ConstantDistance
from drake_blfdmp.viewing.law_style import LAW_LOOKS
from drake_blfdmp.viewing.study_figures import laws, one_axis

T = np.linspace(0.0, 4.0, 401)
BANDS = make_bands(0.22, 0.28, ConstantDistance(0.3))


def drawn(axis, name):
    return next(line for line in axis.lines if line.get_label() == LAW_LOOKS[name]["label"])


def hand_distances(curves):
    cases = dict.fromkeys(("one", "two"), laws.HandsBand.of(BANDS, T))
    learned = dict.fromkeys(cases, np.full_like(T, 0.3))
    return laws.hand_distances(
        T, np.full_like(T, 0.45), cases, dict.fromkeys(cases, curves), learned, start=1.0, rate=30.0
    )


def test_every_law_has_a_look():
    assert set(LAW_LOOKS) == set(LAWS)


def test_hand_distances_are_in_metres_and_off_d_j_in_millimetres():
    figure = hand_distances({"default": np.full_like(T, 0.302), "none": np.full_like(T, 0.4)})
    axes = np.array(figure.axes[:6]).reshape(2, 3)
    for row in axes:
        np.testing.assert_allclose(np.asarray(drawn(row[0], "default").get_ydata()), 0.302)
        np.testing.assert_allclose(np.asarray(drawn(row[2], "default").get_ydata()), 2.0)
        assert "uncoupled" not in [line.get_label() for line in row[2].lines]
        assert row[1].get_xlim() == (0.0, 1.0) and row[0].get_xlim() == (0.0, 4.0)
    assert [text.get_text() for text in figure.legends[0].get_texts()][-1] == "lagged leaves"


def test_the_cross_stands_where_the_lagged_law_leaves_its_funnel():
    lagged = np.where(T < 0.1, 0.31, 0.5)
    lagged[T > 0.2] = np.nan
    figure = hand_distances({"published_lagged": lagged})
    (cross,) = (line for line in figure.axes[1].lines if line.get_marker() == "x")
    assert np.asarray(cross.get_xdata())[0] == pytest.approx(0.1)
    assert np.asarray(cross.get_ydata())[0] == pytest.approx(0.3 + 0.01 + 0.02 * np.exp(-0.3))
    figure = hand_distances({"published_lagged": np.full_like(T, 0.3)})
    assert not [line for line in figure.axes[1].lines if line.get_marker() == "x"]


def test_links_are_shown_by_their_half_width():
    bands = BANDS.evaluate(T)
    lengths = np.broadcast_to([0.22, 0.285, 0.3, 0.28, 0.21], (len(T), 5))
    figure = laws.links_over_time(T, {"default": lengths}, bands)
    ends = [np.asarray(drawn(axis, "default").get_ydata())[-1] for axis in figure.axes[:5]]
    np.testing.assert_allclose(ends, [0.0, 0.5, 0.0, 0.0, -1.0], atol=1e-9)


def test_remark_2_counts_axes_and_ends_after_the_last():
    empty = np.zeros((len(T), 2, 3), dtype=bool)
    empty[T <= 1.0, 0, :2] = True
    figure = laws.remark_2(T, {"published": empty}, {"published": 0.02 * empty})
    counts, widening = figure.axes
    assert np.asarray(counts.lines[0].get_ydata())[0] == 2 and np.asarray(counts.lines[0].get_ydata())[-1] == 0
    assert np.asarray(widening.lines[0].get_ydata()).max() == pytest.approx(20.0)
    assert widening.get_xlim() == pytest.approx((0.0, 1.2))


def test_learning_has_two_lines_a_case():
    errors = {"constant": (np.array([2e-3, 1e-3]), np.array([1e-3, 1e-4])), "moving": (np.ones(2), np.ones(2))}
    (axis,) = laws.learning(errors, 1.0).axes
    assert [line.get_label() for line in axis.lines[:2]] == ["constant, all", "constant, from 1 s on"]
    np.testing.assert_allclose(np.asarray(axis.lines[1].get_ydata()), [1.0, 0.1])


def test_facts_end_just_after_the_lagged_law_has_left():
    t = 0.001 * np.arange(30)
    run = one_axis.Trial(t, -0.3 + 0.0 * t, np.where(t < 0.0195, 0.002, 0.02), 0.01)
    angles = {name: np.radians([10.0, 20.0, 30.0, 40.0, 50.0]) for name in ("demonstrated", "default", "published")}
    share = np.linspace(-1.0, 1.0, 5)
    rates = {"k_2 = 0": 0.0 * share, "k_2 = 1": -(share**2)}
    pair = {"as printed": run, "fed forward": run}
    goals = dict.fromkeys(("published", "published, goal 0", "loop"), run)
    figure = one_axis.facts(share, rates, pair, goals, -0.15, run, pair, angles)
    lagged, turns = figure.axes[3], figure.axes[5]
    assert lagged.get_xlim() == pytest.approx((0.0, 0.0215))
    np.testing.assert_allclose([bar.get_height() for bar in turns.patches[:5]], [10, 20, 30, 40, 50])
    ticks = [label.get_text() for label in turns.get_xticklabels()]
    assert ticks == ["left\nupper", "left\nfore", "hands", "right\nfore", "right\nupper"]


def test_growth_is_relative_to_the_first_and_beside_its_prediction():
    change = {1e-3: 5.0 * 1.5 ** np.arange(6), 1e-4: np.full(6, 2.0)}
    (axis,) = one_axis.growth(change, {1e-3: 1.5, 1e-4: 1.0}).axes
    measured, predicted = axis.lines[:2]
    np.testing.assert_allclose(np.asarray(measured.get_ydata()), np.asarray(predicted.get_ydata()))
    assert measured.get_label() == "1 ms, measured" and predicted.get_label() == "|z| = 1.5000"
