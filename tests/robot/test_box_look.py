import numpy as np
import pytest
from pydrake.geometry import Box, Role
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
from pydrake.systems.framework import DiagramBuilder

from drake_blfdmp.robot.box import AddBox, AddTable, BoxParameters, TableParameters


def scene(parameters):
    builder = DiagramBuilder()
    plant, scene_graph = AddMultibodyPlantSceneGraph(builder, 0.002)
    box, table = AddBox(plant, parameters), AddTable(plant, TableParameters())
    plant.Finalize()
    return plant, scene_graph.model_inspector(), box, table


def parts(plant, inspector, body):
    """Name -> (8, 3) corners in the body's frame."""
    found = {}
    for geometry in plant.GetVisualGeometriesForBody(body):
        shape, name = inspector.GetShape(geometry), inspector.GetName(geometry).rsplit("::", 1)[-1]
        assert isinstance(shape, Box)
        assert name not in found
        signs = np.array(np.meshgrid(*3 * [(-0.5, 0.5)])).reshape(3, -1)
        found[name] = (inspector.GetPoseInFrame(geometry) @ (signs * shape.size()[:, None])).T
    return found


@pytest.mark.parametrize("size", [(0.30, 0.20, 0.20), (0.20, 0.15, 0.40), (0.40, 0.30, 0.12)])
def test_edges_tape_and_label_lie_on_the_faces(size):
    plant, inspector, box, _ = scene(BoxParameters(*size))
    found = parts(plant, inspector, box)
    half = 0.5 * np.array(size)
    for name, corners in found.items():
        assert np.all(np.abs(corners) < half + 0.005), f"{name} stands off the box"
    assert sum(name.startswith("box_edge") for name in found) == 12
    on_front = [name for name, corners in found.items() if corners[:, 1].min() > half[1] - 0.005 and "edge" not in name]
    assert {"box_label", "box_arrow_shaft", "box_arrow_left", "box_arrow_right"} <= set(on_front)
    # Each layer is in front of what it lies on, or it would flicker.
    tops = [found[name][:, 1].max() for name in ("box_visual", "box_tape", "box_label", "box_arrow_shaft")]
    assert np.all(np.diff(tops) > 5e-4)


def test_the_arrow_points_up():
    plant, inspector, box, _ = scene(BoxParameters())
    found = parts(plant, inspector, box)
    shaft, left, right = (found[f"box_arrow_{name}"] for name in ("shaft", "left", "right"))
    for head, inward in ((left, 1.0), (right, -1.0)):
        assert head[:, 2].mean() > shaft[:, 2].mean()
        x, z = (head[:, [0, 2]] - head[:, [0, 2]].mean(axis=0)).T
        assert inward * np.sum(x * z) > 0, "the head's bars do not lean to the tip"


def test_what_touches_is_the_box_and_the_table_alone():
    plant, inspector, box, table = scene(BoxParameters())
    (faces,) = plant.GetCollisionGeometriesForBody(box)
    np.testing.assert_array_equal(inspector.GetShape(faces).size(), BoxParameters().size)
    assert len(plant.GetCollisionGeometriesForBody(table)) == 2  # Slab and leg.
    for geometry in [*plant.GetVisualGeometriesForBody(box), *plant.GetVisualGeometriesForBody(table)]:
        assert inspector.GetProperties(geometry, Role.kProximity) is None
