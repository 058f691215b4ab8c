"""Drawings of the study of squeezing: what is drawn is what was handed over."""

import numpy as np
from matplotlib.patches import Rectangle

from drake_blfdmp.viewing import style
from drake_blfdmp.viewing.study_figures import squeeze

FORCE = np.array([10.0, 50.0, 100.0])


def test_deformation_is_in_millimetres_markers_beside_lines():
    measured = {1e6: 1e-6 * FORCE, 1e5: 1e-5 * FORCE}
    fine = np.geomspace(10.0, 100.0, 100)
    (axis,) = squeeze.deformation(FORCE, measured, fine, {modulus: fine / modulus for modulus in measured}, 55.0).axes
    markers = [line for line in axis.lines if str(line.get_marker()) in "osD" and len(line.get_xdata()) == 3]
    np.testing.assert_allclose([line.get_ydata() for line in markers], 1e3 * np.array(list(measured.values())))
    lines = [line for line in axis.lines if len(line.get_xdata()) == 100]
    for line, modulus in zip(lines, measured, strict=True):
        np.testing.assert_allclose(line.get_ydata(), 1e3 * np.asarray(line.get_xdata()) / modulus)
    legend = axis.figure.legends[0]
    assert [text.get_text() for text in legend.get_texts()] == ["1 MPa", "100 kPa"]
    assert [text.get_text() for text in axis.texts] == ["default 55 N"]


def test_moduli_differ_in_colour_marker_and_line():
    for key in ("color", "marker", "linestyle"):
        assert len({str(look[key]) for look in squeeze.LOOKS}) == len(squeeze.LOOKS)


def test_every_cell_has_its_force_and_ratio_and_what_is_too_much_is_framed():
    least = np.array([[1.234, 70.0], [71.0, np.nan]])
    ratio = np.array([[1.01, 1.02], [1.03, np.nan]])
    panel = (np.array([1.0, 5.0]), np.array([0.3, 0.8]), least, ratio)
    figure = squeeze.least_forces({"at rest": panel, "lifted": panel}, 70.0)
    left, right, bar = figure.axes
    for axis, title in ((left, "at rest"), (right, "lifted")):
        assert axis.get_title() == title
        assert sorted(text.get_text() for text in axis.texts) == sorted(["1.23", "1.010", "70", "1.020", "71", "1.030"])
        (frame,) = (patch for patch in axis.patches if isinstance(patch, Rectangle))
        assert frame.get_bbox().contains(0.0, 1.0) and frame.get_width() < 1.0  # First column, second row: 71 N.
        assert [label.get_text() for label in axis.get_xticklabels()] == ["0.3", "0.8"]
    assert [label.get_text() for label in left.get_yticklabels()] == ["1", "5"]
    assert "(N)" in bar.get_ylabel() and figure.get_figwidth() == style.PAGE


def test_aside_is_relative_to_the_weight_and_beside_its_predictions():
    offset, fine = np.array([0.0, 0.02]), np.linspace(0.0, 0.04, 5)
    predicted = {"disc": 1.0 + fine, "its mesh": 1.0 + 2.0 * fine}
    (axis,) = squeeze.aside(offset, np.array([6.0, 9.0]), fine, predicted, 6.0).axes
    *lines, simulated = axis.lines
    np.testing.assert_allclose(simulated.get_xdata(), [0.0, 20.0])
    np.testing.assert_allclose(simulated.get_ydata(), [1.0, 1.5])
    for line, factor in zip(lines, predicted.values(), strict=True):
        np.testing.assert_allclose(line.get_ydata(), factor)
    legend = axis.get_legend()
    assert legend is not None
    assert [text.get_text() for text in legend.get_texts()] == ["disc", "its mesh", "simulated"]
