"""A recorded scene, opened in a headless browser as a person would open it."""

import numpy as np
import pytest
from browser import coloured, needs_browser, open_at
from pydrake.common.value import Value
from pydrake.geometry import (
    Box,
    FramePoseVector,
    GeometryFrame,
    GeometryInstance,
    MakePhongIllustrationProperties,
    MeshcatVisualizer,
    MeshcatVisualizerParams,
    Rgba,
    SceneGraph,
    Sphere,
)
from pydrake.math import RigidTransform
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder, LeafSystem

from drake_blfdmp.evaluation.carry_out import GHOST_AT
from drake_blfdmp.viewing.meshcat_scene import set_scene_camera, start_meshcat, write_scene_html
from drake_blfdmp.viewing.skeleton_drawer import LEGEND, SkeletonDrawer, SkeletonGhost
from drake_blfdmp.viewing.stage import add_stage

DURATION = 10.0


class MovingPerson(LeafSystem):
    """Hands that rise and part; the box stays between them; the hands' link leaves its band halfway."""

    def __init__(self, source_id, frame_id):
        super().__init__()
        self._source, self._frame = source_id, frame_id
        self.DeclareVectorOutputPort("points", 18, self._points)
        self.DeclareVectorOutputPort("margin", 5, self._margin)
        self.DeclareAbstractOutputPort("pose", lambda: Value(FramePoseVector()), self._pose)

    def _points(self, context, output):
        u = context.get_time() / DURATION
        half, height = 0.10 + 0.20 * u, 0.7 + 0.5 * u
        left = np.array([[-0.18, 0.0, 1.3], [-0.32, 0.1, 1.1], [-half, 0.35, height]])
        output.SetFromVector(np.concatenate([left, left * [-1, 1, 1]]).ravel())

    def _margin(self, context, output):
        output.SetFromVector([0.5, 0.5, 0.5 - context.get_time() / DURATION, 0.5, 0.1])

    def _pose(self, context, output):
        poses = FramePoseVector()
        poses.set_value(self._frame, RigidTransform([0.0, 0.35, 0.7 + 0.5 * context.get_time() / DURATION]))
        output.set_value(poses)


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    meshcat = start_meshcat(port=0)
    builder = DiagramBuilder()
    scene_graph = builder.AddSystem(SceneGraph())
    source = scene_graph.RegisterSource("person")
    frame = scene_graph.RegisterFrame(source, GeometryFrame("box"))
    box = GeometryInstance(RigidTransform(), Box(0.15, 0.2, 0.2), "box")
    box.set_illustration_properties(MakePhongIllustrationProperties([0.2, 0.3, 0.8, 1.0]))
    scene_graph.RegisterGeometry(source, frame, box)
    person = builder.AddSystem(MovingPerson(source, frame))
    builder.Connect(person.GetOutputPort("pose"), scene_graph.get_source_pose_port(source))
    MeshcatVisualizer.AddToBuilder(builder, scene_graph, meshcat, MeshcatVisualizerParams(publish_period=1 / 32))
    ghost = SkeletonGhost(meshcat, opacity=1.0, radius=0.02)
    points, margin = person.GetOutputPort("points"), person.GetOutputPort("margin")
    SkeletonDrawer.AddToBuilder(builder, points, ghost, margin_port=margin)
    set_scene_camera(meshcat, (0.0, 1.6, 1.2), (0.0, 0.2, 1.0))
    simulator = Simulator(builder.Build())
    meshcat.StartRecording(frames_per_second=32, set_visualizations_while_recording=False)
    simulator.AdvanceTo(DURATION)
    path = tmp_path_factory.mktemp("scene") / "scene.html"
    return write_scene_html(meshcat, path, title="Hold and place", legend=LEGEND)


def test_ten_seconds_make_a_page_under_five_megabytes(page):
    assert page.stat().st_size < 5e6


@needs_browser
def test_the_page_plays_and_shows_a_link_leave_its_band(page, tmp_path):
    seen = []
    for time in (0.5, 9.5):
        directory = tmp_path / str(time)
        directory.mkdir()
        pixels, errors = open_at(page, time, directory)
        assert not errors
        assert pixels.std() > 0.05, "blank"
        # Only the scene: neither the controls above nor the caption in the lower left corner.
        seen.append(pixels[30:, 240:])
    early, late = seen
    assert np.mean(np.any(np.abs(early - late) > 0.1, axis=-1)) > 0.01, "nothing moved"
    assert min(coloured(pixels, 0, 0, 1) for pixels in seen) > 500, "no box"
    assert coloured(early, 1, 0, 0) < 20, "red before any link left its band"
    assert coloured(late, 1, 0, 0) > 200, "no red link"


@pytest.fixture(scope="module")
def standing(tmp_path_factory):
    """The page of a person beside where the arms stand, as a run shows them, and nothing that is recorded."""
    meshcat = start_meshcat(port=0)
    set_scene_camera(meshcat)
    add_stage(meshcat)
    x = np.array([[-0.18, 0.0, 0.0], [-0.3, 0.05, -0.2], [-0.15, 0.3, -0.3]])
    points = np.concatenate([x, x * [-1, 1, 1]]) + GHOST_AT
    SkeletonGhost(meshcat).draw(points, [0.5, 0.5, 0.1, 0.5, -0.1], hands_band=(0.2, 0.36))
    # The robots' farthest corner stands for them.
    meshcat.SetObject("/corner", Sphere(0.05), Rgba(1.0, 0.0, 1.0, 1.0))
    meshcat.SetTransform("/corner", RigidTransform([-0.5, 0.3, 0.8]))
    return write_scene_html(meshcat, tmp_path_factory.mktemp("standing") / "scene.html", title="Person")


@needs_browser
@pytest.mark.parametrize("size", [(1200, 500), (420, 700)])
def test_wide_and_narrow_windows_show_the_whole_person_the_bands_and_the_arms_place(standing, tmp_path, size):
    script = 'viewer.set_property(["stage"], "visible", false); viewer.hide_background();'
    pixels, errors = open_at(standing, 0.0, tmp_path, size=size, script=script)
    assert not errors
    shown = pixels.copy()
    height, width = shown.shape[:2]
    shown[:22, width - 250 :] = 1.0  # The controls.
    shown[height - 70 :, : width // 2] = 1.0  # The caption.
    person = np.argwhere(np.ptp(shown, axis=-1) > 0.03)  # The body is bluish; what is behind it is white.
    top, left = person.min(axis=0)
    bottom, right = person.max(axis=0)
    assert top > 0 and left > 0 and right < width - 1 and bottom < height - 1, "cut off"
    assert bottom - top > 0.35 * height, "small"
    assert coloured(shown, 1, 0, 1) > 20, "the arms' farthest corner is out of sight"
    assert coloured(shown, 1, 0, 0) > 20, "the link outside its band is not red"
    assert np.sum(shown[..., 1] > shown[..., 0] + 0.3) > 100, "links inside their bands are not green"
    amber = (shown[..., 0] > shown[..., 1] + 0.1) & (shown[..., 1] > shown[..., 2] + 0.25)
    sleeves = (shown[..., 2] > shown[..., 0] + 0.3) & (shown[..., 2] > shown[..., 1] + 0.1)
    assert amber.sum() > 20, "the hands' link, near its band's edge, is not amber"
    assert sleeves.sum() > 100, "no sleeves"


@needs_browser
def test_an_error_on_the_page_would_be_noticed(page, tmp_path):
    _, errors = open_at(page, 1.0, tmp_path, script="no_such_function();")
    assert len(errors) == 1 and "no_such_function" in errors[0]
