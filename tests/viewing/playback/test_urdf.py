import numpy as np
import pytest
from made_files import ARM

from drake_blfdmp.errors import BlfDmpError
from drake_blfdmp.viewing.playback.urdf import DEFAULT_COLOUR, parse_urdf


def test_shapes_colours_and_joints_are_read():
    robot = parse_urdf(ARM, "here")
    assert list(robot.links) == ["base", "upper", "slide", "tool", "finger"]
    (box,), (cylinder,), (sphere,), (capsule,) = (robot.links[name] for name in ("base", "upper", "slide", "tool"))
    assert (box.kind, box.size, box.colour) == ("box", (0.2, 0.2, 0.1), (0.0, 0.0, 1.0, 0.5)), "by the robot's material"
    assert (cylinder.kind, cylinder.size) == ("cylinder", (0.05, 0.4))
    assert np.allclose(cylinder.X_LV @ [0, 0, 0.2, 1], [0.4, 0, 0, 1])
    assert (sphere.kind, sphere.size, sphere.colour) == ("sphere", (0.06,), (1.0, 0.0, 0.0, 1.0)), "by another visual's"
    assert (capsule.kind, capsule.colour, capsule.painted) == ("capsule", DEFAULT_COLOUR, False)
    shoulder, rail, flange, follower = (robot.joints[name] for name in ("upper", "slide", "tool", "finger"))
    assert np.allclose(shoulder.axis, [0, 0, 1]) and shoulder.movable and not flange.movable
    assert rail.kind == "prismatic" and follower.mimic == ("rail", -0.5, 0.1)


def test_meshes_keep_name_and_scale_and_strange_shapes_are_told():
    text = """<robot name="r"><link name="l">
      <visual><geometry><mesh filename="package://p/m.stl" scale="2 1 1"/></geometry></visual>
      <visual><geometry><torus/></geometry></visual><visual/></link></robot>"""
    robot = parse_urdf(text, "here")
    (mesh,) = robot.links["l"]
    assert (mesh.kind, mesh.mesh, mesh.size) == ("mesh", "package://p/m.stl", (2.0, 1.0, 1.0))
    assert robot.warnings == ("here: link l: a torus is not drawn",)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("not xml", "is no XML"),
        ("<sdf/>", "is <sdf> in place of"),
        (ARM.replace('radius="0.05"', 'radius="wide"'), "cannot be read"),
        (ARM.replace('xyz="0 0 2"', 'xyz="0 2"'), "are not 3 numbers"),
        (ARM.replace('<parent link="base"/>', ""), "lacks a parent"),
        (ARM.replace('size="0.2 0.2 0.1"', ""), "an attribute is missing"),
    ],
)
def test_what_is_no_urdf_is_refused_in_one_line(text, said):
    with pytest.raises(BlfDmpError, match=said) as error:
        parse_urdf(text, "file: /robot_description")
    assert str(error.value).startswith("file: /robot_description") and "\n" not in str(error.value)
