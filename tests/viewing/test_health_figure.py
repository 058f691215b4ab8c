import numpy as np
import pytest
from matplotlib.image import imread
from synthetic_carry import carry, recording

from drake_blfdmp.demonstration.health import examine
from drake_blfdmp.viewing.health_figure import health_figure
from drake_blfdmp.viewing.style import save

T, X = carry()


def panels(figure):
    return [axis.get_title(loc="left") for axis in figure.axes]


def labels(axis):
    return [text.get_text() for text in axis.get_legend().get_texts()]


def test_it_shows_what_the_report_says(tmp_path):
    figure = health_figure(examine(recording(T, X)))
    assert panels(figure)[:2] == ["bones as recorded", "from hand to hand"]
    assert panels(figure)[2] == "clock: 0 dropped, 0 repeated, 0 late"
    assert "held in both hands" in labels(figure.axes[1])
    assert labels(figure.axes[3]) == ["seen"]
    pixels = imread(save(figure, tmp_path / "a.png"))
    assert pixels[..., :3].std() > 0.05


@pytest.mark.parametrize("case", ["refused", "missing", "one sample", "one time"])
def test_a_sick_recording_is_drawn_too(case, tmp_path):
    t, x = T.copy(), X.copy()
    if case == "refused":
        x[:, 4] = np.nan
    elif case == "missing":
        x[10:60, 2] = np.nan
    elif case == "one sample":
        t, x = t[:1], x[:1]
    else:
        t[:] = 3.0
    figure = health_figure(examine(recording(t, x)))
    if case in ("refused", "missing"):
        assert "missing" in labels(figure.axes[3])
    if case != "missing":
        assert "held in both hands" not in labels(figure.axes[1])
    assert save(figure, tmp_path / "a.png").stat().st_size > 10_000
