"""What can be kept as a drawing, and what a file may not call."""

import json
import subprocess
import sys
from dataclasses import dataclass

import numpy as np
import pytest
from matplotlib.figure import Figure

from drake_blfdmp.recording.plain_data import PlainDataError, npz_bytes
from drake_blfdmp.viewing import style
from drake_blfdmp.viewing.drawing import Drawing, stems
from drake_blfdmp.viewing.rendering import Triangles
from drake_blfdmp.viewing.solids import Solid
from drake_blfdmp.viewing.study_figures import frankas, generalisation, random_problems

TIMES = {"none": np.array([0.1, np.inf, 0.4])}
T = np.linspace(0.0, 1.0, 5)


def kept(drawing):
    return {name: data for name, (data, _) in drawing.attachments("f").items()}


def told(drawn_by, given=None, **arrays):
    text = json.dumps({"drawn_by": drawn_by, "from": {"map": []} if given is None else given})
    return {"figures/f.json": text.encode(), "figures/f.npz": npz_bytes(arrays)}


def test_a_drawing_is_kept_by_names_and_drawn_from_what_is_kept():
    curve = generalisation.Curve("goal", T, T**2)
    attachments = kept(
        Drawing(generalisation.examples, curve, distances={"a": [curve], "b": (curve,)}, followers={"none": T})
    )
    assert stems(attachments) == ["f"]
    assert json.loads(attachments["figures/f.json"])["drawn_by"] == "study_figures.generalisation.examples"
    drawing = Drawing.of("f", attachments)
    assert set(drawing.given) == {"goal", "followers", "distances"}
    assert isinstance(drawing.given["goal"], generalisation.Curve)
    line = drawing.figure().axes[0].lines[0]
    np.testing.assert_array_equal(line.get_ydata(), T**2)


def test_a_scene_is_kept_as_its_bodies_and_their_poses():
    solids = [Solid("capsule", (0.1, 0.4), (0.5, 0.5, 0.5)), Triangles(np.eye(3)[None], np.ones((1, 3)))]
    points = np.random.default_rng(0).normal(size=(1, 6, 3))
    inside = np.ones((1, 5), dtype=bool)
    shown = frankas.Instants(["carry"], points, points, inside, inside, solids, np.tile(np.eye(3, 4), (1, 2, 1, 1)))
    found = Drawing.of("f", kept(Drawing(frankas.pictures, shown, pixels=40))).given["shown"]
    assert found.solids[0] == solids[0]
    np.testing.assert_array_equal(found.solids[1].corners, solids[1].corners)
    np.testing.assert_array_equal(found.poses, shown.poses)


@style.styled
def of_a_test(values):
    return Figure()


def plain():
    return Figure()


@pytest.mark.parametrize("make", [of_a_test, plain, style.save, print, Figure])
def test_only_drawings_of_this_package_can_be_kept(make):
    with pytest.raises(PlainDataError, match="none that can be found again"):
        Drawing(make)


def test_other_arguments_are_refused_where_they_are_given():
    with pytest.raises(TypeError):
        Drawing(random_problems.first_times, TIMES, 2)
    with pytest.raises(PlainDataError, match="plain data: relative > none is of the kind 'function'"):
        Drawing(random_problems.first_times, {"none": plain}).attachments("f")
    with pytest.raises(PlainDataError, match="this version has no dataclass"):
        Drawing(random_problems.first_times, Foreign(TIMES)).attachments("f")


@dataclass(frozen=True)
class Foreign:
    """Of a module that nobody vouches for."""

    values: dict


UNKNOWN = (
    "study_figures.random_problems.of_tomorrow",
    "study_figures.tomorrow.shares",
    "study_figures.random_problems.look",  # There, but no drawing.
    "study_figures.random_problems.LAW_LOOKS",
    "study_figures.axis_errors",  # There, but another module's own.
    "style.styled",
    "style.matplotlib",
    "os.system",
    "..evaluation.console.ProgressBar",
    "study_figures.laws._frame",
    "",
)


@pytest.mark.parametrize("name", UNKNOWN)
def test_a_name_that_is_no_drawing_of_this_version_is_refused(name):
    with pytest.raises(PlainDataError) as caught:
        Drawing.of("f", told(name))
    assert str(caught.value) == f"this version has no drawing '{name}'; use a newer drake_blfdmp"


@pytest.mark.parametrize("name", ["study_figures.laws.Tomorrow", "style.Path", "study_figures.laws.learning", "x"])
def test_a_name_that_is_no_dataclass_of_this_version_is_refused(name):
    given = {"map": [["relative", {"record": [name, {}]}]]}
    with pytest.raises(PlainDataError, match=f"this version has no dataclass '{name}'"):
        Drawing.of("f", told("study_figures.random_problems.first_times", given))


def test_arguments_of_another_version_and_missing_parts_are_said_in_one_line():
    name = "study_figures.random_problems.first_times"
    other = {"map": [["absolute", 1.0]]}
    cases = {
        "takes other arguments (": told(name, other),
        "takes other arguments ((": told(name, [1, 2]),
        "neither what draws it nor from what": told(None),
        "attachment 'figures/f.npz' is missing": {"figures/f.json": b"{}"},
        "structure cannot be read": told(name) | {"figures/f.json": b"{"},
        "arrays cannot be read": told(name) | {"figures/f.npz": b"PK"},
    }
    for words, attachments in cases.items():
        with pytest.raises(PlainDataError) as caught:
            Drawing.of("f", attachments)
        assert words.replace("((", "(") in str(caught.value) and "\n" not in str(caught.value)


def test_neither_studies_nor_drake_are_needed():
    code = (
        "import sys\nsys.modules['pydrake'] = None\nfrom drake_blfdmp.viewing.redrawing import redraw_study\n"
        "from drake_blfdmp.viewing.study_figures import "
        "feedback, frankas, generalisation, laws, noise, one_axis, random_problems, robustness, sampling, squeeze, "
        "trajectories\nsys.exit(any(name.startswith('drake_blfdmp.evaluation') for name in sys.modules))"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
