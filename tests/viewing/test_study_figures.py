"""Drawings of the studies: what is drawn is what was handed over, and what differs looks different."""

import numpy as np

from drake_blfdmp.robot.redundancy import REDUNDANCIES
from drake_blfdmp.skill.laws import LAWS
from drake_blfdmp.viewing import style
from drake_blfdmp.viewing.law_style import LAW_LOOKS
from drake_blfdmp.viewing.study_figures import frankas, generalisation, random_problems, sampling


def test_every_redundancy_resolution_has_a_look_that_differs_in_colour_and_line():
    assert tuple(frankas.LOOKS) == REDUNDANCIES
    assert len({look["color"] for look in frankas.LOOKS.values()}) == len(REDUNDANCIES)
    assert len({look.get("linestyle", "-") for look in frankas.LOOKS.values()}) == len(REDUNDANCIES)


def test_a_laws_second_run_has_its_colour_and_its_own_line_and_name():
    first, second = random_problems.look("published"), random_problems.look("published, wider funnel")
    assert first == LAW_LOOKS["published"]
    assert second["color"] == first["color"] and second["linestyle"] != first["linestyle"]
    assert second["label"] == "published, wider funnel"


def test_shares_stand_where_their_intervals_are():
    figure = random_problems.shares({"default": (0, 1000, 0.0, 0.0037), "none": (900, 1000, 0.88, 0.918)})
    (axis,) = figure.axes
    assert [text.get_text() for text in axis.texts if text.get_text()] == ["0 of 1000", "900 of 1000"]
    drawn = [line.get_xdata() for line in axis.lines]
    np.testing.assert_allclose(np.concatenate([np.ravel(x) for x in drawn]), [0.37, 88.0, 91.8, 90.0])
    assert axis.get_xlim()[0] < 0.37 / 2


def test_the_share_of_problems_rises_when_they_leave():
    figure = random_problems.first_times({"none": np.array([0.1, 0.5, np.inf, 0.2])})
    x, y = figure.axes[0].lines[0].get_data()
    np.testing.assert_allclose(x, [5e-4, 0.1, 0.2, 0.5, 1.0])
    np.testing.assert_allclose(y, [0.0, 25.0, 50.0, 75.0, 75.0])


def test_margins_of_bones_and_hands_are_counted_apart():
    least = np.full((40, 5), 0.15)
    least[:10, 2], least[:, 0] = 0.05, 0.1
    (axis,) = random_problems.least_margins(least).axes
    assert [handle.get_label() for handle in axis.patches] == ["bones, least of four", "hands"]
    with_hands = axis.patches[1].get_path().vertices[:, 1]
    assert {10.0, 30.0} <= set(with_hands) and 40.0 in axis.patches[0].get_path().vertices[:, 1]


def test_regions_show_shares_and_both_bounds():
    shares = {"k_2 = 2.5 k_1": np.array([[100.0, 50.0], [0.0, 0.4]]), "other": np.full((2, 2), np.nan)}
    fine = np.geomspace(8.0, 32.0, 200)
    bounds = dict.fromkeys(shares, np.stack([np.full(200, 100.0), fine]))
    figure = sampling.regions(shares, (8.0, 32.0), (10.0, 1000.0), fine, bounds)
    left, right, bar = figure.axes
    assert sorted(text.get_text() for text in left.texts) == ["0.4", "100", "50"]
    assert not right.texts
    enforced, linear = left.lines
    np.testing.assert_allclose(enforced.get_ydata(), 0.5)  # 100 Hz: half way, on a logarithm, from 10 to 1000.
    np.testing.assert_allclose(np.diff(linear.get_ydata()[[50, 150]]) > 0, True)
    assert np.isnan(linear.get_ydata()[0])  # 8 Hz is below the panel.
    assert left.get_title() == "$k_2$ = 2.5 $k_1$" and "%" in bar.get_ylabel()


def test_every_law_has_its_marker_in_every_panel():
    columns = {"left_percent": 50.0, "end_hands_mean_m": 0.01, "path_mean_m": 0.0}
    laws = ("default", "none", "published")
    assert set(laws) <= set(LAWS)
    figure = generalisation.overview({(case, law): columns for case in ("one", "other") for law in laws})
    for axis, shown in zip(figure.axes, (2, 2, 0), strict=True):  # Zero has no place on a logarithmic axis.
        markers = [line for line in axis.lines if line.get_marker() in "osD"]
        assert [len(line.get_xdata()) for line in markers] == [shown] * 3
    assert [label.get_text() for label in figure.axes[0].get_yticklabels()] == ["one", "other"]


def test_examples_draw_goal_followers_and_distances():
    t = np.linspace(0.0, 1.0, 5)
    curves = [generalisation.Curve(f"curve {i}", t, t + i) for i in range(3)]
    figure = generalisation.examples(curves[0], {"none": 2 * t, "default": 3 * t}, {"one": curves, "other": curves[:2]})
    assert figure.get_figwidth() == style.PAGE
    counts = [len(axis.lines) for axis in figure.axes]
    assert counts == [3, 3, 2]
    np.testing.assert_array_equal(figure.axes[0].lines[2].get_ydata(), 3 * t)
    assert [axis.get_title() for axis in figure.axes[1:]] == ["one", "other"]
    for axis in figure.axes[1:]:
        looks = {(line.get_color(), line.get_linestyle()) for line in axis.lines}
        assert len(looks) == len(axis.lines)


def test_swivel_angles_are_what_was_asked_plus_the_error(run_log):
    error, off = np.tile([0.1, -0.2], (len(run_log.t), 1)), np.tile([0.01, 0.02], (len(run_log.t), 1))
    runs = {
        name: frankas.Swivels(run_log.swivel_desired, factor * error, off)
        for name, factor in (("swivel", 1), ("none", 2))
    }
    figure = frankas.swivel_angles(run_log.t, runs, run_log.events)
    for arm, (upper, lower) in enumerate(zip(figure.axes[:2], figure.axes[2:], strict=True)):
        right, none, asked = (np.asarray(line.get_ydata()) for line in upper.lines[:3])
        np.testing.assert_allclose(right - asked, np.rad2deg(error[:, arm]))
        np.testing.assert_allclose(none - asked, 2 * np.rad2deg(error[:, arm]))
        np.testing.assert_allclose(lower.lines[0].get_ydata(), 1e3 * off[:, arm])
